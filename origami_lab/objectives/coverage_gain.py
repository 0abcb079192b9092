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
from origami_lab.geometry.distance import point_triangle_squared
from origami_lab.jit import bare, inlined

Array = NDArray[np.float64]


class Coverage(NamedTuple):
    """The samples of a target, the uncovered ones first.

    Attributes
    ----------
    samples
        Tree over the n samples as triangles without area; they have the numbers of its leaves.
    order
        (n,) int32, a permutation of the samples: uncovered ones, then covered ones, the latest covered first.
    where
        (n,) int32, the inverse of ``order``.
    """

    samples: Bvh
    order: NDArray[np.int32]
    where: NDArray[np.int32]


def new_coverage(samples: Bvh) -> Coverage:
    """Nothing is covered yet: ``uncovered`` is the number of samples."""
    order = np.arange(len(samples.triangles), dtype=np.int32)
    return Coverage(samples, order, order.copy())


@inlined
def covers(p: Array, x: float, y: float, z: float, squared: float) -> bool:
    """Whether a point lies within a squared distance of the triangle p, (3, 3)."""
    return bool(
        point_triangle_squared(x, y, z, p[0, 0], p[0, 1], p[0, 2], p[1, 0], p[1, 1], p[1, 2], p[2, 0], p[2, 1], p[2, 2])
        <= squared
    )


@bare
def cover_triangle(coverage: Coverage, depth: int, corners: Array, distance: float, uncovered: int) -> int:
    """Cover all samples within ``distance`` of a triangle (3, 3); returns how many are uncovered now.

    ``depth`` is that of the tree's leaves. The tree is walked from right to left.
    """
    boxes, points = coverage.samples.boxes, coverage.samples.triangles
    order, where = coverage.order, coverage.where
    count, p = points.shape[0], corners
    low_x, high_x = min(p[0, 0], p[1, 0], p[2, 0]) - distance, max(p[0, 0], p[1, 0], p[2, 0]) + distance
    low_y, high_y = min(p[0, 1], p[1, 1], p[2, 1]) - distance, max(p[0, 1], p[1, 1], p[2, 1]) + distance
    low_z, high_z = min(p[0, 2], p[1, 2], p[2, 2]) - distance, max(p[0, 2], p[1, 2], p[2, 2]) + distance
    squared = distance * distance
    node, level = 1, 0
    while True:
        if not (
            boxes[node, 0] > high_x
            or boxes[node, 3] < low_x
            or boxes[node, 1] > high_y
            or boxes[node, 4] < low_y
            or boxes[node, 2] > high_z
            or boxes[node, 5] < low_z
        ):
            if level < depth:
                node, level = 2 * node + 1, level + 1
                continue
            position = node - (1 << level)
            for i in range((count * position) >> level, (count * (position + 1)) >> level):
                at = where[i]
                if at < uncovered and covers(p, points[i, 0, 0], points[i, 0, 1], points[i, 0, 2], squared):
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
