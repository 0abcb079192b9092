"""A shelf (paper, sections 3.6.2 and F.2): parallel boards, the smallest as large as possible.

The folded triangles are grouped into sets of parallel ones, those into levels: f is the area of a set's smallest
level, the best set of at least three levels counts; without one f = 0. In square board cells, a multiple of ½, from 0
to (w − 1)(h − 1)/3 on a w×h board.

Parallel are triangles with |cos| > 0.99999 between their normals, and those that others connect. A level ends where
the next triangle's plane is 0.5 board cells further from the origin, or more. (A smallest triangle, as slivers may
want one, is of no use here: on the board none has less area than ½.)

Areas do not change when a sheet is folded, so all of it together bounds what three levels share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.state import Record, States, has_image
from origami_lab.jit import kernel
from origami_lab.objectives.compiled_objective import TIE, Array, CompiledObjective, panel_area, scored_by, sticks_out
from origami_lab.objectives.objective import checked_number

PARALLEL = 0.99999
"""|cos| between the normals of parallel triangles: within 0.256 degrees."""
SAME = 1.0 - 1e-13
"""|cos| between normals that are not told apart: within 4.5e-7 radians."""


class ShelfObjective(CompiledObjective):
    """The area of the smallest level of the best set of parallel ones, in square board cells.

    Parameters
    ----------
    levels
        How many levels a shelf has at least: the paper's 3.
    gap
        Distance between neighbouring levels at least, in board cells.
    compactness
        Weight of the penalty on the furthest vertex.
    """

    def __init__(self, levels: int = 3, gap: float = 0.5, compactness: float = 0.0) -> None:
        super().__init__(best_shelf, compactness, ShelfScore)
        self.levels = checked_number("levels", levels, 1)
        if self.levels != int(self.levels):
            raise InputError("objective.levels", levels, "must be a whole number of boards")
        self.gap = checked_number("gap", gap, 1e-6)

    def numbers(self, game: Game) -> tuple[float, ...]:
        return (self.levels, self.gap)

    def up(self, design: CreasePattern) -> tuple[float, float, float]:
        """Across the boards of the best set, upwards where they lean."""
        corners = design.folded[design.best][design.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        doubled = np.linalg.norm(normals, axis=1)
        normals /= doubled[:, None]
        best, up = 0.0, np.array([0.0, 0.0, 1.0])
        for normal in normals:
            members = np.abs(normals @ normal) > PARALLEL
            offsets, areas = corners[members, 0] @ normal, doubled[members] / 2.0
            value = smallest_level(offsets, areas, len(areas), self.levels, self.gap)
            if value > best + TIE:
                best, up = value, normal
        return tuple((up if up[2] >= 0.0 else -up).tolist())


@kernel
def find_direction(directions: Array, sets: NDArray[np.int64], known: int, x: float, y: float, z: float) -> int:
    """Number of the direction of a unit normal, either way; a new one is noted as number ``known``.

    ``sets`` (n,) has the number of the set of parallels that each direction is in: a new one joins all that it is
    parallel to.
    """
    for j in range(known):
        if abs(directions[j, 0] * x + directions[j, 1] * y + directions[j, 2] * z) > SAME:
            return j
    directions[known, 0], directions[known, 1], directions[known, 2] = x, y, z
    sets[known] = known
    for j in range(known):
        if abs(directions[j, 0] * x + directions[j, 1] * y + directions[j, 2] * z) > PARALLEL:
            joined = sets[j]
            for m in range(known + 1):
                if sets[m] == joined:
                    sets[m] = sets[known]
    return known


@kernel
def smallest_level(offsets: Array, areas: Array, count: int, levels: float, gap: float) -> float:
    """Area of the smallest level of ``count`` parallel triangles, 0 if there are not enough levels; sorts them."""
    for i in range(1, count):
        offset, area = offsets[i], areas[i]
        j = i
        while j > 0 and offsets[j - 1] > offset:
            offsets[j], areas[j] = offsets[j - 1], areas[j - 1]
            j -= 1
        offsets[j], areas[j] = offset, area
    found, smallest, level = 0, np.inf, 0.0
    for i in range(count):
        level += areas[i]
        if i + 1 == count or offsets[i + 1] - offsets[i] >= gap:
            found += 1
            smallest = min(smallest, level)
            level = 0.0
    return smallest if found >= levels else 0.0


@kernel
def shelf_at(s: Record, r: Record, k: int, areas: Array, n_all: int, levels: float, gap: float, least: float) -> float:
    """The value at driving angle k, any value not above ``least`` if it is not.

    Parameters
    ----------
    areas
        (T,) of the representative triangles.
    n_all
        Triangles with their images.
    """
    directions, sets, totals = np.empty((n_all, 3)), np.empty(n_all, np.int64), np.zeros(n_all)
    direction, offset, area = np.empty(n_all, np.int64), np.empty(n_all), np.empty(n_all)
    corner = np.empty((3, 3))
    n = known = 0
    for t in range(s.n_triangles):
        for j in range(3):
            place_corner(s, r, s.corners[t, j], k, corner, j)
        ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
        vx, vy, vz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        distance = x * corner[0, 0] + y * corner[0, 1] + z * corner[0, 2]
        for g in range(r.order):
            if not has_image(r, s.images[t], g):
                continue
            # an image's plane is as far from the origin
            gx, gy = r.matrices[g, 0] * x + r.matrices[g, 1] * y, r.matrices[g, 2] * x + r.matrices[g, 3] * y
            d = find_direction(directions, sets, known, gx, gy, z)
            if d == known:
                known += 1
            along = directions[d, 0] * gx + directions[d, 1] * gy + directions[d, 2] * z
            direction[n], area[n], offset[n] = d, areas[t], distance if along > 0.0 else -distance
            n += 1
    for i in range(n):
        totals[sets[direction[i]]] += area[i]
    best = 0.0
    offsets, members = np.empty(n_all), np.empty(n_all)
    for d in range(known):
        if totals[d] <= levels * max(best, least):
            continue
        count = 0
        for i in range(n):
            e = direction[i]
            if sets[e] == d:
                along = (
                    directions[d, 0] * directions[e, 0]
                    + directions[d, 1] * directions[e, 1]
                    + directions[d, 2] * directions[e, 2]
                )
                offsets[count], members[count] = offset[i] if along > 0.0 else -offset[i], area[i]
                count += 1
        if count >= levels:
            best = max(best, smallest_level(offsets, members, count, levels, gap))
    return best


@kernel
def best_shelf(states: States, i: int, rules: States, numbers: Array, bound: bool, above: float) -> tuple[float, int]:
    """See :data:`~origami_lab.objectives.compiled_objective.Best`; ``numbers`` are compactness, levels and gap."""
    s, r = states[i], rules[0]
    levels, gap = numbers[1], numbers[2]
    best, angle = above, -1
    areas = np.empty(s.n_triangles)
    n_all, total = 0, 0.0
    for t in range(s.n_triangles):
        areas[t] = panel_area(s, r, t)
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                n_all += 1
                total += areas[t]
    if bound:
        total = float(4 * r.half_x * r.half_y)
    for k in range(r.min_reach - 1, s.reach):
        penalty = sticks_out(s, k, numbers[0])
        least = best + penalty
        value = total / levels
        if not bound and (value > least or least < 0.0):
            value = shelf_at(s, r, k, areas, n_all, levels, gap, least)
        if value > least:
            best, angle = value - penalty, k
    return best, angle


@scored_by(best_shelf)
class ShelfScore(NamedTuple):
    """The compiled score; ``numbers`` are those of :func:`best_shelf`."""

    numbers: Array
