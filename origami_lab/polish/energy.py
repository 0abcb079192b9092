"""How far a folded design is from its target, smooth enough to descend: every distance counts, the largest most.

With the distances d of all vertices and all samples of the target, in board cells, the energy at a scale f and a
sharpness β is

    E = Σ over vertices w·exp(β((d + p)/f − 1)) + Σ over samples exp(β((d + p)/f − 1)),

p being the compactness penalty. As β grows its minimum tends to that of the largest distance. A distance below a share
of the scale counts as that share: what it is exactly does not matter to the largest, and need not be computed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.state import Record, States
from origami_lab.geometry.bvh import Bvh, build_bvh, inside, nearest_squared, nearest_triangle, triangle_squared
from origami_lab.jit import inlined, kernel
from origami_lab.objectives.known_places import Surface, nothing_known
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shape_kernels import folded_triangles
from origami_lab.polish.finer_board import FineBoard

VERTEX_WEIGHT = 20.0
"""Samples that a vertex counts as much as."""
FLOOR = 0.6
"""Share of the scale below which distances count as that share."""
PANEL_SPACING = 0.5
"""Board cells between the points of a panel, where those count."""

Array = NDArray[np.float64]


class Yardstick(NamedTuple):
    """What a folded design is measured with.

    Attributes
    ----------
    target
        What the sheet's points stray from.
    samples
        (n, 3) points of the target that are to be covered.
    panels, parts
        (T, 3) codes of corners and (T,) int64: triangles of the sheet with points that count like vertices, and into
        how many parts their sides are divided to get them. None where only vertices count.
    cell
        Board cells a part: distances are in cells.
    """

    target: Surface
    samples: Array
    panels: NDArray[np.int64]
    parts: NDArray[np.int64]
    cell: float


def yardstick_of(objective: ShapeObjective, board: FineBoard) -> Yardstick:
    """The yardstick of a shape objective for a design; ``sampled`` is measured like ``vertex`` on the way."""
    target, group = objective.target, board.game.symmetry
    symmetric = target.has_symmetry(group)
    samples = np.ascontiguousarray(objective.cover.triangles[:, 0])
    if symmetric and len(group.normals):
        samples = np.ascontiguousarray(samples[(samples[:, :2] @ group.normals.T >= -1e-9).all(axis=1)])
    solid = bool(target.closed)
    surface = Surface(target.wide_tree, target.bvh, solid, not symmetric, objective.compactness, nothing_known())
    nothing = np.zeros(0, dtype=np.int64)
    return Yardstick(surface, samples, nothing.reshape(0, 3), nothing, 1.0 / board.finer)


def with_panels(stick: Yardstick, states: States, rules: States) -> Yardstick:
    """The yardstick with points inside the panels of a laid design, about :data:`PANEL_SPACING` apart in it.

    They stay those points of the same panels while the design moves, or the distances would jump. A panel that only
    comes to be when a vertex leaves the boundary segment it lay on has none.
    """
    s = states[0]
    corners = s["corners"][: int(s["n_triangles"])].astype(np.int64)
    images = rules[0]["matrices"][corners & 7].reshape(*corners.shape, 2, 2)
    flat = np.einsum("tcij,tcj->tci", images, s["xy"][corners >> 3]) * stick.cell
    sides = np.linalg.norm(flat - np.roll(flat, -1, axis=1), axis=2).max(axis=1, initial=0.0)
    return stick._replace(panels=corners, parts=np.maximum(1, np.ceil(sides / PANEL_SPACING)).astype(np.int64))


@inlined
def stray_squared(r: Record, target: Surface, x: float, y: float, z: float, enough_sq: float) -> float:
    """Squared distance of a point of the sheet, and of its images if they count, from the target.

    Not above ``enough_sq``, 0 or any other number that is not either.
    """
    farthest = 0.0
    for g in range(r.order if target.images else 1):
        gx, gy = r.matrices[g, 0] * x + r.matrices[g, 1] * y, r.matrices[g, 2] * x + r.matrices[g, 3] * y
        squared = nearest_squared(target.hull, gx, gy, z, max(enough_sq, farthest), np.inf)
        if squared > farthest and squared > enough_sq and not (target.solid and inside(target.hull, gx, gy, z)):
            farthest = squared
    return farthest


@kernel
def panel_points(s: Record, r: Record, k: int, stick: Yardstick) -> Array:
    """(n, 3) points within the panels, corners left out, at driving angle k, in cells."""
    count = 0
    for t in range(stick.parts.shape[0]):
        n = stick.parts[t]
        count += (n + 1) * (n + 2) // 2 - 3
    out, corner, row, cell = np.empty((count, 3)), np.empty((3, 3)), 0, stick.cell
    for t in range(stick.parts.shape[0]):
        for j in range(3):
            place_corner(s, r, stick.panels[t, j], k, corner, j)
        n = stick.parts[t]
        for i in range(n + 1):
            for j in range(n + 1 - i):
                if (i == n) or (j == n) or (i == 0 and j == 0):
                    continue
                for axis in range(3):
                    origin = corner[0, axis]
                    along = i * (corner[1, axis] - origin) + j * (corner[2, axis] - origin)
                    out[row, axis] = cell * (origin + along / n)
                row += 1
    return out


@kernel
def sheet_tree(s: Record, r: Record, k: int, cell: float) -> tuple[Array, Bvh]:
    """(T, 3, 3) triangles of the folded sheet, images included, in cells, and the tree over them."""
    triangles = folded_triangles(s, r, k)
    for t in range(triangles.shape[0]):
        for j in range(3):
            for axis in range(3):
                triangles[t, j, axis] *= cell
    return triangles, build_bvh(triangles)


@kernel
def distances_of(
    states: States,
    rules: States,
    stick: Yardstick,
    floor: float,
    nearest: NDArray[np.int64],
    out: Array,
    penalties: Array,
) -> None:
    """Write all distances of a laid first state at its last driving angle, in cells: vertices, panel points, samples.

    Parameters
    ----------
    floor
        What a distance is at least: its own value below that is not asked for.
    out
        As long as vertices, panel points and samples are many.
    penalties
        (V,) compactness penalties; (0,) if there are none.
    """
    s, r = states[0], rules[0]
    k, target, cell = s.position.shape[1] - 1, stick.target, stick.cell
    row = 0
    for v in range(s.n_vertices):
        x, y, z = cell * s.position[v, k, 0], cell * s.position[v, k, 1], cell * s.position[v, k, 2]
        out[row] = max(floor, np.sqrt(stray_squared(r, target, x, y, z, floor * floor)))
        row += 1
        if penalties.shape[0] > 0:
            penalties[v] = target.compactness * np.sqrt(x * x + y * y + z * z)
    points = panel_points(s, r, k, stick)
    for i in range(points.shape[0]):
        squared = stray_squared(r, target, points[i, 0], points[i, 1], points[i, 2], floor * floor)
        out[row] = max(floor, np.sqrt(squared))
        row += 1
    triangles, tree = sheet_tree(s, r, k, cell)
    last = triangles.shape[0] - 1  # a vertex that leaves a boundary segment brings a triangle
    for i in range(stick.samples.shape[0]):
        x, y, z = stick.samples[i, 0], stick.samples[i, 1], stick.samples[i, 2]
        squared = triangle_squared(triangles, min(nearest[i], last), x, y, z)
        if squared > floor * floor:
            found, at = nearest_triangle(tree, x, y, z, floor * floor, squared)
            if at >= 0:
                squared, nearest[i] = found, tree.original[at]
        out[row] = max(floor, np.sqrt(squared))
        row += 1


@kernel
def measure(
    states: States,
    rules: States,
    stick: Yardstick,
    scale: float,
    sharpness: float,
    give_up: float,
    nearest: NDArray[np.int64],
) -> tuple[float, float]:
    """The largest distance of a laid first state at its last driving angle, in cells, and its energy.

    Parameters
    ----------
    scale
        f; 0 for the largest distance alone, exactly.
    give_up
        An energy from which on both may be returned as infinite.
    nearest
        (n,) the triangle of the sheet that each sample was nearest to the last time; it changes no result.
    """
    s, r = states[0], rules[0]
    k, target, cell = s.position.shape[1] - 1, stick.target, stick.cell
    exact = scale == 0.0
    penalty = 0.0
    if target.compactness > 0.0:
        for v in range(s.n_vertices):
            x, y, z = s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]
            penalty = max(penalty, target.compactness * cell * np.sqrt(x * x + y * y + z * z))
    floor = 0.0 if exact else FLOOR * scale
    least = 0.0 if exact else np.exp(sharpness * ((floor + penalty) / scale - 1.0))
    largest, energy = 0.0, 0.0
    for v in range(s.n_vertices):
        x, y, z = cell * s.position[v, k, 0], cell * s.position[v, k, 1], cell * s.position[v, k, 2]
        distance = np.sqrt(stray_squared(r, target, x, y, z, max(floor, largest if exact else 0.0) ** 2))
        largest = max(largest, distance)
        if not exact:
            term = least if distance <= floor else np.exp(sharpness * ((distance + penalty) / scale - 1.0))
            energy += VERTEX_WEIGHT * term
            if energy > give_up:
                return np.inf, np.inf
    points = panel_points(s, r, k, stick)
    for i in range(points.shape[0]):
        enough = max(floor, largest if exact else 0.0) ** 2
        distance = np.sqrt(stray_squared(r, target, points[i, 0], points[i, 1], points[i, 2], enough))
        largest = max(largest, distance)
        if not exact:
            energy += least if distance <= floor else np.exp(sharpness * ((distance + penalty) / scale - 1.0))
            if energy > give_up:
                return np.inf, np.inf
    triangles, tree = sheet_tree(s, r, k, cell)
    last = triangles.shape[0] - 1  # a vertex that leaves a boundary segment brings a triangle
    for i in range(stick.samples.shape[0]):
        x, y, z = stick.samples[i, 0], stick.samples[i, 1], stick.samples[i, 2]
        enough = (largest if exact else floor) ** 2
        squared = triangle_squared(triangles, min(nearest[i], last), x, y, z)
        if squared > enough:
            found, row = nearest_triangle(tree, x, y, z, enough, squared)
            if row >= 0:
                squared, nearest[i] = found, tree.original[row]
        if squared > enough:
            distance = np.sqrt(squared)
            largest = max(largest, distance)
            if not exact:
                energy += np.exp(sharpness * ((distance + penalty) / scale - 1.0))
        elif not exact:
            energy += least
        if energy > give_up:
            return np.inf, np.inf
    return largest + penalty, energy
