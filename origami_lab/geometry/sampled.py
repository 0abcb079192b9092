"""Random points on a surface and the nearest of them, compiled: the paper's Hausdorff distance has them on both sides.

The points of one triangle stand together, so the tree over the triangles serves for their points, too: those of a
triangle are never nearer than the triangle. Sampling thousands of points and building a tree over them for every sheet
and driving angle would take twenty times as long. Nor are points worked out before they are asked for: most sheets are
refused at a few of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, box_squared, build_bvh, nearest_squared, nearest_triangle
from origami_lab.jit import bare, inlined, kernel

Array = NDArray[np.float64]

LANES = 32
"""Points that are measured at once: four vectors of eight."""


class Sampled(NamedTuple):
    """A surface, or the points drawn on it; see :func:`sample_surface`.

    Attributes
    ----------
    tree
        Over the T triangles of the surface.
    triangles
        (T, 3, 3) those, in the order before the tree was built.
    starts
        (T + 1,) int64: triangle ``t`` has the points from ``starts[t]`` to ``starts[t + 1]``.
    draws
        (n, 3) what chooses the points. None: the surface itself is meant.
    points
        (3, n) x, y, z of the points of those triangles that were asked for.
    is_made
        (T,) whether they were.
    lanes
        (LANES,) scratch.
    """

    tree: Bvh
    triangles: Array
    starts: NDArray[np.int64]
    draws: Array
    points: Array
    is_made: NDArray[np.bool_]
    lanes: Array


@kernel
def sample_surface(triangles: Array, draws: Array) -> Sampled:
    """The points of (T, 3, 3) triangles that (n, 3) draws choose; with no draws the surface itself.

    Parameters
    ----------
    draws
        :func:`~origami_lab.geometry.sampling.surface_draws`, sorted by their first number. They give the points of
        :func:`~origami_lab.geometry.sampling.sample_triangles`, in another order.
    """
    count, number = triangles.shape[0], draws.shape[0]
    starts = np.zeros(count + 1, np.int64)
    sampled = Sampled(
        build_bvh(triangles),
        triangles,
        starts,
        draws,
        np.empty((3, number)),
        np.zeros(count, np.bool_),
        np.empty(LANES),
    )
    if number > 0:
        share_out(triangles, draws, starts)
    return sampled


@bare
def share_out(triangles: Array, draws: Array, starts: NDArray[np.int64]) -> None:
    """Write which of the draws choose each triangle: a share of the area of those before it and itself."""
    count, number = triangles.shape[0], draws.shape[0]
    total = 0.0
    for t in range(count):
        total += area_of(triangles, t)
    cumulative = 0.0
    for t in range(count - 1):
        cumulative += area_of(triangles, t)
        # the first draw that lies beyond this triangle
        low, high = starts[t], number
        while low < high:
            middle = (low + high) >> 1
            if draws[middle, 0] * total >= cumulative:
                high = middle
            else:
                low = middle + 1
        starts[t + 1] = low
    starts[count] = number


@inlined
def area_of(triangles: Array, t: int) -> float:
    ux, uy, uz = (
        triangles[t, 1, 0] - triangles[t, 0, 0],
        triangles[t, 1, 1] - triangles[t, 0, 1],
        triangles[t, 1, 2] - triangles[t, 0, 2],
    )
    vx, vy, vz = (
        triangles[t, 2, 0] - triangles[t, 0, 0],
        triangles[t, 2, 1] - triangles[t, 0, 1],
        triangles[t, 2, 2] - triangles[t, 0, 2],
    )
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return float(0.5 * np.sqrt(nx * nx + ny * ny + nz * nz))


@bare
def _make_points(sampled: Sampled, t: int) -> None:
    """Work out the points of triangle t, in the order before the tree was built."""
    triangles, draws, points = sampled.triangles, sampled.draws, sampled.points
    for axis in range(3):
        a, b, c = triangles[t, 0, axis], triangles[t, 1, axis], triangles[t, 2, axis]
        for i in range(sampled.starts[t], sampled.starts[t + 1]):
            root, along = draws[i, 1], draws[i, 2]
            points[axis, i] = (1.0 - root) * a + root * (1.0 - along) * b + root * along * c
    sampled.is_made[t] = True


@bare
def _nearest_of(sampled: Sampled, t: int, x: float, y: float, z: float, enough_sq: float, best: float) -> float:
    """The smaller of ``best`` and the squared distance to the points of triangle ``t`` of the tree.

    Or to some of them, if that is not above ``enough_sq``.
    """
    points, lanes = sampled.points, sampled.lanes
    original = sampled.tree.original[t]
    if not sampled.is_made[original]:
        _make_points(sampled, original)
    first, last = sampled.starts[original], sampled.starts[original + 1]
    if last - first < LANES:
        for i in range(first, last):
            dx, dy, dz = points[0, i] - x, points[1, i] - y, points[2, i] - z
            best = min(best, dx * dx + dy * dy + dz * dz)
        return best
    for c in range(LANES):
        lanes[c] = best
    while first < last:
        first = min(first, last - LANES)  # some are measured twice
        is_near = False
        for c in range(LANES):
            dx, dy, dz = points[0, first + c] - x, points[1, first + c] - y, points[2, first + c] - z
            lanes[c] = min(lanes[c], dx * dx + dy * dy + dz * dz)
        for c in range(LANES):
            is_near |= lanes[c] <= enough_sq
        if is_near:
            break
        first += LANES
    for c in range(LANES // 2):
        lanes[c] = min(lanes[c], lanes[c + LANES // 2])
    for c in range(LANES // 2):
        best = min(best, lanes[c])
    return best


@bare
def _nearest_from(
    sampled: Sampled, nearest: int, x: float, y: float, z: float, enough_sq: float, start_sq: float
) -> float:
    """:func:`nearest_sample_squared` where triangle ``nearest`` of the tree is the nearest one."""
    tree = sampled.tree
    # it most likely has the nearest point, too; the other triangles are looked at if they might have a nearer one
    best = _nearest_of(sampled, nearest, x, y, z, enough_sq, start_sq)
    count, leaves = tree.triangles.shape[0], tree.boxes.shape[0] >> 1
    for leaf in range(leaves):
        if best <= enough_sq:
            return best
        if box_squared(tree.boxes, leaves + leaf, x, y, z) < best:
            for t in range(count * leaf // leaves, count * (leaf + 1) // leaves):
                if t != nearest:
                    best = _nearest_of(sampled, t, x, y, z, enough_sq, best)
    return best


@bare
def nearest_sample_squared(sampled: Sampled, x: float, y: float, z: float, enough_sq: float, start_sq: float) -> float:
    """Squared distance from (x, y, z) to the nearest point, or to the surface if there are no points.

    ``enough_sq`` and ``start_sq`` are those of :func:`~origami_lab.geometry.bvh.nearest_squared`.
    """
    if sampled.draws.shape[0] == 0:
        return nearest_squared(sampled.tree, x, y, z, enough_sq, start_sq)
    _, nearest = nearest_triangle(sampled.tree, x, y, z, 0.0, start_sq)
    if nearest < 0:
        return start_sq
    return _nearest_from(sampled, nearest, x, y, z, enough_sq, start_sq)


@bare
def sample_within_squared(sampled: Sampled, x: float, y: float, z: float, limit_sq: float) -> float:
    """The squared distance of a point that is within the limit; if there is none, a number above ``limit_sq``.

    Where there are no points, the surface is meant. It takes less than the distance: points are not looked at where the
    surface itself is too far away.
    """
    if sampled.draws.shape[0] == 0:
        return nearest_squared(sampled.tree, x, y, z, limit_sq, np.inf)
    squared, nearest = nearest_triangle(sampled.tree, x, y, z, 0.0, np.inf)
    if squared <= limit_sq:
        squared = _nearest_from(sampled, nearest, x, y, z, limit_sq, np.nextafter(limit_sq, np.inf))
    return squared
