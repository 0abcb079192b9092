"""Packaging (ours, not the paper's): much sheet in a small ball.

    f = area / radius³,  radius = the largest distance of a vertex from the centroid of the folded surface,

in 1/board cell, above 0. A sheet is packed well if it is large and yet stays near its middle.

Folding changes no area, and the sheet never outgrows the board; the radius is at least half of any extent of the
vertices, which only grows. Hence the bound (w − 1)(h − 1) / (largest extent/2)³ on a w×h board, extents taken along the
axes and the board's diagonals.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.state import Record, States, has_image
from origami_lab.jit import kernel
from origami_lab.objectives.compiled_objective import Array, CompiledObjective, panel_area, scored_by, sticks_out


class PackagingObjective(CompiledObjective):
    """Area of the sheet over the cube of its radius, in 1/board cell.

    Parameters
    ----------
    compactness
        Weight of the penalty on the furthest vertex.
    """

    def __init__(self, compactness: float = 0.0) -> None:
        super().__init__(best_packaging, compactness, PackagingScore)

    def numbers(self, game: Game) -> tuple[float, ...]:
        return ()


@kernel
def radius_at(s: Record, r: Record, k: int, areas: Array, enough: float, corner: Array) -> float:
    """Largest distance of a vertex from the surface's centroid at driving angle k; inf if it is ``enough`` or more.

    Parameters
    ----------
    areas
        (T,) of the representative triangles.
    corner
        (3, 3) scratch.
    """
    cx = cy = cz = total = 0.0
    for t in range(s.n_triangles):
        for j in range(3):
            place_corner(s, r, s.corners[t, j], k, corner, j)
        x = (corner[0, 0] + corner[1, 0] + corner[2, 0]) / 3.0
        y = (corner[0, 1] + corner[1, 1] + corner[2, 1]) / 3.0
        z = (corner[0, 2] + corner[1, 2] + corner[2, 2]) / 3.0
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                total += areas[t]
                cx += areas[t] * (r.matrices[g, 0] * x + r.matrices[g, 1] * y)
                cy += areas[t] * (r.matrices[g, 2] * x + r.matrices[g, 3] * y)
                cz += areas[t] * z
    cx, cy, cz = cx / total, cy / total, cz / total
    limit, farthest = enough * enough, 0.0
    for v in range(s.n_vertices):  # images are as far from the centroid, which is its own image
        x, y, z = s.position[v, k, 0] - cx, s.position[v, k, 1] - cy, s.position[v, k, 2] - cz
        farthest = max(farthest, x * x + y * y + z * z)
        if farthest >= limit:
            return np.inf
    return float(np.sqrt(farthest))


@kernel
def half_extent_at(s: Record, r: Record, k: int, low: Array, high: Array) -> float:
    """Half the largest extent of the vertices along x, y, x + y, x − y and z; ``low``, ``high`` are (5,) scratch."""
    low[:], high[:] = np.inf, -np.inf
    for v in range(s.n_vertices):
        for g in range(r.order):
            if not has_image(r, s.axis[v], g):
                continue
            a, b = s.position[v, k, 0], s.position[v, k, 1]
            x, y = r.matrices[g, 0] * a + r.matrices[g, 1] * b, r.matrices[g, 2] * a + r.matrices[g, 3] * b
            along = (x, y, (x + y) * np.sqrt(0.5), (x - y) * np.sqrt(0.5), float(s.position[v, k, 2]))
            for j in range(5):
                low[j], high[j] = min(low[j], along[j]), max(high[j], along[j])
    return 0.5 * np.max(high - low)


@kernel
def best_packaging(
    states: States, i: int, rules: States, numbers: Array, bound: bool, above: float
) -> tuple[float, int]:
    """See :data:`~origami_lab.objectives.compiled_objective.Best`; ``numbers`` are compactness alone."""
    s, r = states[i], rules[0]
    best, angle = above, -1
    areas = np.empty(s.n_triangles)
    total = 0.0
    for t in range(s.n_triangles):
        areas[t] = panel_area(s, r, t)
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                total += areas[t]
    if bound:
        total = float(4 * r.half_x * r.half_y)
    corner, low, high = np.empty((3, 3)), np.empty(5), np.empty(5)
    for k in range(r.min_reach - 1, s.reach):
        penalty = sticks_out(s, k, numbers[0])
        least = best + penalty
        if s.n_vertices == 0:  # the empty board has a bound, too
            return np.inf, k
        if bound:
            radius = half_extent_at(s, r, k, low, high)
        else:
            # a little more than the radius that would do, so that rounding excludes nothing
            enough = (total / least) ** (1.0 / 3.0) * (1.0 + 1e-12) if least > 0.0 else np.inf
            radius = radius_at(s, r, k, areas, enough, corner)
        value = total / radius**3 - penalty
        if value > best:
            best, angle = value, k
    return best, angle


@scored_by(best_packaging)
class PackagingScore(NamedTuple):
    """The compiled score; ``numbers`` are those of :func:`best_packaging`."""

    numbers: Array
