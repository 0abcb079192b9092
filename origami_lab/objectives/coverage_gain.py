"""Which samples of a target the folded sheet covers, kept up to date while the sheet grows and is taken back.

The samples that are still uncovered are the first ``uncovered`` elements of a permutation, ``order``; ``where`` is its
inverse. A covered sample is swapped behind them, so what a move gains is undone by setting ``uncovered`` back, and a
random uncovered sample is one look away. A placed panel never moves: what is covered stays so as the sheet grows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.state import Record, has_image, image_code
from origami_lab.geometry.bvh import Bvh
from origami_lab.geometry.distance import point_edges_squared
from origami_lab.jit import bare, inlined

Array = NDArray[np.float64]

FEW_LEVELS = 3
"""Levels of the tree, from the leaves up, whose boxes are not worth looking at."""


class Coverage(NamedTuple):
    """The samples of a target, the uncovered ones first.

    Attributes
    ----------
    samples
        Tree over the n samples as triangles without area; they have the numbers of its leaves.
    points
        (n, 3) the samples.
    order
        (n,) int32, a permutation of the samples: uncovered ones, then covered ones, the latest covered first.
    where
        (n,) int32, the inverse of ``order``.
    """

    samples: Bvh
    points: Array
    order: NDArray[np.int32]
    where: NDArray[np.int32]


def new_coverage(samples: Bvh) -> Coverage:
    """Nothing is covered yet: ``uncovered`` is the number of samples."""
    order = np.arange(len(samples.triangles), dtype=np.int32)
    return Coverage(samples, np.ascontiguousarray(samples.triangles[:, 0]), order, order.copy())


@inlined
def is_apart(box: Array, low: tuple[float, float, float], high: tuple[float, float, float]) -> bool:
    """Whether a box of the tree has no point in common with the one from ``low`` to ``high``."""
    return bool(
        box[0] > high[0]
        or box[3] < low[0]
        or box[1] > high[1]
        or box[4] < low[1]
        or box[2] > high[2]
        or box[5] < low[2]
    )


@bare
def cover_triangle(coverage: Coverage, depth: int, corners: Array, distance: float, uncovered: int) -> int:
    """Cover all samples within ``distance`` of a triangle (3, 3); returns how many are uncovered now.

    ``depth`` is that of the tree's leaves. The tree is walked from right to left, down to nodes of a few leaves.
    """
    boxes, points = coverage.samples.boxes, coverage.points
    order, where = coverage.order, coverage.where
    count, p = points.shape[0], corners
    low = (
        min(p[0, 0], p[1, 0], p[2, 0]) - distance,
        min(p[0, 1], p[1, 1], p[2, 1]) - distance,
        min(p[0, 2], p[1, 2], p[2, 2]) - distance,
    )
    high = (
        max(p[0, 0], p[1, 0], p[2, 0]) + distance,
        max(p[0, 1], p[1, 1], p[2, 1]) + distance,
        max(p[0, 2], p[1, 2], p[2, 2]) + distance,
    )
    squared = distance * distance
    # the triangle as point_edges_squared takes it
    ax, ay, az = p[0, 0], p[0, 1], p[0, 2]
    bx, by, bz = p[1, 0] - ax, p[1, 1] - ay, p[1, 2] - az
    cx, cy, cz = p[2, 0] - ax, p[2, 1] - ay, p[2, 2] - az
    nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    n_squared, b_squared = nx * nx + ny * ny + nz * nz, bx * bx + by * by + bz * bz
    c_squared = cx * cx + cy * cy + cz * cz
    node, level, last = 1, 0, max(depth - FEW_LEVELS, 0)
    while True:
        if not is_apart(boxes[node], low, high):
            if level < last:
                node, level = 2 * node + 1, level + 1
                continue
            leaves = 1 << (depth - level)
            for leaf in range((node + 1) * leaves - 1, node * leaves - 1, -1):
                position = leaf - (1 << depth)
                for i in range((count * position) >> depth, (count * (position + 1)) >> depth):
                    at = where[i]
                    if at >= uncovered:
                        continue
                    x, y, z = points[i, 0] - ax, points[i, 1] - ay, points[i, 2] - az
                    edges = bx, by, bz, cx, cy, cz, nx, ny, nz, n_squared, b_squared, c_squared
                    if point_edges_squared(x, y, z, *edges) <= squared and not is_apart(boxes[leaf], low, high):
                        uncovered -= 1
                        other = order[uncovered]
                        order[at], where[other] = other, at
                        order[uncovered], where[i] = i, uncovered
        while node & 1 == 0:  # nothing is left of it
            node, level = node >> 1, level - 1
        if node == 1:
            return uncovered
        node -= 1


@bare
def cover_panels(s: Record, r: Record, k: int, first: int, coverage: Coverage, distance: float, uncovered: int) -> int:
    """Cover what the triangles from ``first`` on and their images come near at driving angle k.

    Returns how many samples are uncovered then. Setting the number back undoes it, the latest first.
    """
    depth = 0
    while (2 << depth) < coverage.samples.boxes.shape[0]:
        depth += 1
    for t in range(first, s.n_triangles):
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                for j in range(3):
                    place_corner(s, r, image_code(r, g, s.corners[t, j]), k, s.triangle, j)
                uncovered = cover_triangle(coverage, depth, s.triangle, distance, uncovered)
    return uncovered
