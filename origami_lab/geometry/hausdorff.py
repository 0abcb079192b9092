"""Directed Hausdorff distances between triangulated surfaces, by branch and bound (the paper's section 4).

The maximum over the source of f, where f is the distance to the target surface or, for a solid target, the
positive part of the signed distance. Over a triangle of the source, f is bounded from above in two ways:

* f is 1-Lipschitz: f ≤ f(centroid) + radius, where the (possibly negative) signed distance counts if solid;
* the distance to *one* target triangle is convex, so its maximum over the source triangle is at a corner, and
  f is below it: f ≤ max over corners of the distance to the target triangle nearest to the centroid.

The second closes at once where the surfaces run parallel or coincide, where the first would need cells as
small as the tolerance. Triangles are halved across their longest side, the one with the largest bound
first, until no bound exceeds the best value found by more than the tolerance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, inside, nearest_triangle, triangle_squared
from origami_lab.jit import inlined, kernel

Array = NDArray[np.float64]


@kernel
def _corner_value(target: Bvh, solid: bool, x: float, y: float, z: float, best: float) -> float:
    """The larger of ``best`` and f at a point; the search stops as soon as f cannot be larger."""
    squared = nearest_triangle(target, x, y, z, best * best, np.inf)[0]
    if squared > best * best and not (solid and inside(target, x, y, z)):
        return max(best, float(np.sqrt(squared)))  # the root may round down
    return best


@kernel
def _bound(cells: Array, row: int, target: Bvh, solid: bool, best: float, tolerance: float) -> tuple[float, float]:
    """An upper bound of f over triangle ``row`` and the larger of ``best`` and f at its centroid.

    The bound is only as sharp as it must be to tell whether it exceeds ``best + tolerance``.
    """
    x = (cells[row, 0, 0] + cells[row, 1, 0] + cells[row, 2, 0]) / 3.0
    y = (cells[row, 0, 1] + cells[row, 1, 1] + cells[row, 2, 1]) / 3.0
    z = (cells[row, 0, 2] + cells[row, 1, 2] + cells[row, 2, 2]) / 3.0
    squared, nearest = nearest_triangle(target, x, y, z, 0.0, np.inf)
    distance = np.sqrt(squared)
    radius_sq = 0.0
    convex_sq = 0.0
    for i in range(3):
        dx = cells[row, i, 0] - x
        dy = cells[row, i, 1] - y
        dz = cells[row, i, 2] - z
        radius_sq = max(radius_sq, dx * dx + dy * dy + dz * dz)
        convex_sq = max(
            convex_sq,
            triangle_squared(target.triangles, nearest, cells[row, i, 0], cells[row, i, 1], cells[row, i, 2]),
        )
    radius = np.sqrt(radius_sq)
    bound = min(distance + radius, np.sqrt(convex_sq))
    if solid and bound > best and inside(target, x, y, z):
        return min(bound, max(0.0, radius - distance)), best
    best = max(best, distance)
    if radius <= tolerance:  # nothing in it exceeds best + tolerance; keeps rounding from splitting it for ever
        bound = min(bound, best)
    return bound, best


@kernel
def _sift_up(heap: NDArray[np.int64], bounds: Array, position: int) -> None:
    row = heap[position]
    while position > 0:
        parent = (position - 1) >> 1
        if bounds[heap[parent]] >= bounds[row]:
            break
        heap[position] = heap[parent]
        position = parent
    heap[position] = row


@kernel
def _sift_down(heap: NDArray[np.int64], bounds: Array, size: int) -> None:
    position = 0
    row = heap[0]
    while 2 * position + 1 < size:
        child = 2 * position + 1
        if child + 1 < size and bounds[heap[child + 1]] > bounds[heap[child]]:
            child += 1
        if bounds[heap[child]] <= bounds[row]:
            break
        heap[position] = heap[child]
        position = child
    heap[position] = row


@inlined
def _longest_side(cells: Array, row: int) -> int:
    """The corner at which the longest side of triangle ``row`` starts."""
    longest = 0
    length = -1.0
    for i in range(3):
        j = (i + 1) % 3
        dx = cells[row, i, 0] - cells[row, j, 0]
        dy = cells[row, i, 1] - cells[row, j, 1]
        dz = cells[row, i, 2] - cells[row, j, 2]
        squared = dx * dx + dy * dy + dz * dz
        if squared > length:
            length = squared
            longest = i
    return longest


@inlined
def _copy(source: Array, i: int, target: Array, j: int) -> None:
    for corner in range(3):
        for axis in range(3):
            target[j, corner, axis] = source[i, corner, axis]


@kernel
def _grow(cells: Array, bounds: Array, heap: NDArray[np.int64]) -> tuple[Array, Array, NDArray[np.int64]]:
    """The same with room for twice as many; loops, because they compile faster than ``np.concatenate``."""
    size = cells.shape[0]
    more_cells = np.empty((2 * size, 3, 3))
    more_bounds = np.empty(2 * size)
    more_heap = np.empty(2 * size, np.int64)
    for i in range(size):
        _copy(cells, i, more_cells, i)
        more_bounds[i] = bounds[i]
        more_heap[i] = heap[i]
    return more_cells, more_bounds, more_heap


@kernel
def directed_distance_kernel(
    source_triangles: Array, target: Bvh, tolerance: float, solid: bool, start: float
) -> float:
    """:func:`directed_distance` with positional arguments, for compiled callers.

    ``source_triangles`` is (S, 3, 3) float64, contiguous; nothing is kept of it.
    """
    if not tolerance > 0.0:
        raise ValueError("the tolerance of a surface distance must be positive")
    count = source_triangles.shape[0]
    best = max(0.0, start)
    scale = 0.0
    for t in range(count):
        for i in range(3):
            x, y, z = source_triangles[t, i, 0], source_triangles[t, i, 1], source_triangles[t, i, 2]
            scale = max(scale, abs(x), abs(y), abs(z))
            best = _corner_value(target, solid, x, y, z, best)
    tolerance = max(tolerance, 1e-13 * scale)  # cells below the rounding of the coordinates do not shrink

    cells = np.empty((max(16, 2 * count), 3, 3))
    bounds = np.empty(cells.shape[0])
    heap = np.empty(cells.shape[0], np.int64)
    size = 0
    for t in range(count):
        _copy(source_triangles, t, cells, size)
        bounds[size], best = _bound(cells, size, target, solid, best, tolerance)
        if bounds[size] > best + tolerance:
            heap[size] = size
            size += 1
    for position in range(1, size):
        _sift_up(heap, bounds, position)

    free = size  # rows from here on were never used; a popped row is used again for one of its halves
    while size > 0 and bounds[heap[0]] > best + tolerance:
        row = heap[0]
        parent_bound = bounds[row]
        size -= 1
        heap[0] = heap[size]
        _sift_down(heap, bounds, size)
        if free == cells.shape[0]:
            cells, bounds, heap = _grow(cells, bounds, heap)
        i = _longest_side(cells, row)
        j = (i + 1) % 3
        x = 0.5 * (cells[row, i, 0] + cells[row, j, 0])
        y = 0.5 * (cells[row, i, 1] + cells[row, j, 1])
        z = 0.5 * (cells[row, i, 2] + cells[row, j, 2])
        best = _corner_value(target, solid, x, y, z, best)
        _copy(cells, row, cells, free)
        for half, corner in ((row, i), (free, j)):
            cells[half, corner, 0] = x
            cells[half, corner, 1] = y
            cells[half, corner, 2] = z
            bound, best = _bound(cells, half, target, solid, best, tolerance)
            bounds[half] = min(bound, parent_bound)
            if bounds[half] > best + tolerance:
                heap[size] = half
                _sift_up(heap, bounds, size)
                size += 1
                if half == free:
                    free += 1
    return best


def directed_distance(
    source_triangles: Array, target: Bvh, tolerance: float, *, solid: bool, start: float = 0.0
) -> float:
    """The largest distance from a point of the source surface to the target, board units.

    Parameters
    ----------
    source_triangles
        (S, 3, 3) float64, finite; all points of the triangles count, not only their corners.
    target
        Tree over the target's triangles.
    tolerance
        > 0: the result is the value at an actual point and at most this much below the true maximum. The work
        grows as 1/tolerance where the surfaces nearly coincide, much less elsewhere.
    solid
        Whether points inside the (watertight) target count as distance 0.
    start
        A value known to be attained elsewhere: the result is at least this; what cannot exceed it is skipped.

    Raises
    ------
    ValueError
        If the tolerance is not positive.
    """
    triangles = np.require(source_triangles, np.float64, ["C", "W"])  # one compiled version for all callers
    return float(directed_distance_kernel(triangles, target, float(tolerance), bool(solid), float(start)))
