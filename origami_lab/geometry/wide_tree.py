"""An eight-wide tree of boxes over triangles or points that stay: the nearest of them, for searches that ask often.

It is made of a :class:`~origami_lab.geometry.bvh.Bvh`, whose order of triangles it takes: of every three levels it
keeps one, so that a node has eight children, whose boxes are measured in one vector, and a leaf has one triangle. What
a distance needs of a triangle is worked out when the tree is made; the arithmetic is that of
:func:`~origami_lab.geometry.distance.point_triangle_squared`, so the answers are the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh
from origami_lab.geometry.distance import point_edges_squared
from origami_lab.jit import bare, inlined, kernel

Array = NDArray[np.float64]

WIDTH, BITS = 8, 3
MOST_LEVELS = 8
"""Wide levels at most: enough for 16 million triangles."""

ROW = 15
"""Numbers kept of a triangle a, b, c: a, b − a, c − a, their cross product n, |n|², |b − a|², |c − a|²."""

SLACK = 1e-12
"""Of the largest coordinate: what boxes of triangles are wider by. Rounding can make a triangle nearer than its box by
the last bits, and answers would depend on where the search began. Points and their boxes are rounded alike."""


class WideTree(NamedTuple):
    """A tree over T triangles; see :func:`build_wide_tree`.

    With D = log₂ T, rounded up, a node at level l ≤ D of the binary tree has the number 2^l + its place; the wide tree
    has those at the levels 0, b, b + 3, … D, where b is from 1 to 3.

    Attributes
    ----------
    boxes
        (n, 6, 8) x0, y0, z0, x1, y1, z1 of the children of each node, by its number, wider than they need be by
        :data:`SLACK`; infinitely far where none is.
    rows
        (T, 15) the triangles, see :data:`ROW`.
    depth
        D.
    root_bits
        b.
    are_points
        Whether all triangles are points: then their boxes' distances are theirs.
    """

    boxes: Array
    rows: Array
    depth: int
    root_bits: int
    are_points: bool


def build_wide_tree(tree: Bvh) -> WideTree:
    """The wide tree over the triangles of a tree, in its order."""
    triangles = tree.triangles
    depth = max(1, int(len(triangles) - 1).bit_length())
    root_bits = depth - BITS * ((depth - 1) // BITS)
    are_points = bool((triangles == triangles[:, :1]).all())
    boxes = np.full((1 << max(depth - BITS + 1, 1), 6, WIDTH), np.inf)
    rows = np.empty((len(triangles), ROW))
    slack = 0.0 if are_points else SLACK * float(np.abs(triangles).max())
    _fill(triangles, boxes, rows, depth, root_bits, slack)
    return WideTree(boxes, rows, depth, root_bits, are_points)


@kernel
def _fill(triangles: Array, boxes: Array, rows: Array, depth: int, root_bits: int, slack: float) -> None:
    count = triangles.shape[0]
    for t in range(count):
        for j in range(3):
            rows[t, j] = triangles[t, 0, j]
            rows[t, 3 + j] = triangles[t, 1, j] - triangles[t, 0, j]
            rows[t, 6 + j] = triangles[t, 2, j] - triangles[t, 0, j]
        bx, by, bz, cx, cy, cz = rows[t, 3], rows[t, 4], rows[t, 5], rows[t, 6], rows[t, 7], rows[t, 8]
        nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        rows[t, 9], rows[t, 10], rows[t, 11] = nx, ny, nz
        rows[t, 12] = nx * nx + ny * ny + nz * nz
        rows[t, 13] = bx * bx + by * by + bz * bz
        rows[t, 14] = cx * cx + cy * cy + cz * cz
    level = depth
    while level > 0:
        bits = root_bits if level == root_bits else BITS
        for position in range(1 << level):
            first, last = (count * position) >> level, (count * (position + 1)) >> level
            parent, child = ((1 << level) + position) >> bits, position & ((1 << bits) - 1)
            for j in range(3):
                low, high = np.inf, -np.inf
                for t in range(first, last):
                    for corner in range(3):
                        low, high = min(low, triangles[t, corner, j]), max(high, triangles[t, corner, j])
                if first < last:
                    boxes[parent, j, child], boxes[parent, 3 + j, child] = low - slack, high + slack
        level -= bits


@inlined
def row_squared(tree: WideTree, t: int, x: float, y: float, z: float) -> float:
    """Squared distance from (x, y, z) to triangle t."""
    rows = tree.rows
    return point_edges_squared(
        x - rows[t, 0],
        y - rows[t, 1],
        z - rows[t, 2],
        rows[t, 3],
        rows[t, 4],
        rows[t, 5],
        rows[t, 6],
        rows[t, 7],
        rows[t, 8],
        rows[t, 9],
        rows[t, 10],
        rows[t, 11],
        rows[t, 12],
        rows[t, 13],
        rows[t, 14],
    )


@inlined
def measure_children(tree: WideTree, node: int, x: float, y: float, z: float, far: Array, level: int) -> None:
    """Write the squared distances of a node's children's boxes to the level's row of ``far``, in one vector."""
    boxes = tree.boxes
    for c in range(WIDTH):
        dx = max(boxes[node, 0, c] - x, 0.0, x - boxes[node, 3, c])
        dy = max(boxes[node, 1, c] - y, 0.0, y - boxes[node, 4, c])
        dz = max(boxes[node, 2, c] - z, 0.0, z - boxes[node, 5, c])
        far[level, c] = dx * dx + dy * dy + dz * dz


@bare
def nearest_row(
    tree: WideTree, x: float, y: float, z: float, enough_sq: float, start_sq: float, near: int, far: Array
) -> tuple[float, int]:
    """The squared distance from (x, y, z) to the nearest triangle, and that triangle; ``near`` if none is nearer.

    Parameters
    ----------
    enough_sq, start_sq
        As in :func:`~origami_lab.geometry.bvh.nearest_squared`.
    near
        A triangle to look at first, such as the last answer.
    far
        (MOST_LEVELS, 8) scratch: of each node on the way, the distances of its children that are still to be visited.
    """
    best, found = start_sq, near
    squared = row_squared(tree, near, x, y, z)
    if squared < best:
        best = squared
    if best <= enough_sq:
        return best, found
    count, depth = tree.rows.shape[0], tree.depth
    node, level, bits, at = 1, 0, tree.root_bits, tree.root_bits
    measure_children(tree, node, x, y, z, far, level)
    while True:
        least, child = best, -1
        for c in range(WIDTH):
            if far[level, c] < least:
                least, child = far[level, c], c
        if child < 0:
            if level == 0:
                return best, found
            level -= 1
            at -= bits
            node >>= bits if level > 0 else tree.root_bits
            bits = BITS if level > 0 else tree.root_bits
            continue
        far[level, child] = np.inf
        if at == depth:
            t = (count * ((node << bits) + child - (1 << depth))) >> depth
            squared = least if tree.are_points else row_squared(tree, t, x, y, z)
            if squared < best:
                best, found = squared, t
                if best <= enough_sq:
                    return best, found
        else:
            node, level = (node << bits) + child, level + 1
            bits = BITS
            at += bits
            measure_children(tree, node, x, y, z, far, level)
