"""A tree of axis-aligned boxes over triangles: nearest distance and inside tests, compiled.

The tree is a complete binary tree in heap order (node ``i`` has the children ``2i`` and ``2i+1``, the root is
1): each split is at the median, so a node's range of triangles follows from its number and no pointers are
stored. A traversal needs no stack either: one bit per level says whether the sibling is still to be visited.
A Python caller pays for every array of a named tuple, hence the few arrays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.distance import point_box_squared, point_triangle_squared
from origami_lab.jit import bare, inlined, kernel

LEAF_SIZE = 2
"""At most this many triangles per leaf of the tree."""

# The ray of `inside` runs along (SLOPE_X, SLOPE_Y, 1). Any fixed direction works; an irrational, oblique one
# does not meet the edges of meshes with round coordinates, seen from points with round coordinates.
SLOPE_X = 0.4142135623730951 * 0.7320508075688772
SLOPE_Y = 0.6180339887498949 * 0.8284271247461903


class Bvh(NamedTuple):
    """A bounding-box tree over T triangles with 2^L ≥ T/LEAF_SIZE leaves; see :func:`build_bvh`.

    Attributes
    ----------
    boxes
        (2^(L+1), 6) float64: x0, y0, z0, x1, y1, z1 of node 1, 2, ...; row 0 is unused.
    triangles
        (T, 3, 3) float64: the triangles in the order of the leaves.
    original
        (T,) int64: the position of each of them in the list the tree was built from.
    """

    boxes: NDArray[np.float64]
    triangles: NDArray[np.float64]
    original: NDArray[np.int64]


@bare
def _select(keys: NDArray[np.float64], order: NDArray[np.int64], low: int, high: int, middle: int) -> None:
    """Permute ``order[low:high]`` so that keys before ``middle`` are ≤ those from it on (quickselect)."""
    high -= 1
    while low < high:
        pivot = keys[order[(low + high) >> 1]]
        i = low
        j = high
        while i <= j:
            while keys[order[i]] < pivot:
                i += 1
            while keys[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@kernel
def build_bvh(triangles: NDArray[np.float64]) -> Bvh:
    """Build the tree over (T, 3, 3) float64 triangles, T ≥ 1, by medians along the centroids' longest axis.

    Triangles may be degenerate (three equal corners: a tree over points).

    Raises
    ------
    ValueError
        If there is no triangle.
    """
    count = triangles.shape[0]
    if count < 1:
        raise ValueError("a bounding-box tree needs at least one triangle")
    depth = 0
    while count > (LEAF_SIZE << depth):
        depth += 1
    leaves = 1 << depth
    order = np.arange(count)
    centres = np.empty((3, count))
    for t in range(count):
        for axis in range(3):
            centres[axis, t] = triangles[t, 0, axis] + triangles[t, 1, axis] + triangles[t, 2, axis]
    for level in range(depth):
        for position in range(1 << level):
            first = (count * position) >> level
            last = (count * (position + 1)) >> level
            middle = (count * (2 * position + 1)) >> (level + 1)
            longest = 0
            extent = -1.0
            for axis in range(3):
                low = centres[axis, order[first]]
                high = low
                for i in range(first + 1, last):
                    value = centres[axis, order[i]]
                    low = min(low, value)
                    high = max(high, value)
                if high - low > extent:
                    extent = high - low
                    longest = axis
            _select(centres[longest], order, first, last, middle)

    boxes = np.empty((2 * leaves, 6))
    boxes[0, :] = 0.0
    permuted = np.empty((count, 3, 3))
    for leaf in range(leaves):
        node = leaves + leaf
        for axis in range(3):
            boxes[node, axis] = np.inf
            boxes[node, axis + 3] = -np.inf
        for i in range((count * leaf) >> depth, (count * (leaf + 1)) >> depth):
            for corner in range(3):
                for axis in range(3):
                    value = triangles[order[i], corner, axis]
                    permuted[i, corner, axis] = value
                    boxes[node, axis] = min(boxes[node, axis], value)
                    boxes[node, axis + 3] = max(boxes[node, axis + 3], value)
    for node in range(leaves - 1, 0, -1):
        for axis in range(3):
            boxes[node, axis] = min(boxes[2 * node, axis], boxes[2 * node + 1, axis])
            boxes[node, axis + 3] = max(boxes[2 * node, axis + 3], boxes[2 * node + 1, axis + 3])
    return Bvh(boxes, permuted, order)


@inlined
def box_squared(boxes: NDArray[np.float64], node: int, x: float, y: float, z: float) -> float:
    """Squared distance from (x, y, z) to the box of a node; 0 inside."""
    return point_box_squared(
        x,
        y,
        z,
        boxes[node, 0],
        boxes[node, 1],
        boxes[node, 2],
        boxes[node, 3],
        boxes[node, 4],
        boxes[node, 5],
    )


@inlined
def triangle_squared(triangles: NDArray[np.float64], t: int, x: float, y: float, z: float) -> float:
    """Squared distance from (x, y, z) to triangle ``t`` of a (T, 3, 3) array."""
    return point_triangle_squared(
        x,
        y,
        z,
        triangles[t, 0, 0],
        triangles[t, 0, 1],
        triangles[t, 0, 2],
        triangles[t, 1, 0],
        triangles[t, 1, 1],
        triangles[t, 1, 2],
        triangles[t, 2, 0],
        triangles[t, 2, 1],
        triangles[t, 2, 2],
    )


@bare
def nearest_triangle(bvh: Bvh, x: float, y: float, z: float, enough_sq: float, start_sq: float) -> tuple[float, int]:
    """The squared distance of :func:`nearest_squared`, and the row of ``bvh.triangles`` that gave it.

    The row is −1 when nothing is nearer than ``start_sq``.
    """
    boxes = bvh.boxes
    triangles = bvh.triangles
    count = triangles.shape[0]
    depth = 0
    while (2 << depth) < boxes.shape[0]:
        depth += 1
    best = start_sq
    found = -1
    node = 1
    level = 0
    done = 0  # bit l (from the lowest = this level): the sibling on that level needs no visit any more
    while True:
        descend = False
        if level < depth:
            left = box_squared(boxes, 2 * node, x, y, z)
            right = box_squared(boxes, 2 * node + 1, x, y, z)
            if min(left, right) < best:
                done <<= 1
                if max(left, right) >= best:
                    done |= 1
                node = 2 * node + (1 if right < left else 0)
                level += 1
                descend = True
        else:
            position = node - (1 << level)
            for t in range((count * position) >> level, (count * (position + 1)) >> level):
                squared = triangle_squared(triangles, t, x, y, z)
                if squared < best:
                    best = squared
                    found = t
            if best <= enough_sq:
                return best, found
        while not descend:
            if node == 1:
                return best, found
            if done & 1:
                node >>= 1
                done >>= 1
                level -= 1
            else:
                done |= 1
                node ^= 1
                descend = box_squared(boxes, node, x, y, z) < best


@bare
def nearest_squared(bvh: Bvh, x: float, y: float, z: float, enough_sq: float, start_sq: float) -> float:
    """Squared distance from (x, y, z) to the nearest triangle, in squared board units.

    Parameters
    ----------
    enough_sq
        Stop at the first value ≤ this and return it: an upper bound of the squared distance. Pass 0 for the
        exact distance.
    start_sq
        A value to beat (``np.inf`` for none): the result is the smaller of it and the squared distance.
    """
    return nearest_triangle(bvh, x, y, z, enough_sq, start_sq)[0]


@kernel
def distances(bvh: Bvh, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances (n,) from points (n, 3) to the nearest triangle, board units."""
    result = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        result[i] = np.sqrt(nearest_squared(bvh, points[i, 0], points[i, 1], points[i, 2], 0.0, np.inf))
    return result


@inlined
def _crosses(low_x: float, low_y: float, high_x: float, high_y: float) -> bool:
    """Whether the segment crosses the half-line y = 0, x > 0, by a half-open rule all triangles share."""
    if low_y > high_y:
        low_x, low_y, high_x, high_y = high_x, high_y, low_x, low_y
    return low_y <= 0.0 and high_y > 0.0 and low_x * high_y - low_y * high_x > 0.0


@inlined
def _ray_hits(triangles: NDArray[np.float64], t: int, x: float, y: float, z: float) -> bool:
    """Whether the ray from (x, y, z) along (SLOPE_X, SLOPE_Y, 1) passes through triangle ``t``."""
    az = triangles[t, 0, 2] - z
    bz = triangles[t, 1, 2] - z
    cz = triangles[t, 2, 2] - z
    if az < 0.0 and bz < 0.0 and cz < 0.0:
        return False
    # shear so that the ray is the z axis; equal corners of two triangles give equal numbers
    ax = triangles[t, 0, 0] - x - SLOPE_X * az
    ay = triangles[t, 0, 1] - y - SLOPE_Y * az
    bx = triangles[t, 1, 0] - x - SLOPE_X * bz
    by = triangles[t, 1, 1] - y - SLOPE_Y * bz
    cx = triangles[t, 2, 0] - x - SLOPE_X * cz
    cy = triangles[t, 2, 1] - y - SLOPE_Y * cz
    parity = _crosses(ax, ay, bx, by) != _crosses(bx, by, cx, cy)
    if parity == _crosses(cx, cy, ax, ay):
        return False
    weight_a = bx * cy - by * cx
    weight_b = cx * ay - cy * ax
    weight_c = ax * by - ay * bx
    height = weight_a * az + weight_b * bz + weight_c * cz
    return bool((height > 0.0) == (weight_a + weight_b + weight_c > 0.0))


@bare
def inside(bvh: Bvh, x: float, y: float, z: float) -> bool:
    """Whether (x, y, z) is inside the watertight mesh, by the parity of a ray's crossings.

    A point exactly on the surface may be answered either way. For an open mesh the answer means nothing.
    """
    boxes = bvh.boxes
    triangles = bvh.triangles
    if box_squared(boxes, 1, x, y, z) > 0.0:
        return False
    count = triangles.shape[0]
    depth = 0
    while (2 << depth) < boxes.shape[0]:
        depth += 1
    # boxes grow by this much, so that rounding never drops one the ray grazes
    slack = 0.0
    for axis in range(6):
        slack = max(slack, abs(boxes[1, axis]))
    slack *= 1e-12
    odd = False
    node = 1
    level = 0
    while True:
        # the part of the ray, as its height above z, inside each pair of planes
        start = max(0.0, boxes[node, 2] - slack - z)
        end = boxes[node, 5] + slack - z
        start = max(start, (boxes[node, 0] - slack - x) / SLOPE_X, (boxes[node, 1] - slack - y) / SLOPE_Y)
        end = min(end, (boxes[node, 3] + slack - x) / SLOPE_X, (boxes[node, 4] + slack - y) / SLOPE_Y)
        if start <= end:
            if level < depth:
                node = 2 * node
                level += 1
                continue
            position = node - (1 << level)
            for t in range((count * position) >> level, (count * (position + 1)) >> level):
                if _ray_hits(triangles, t, x, y, z):
                    odd = not odd
        while node & 1:  # right children are done; the root is 1, too
            if node == 1:
                return odd
            node >>= 1
            level -= 1
        node += 1
