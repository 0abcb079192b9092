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
from origami_lab.geometry.bvh import Bvh, triangle_squared
from origami_lab.jit import kernel

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


@kernel
def cover_triangle(coverage: Coverage, corners: Array, distance: float, uncovered: int) -> int:
    """Cover all samples within ``distance`` of a triangle (3, 3); returns how many are uncovered now."""
    boxes, points = coverage.samples.boxes, coverage.samples.triangles
    order, where = coverage.order, coverage.where
    count = points.shape[0]
    depth = 0
    while (2 << depth) < boxes.shape[0]:
        depth += 1
    low, high = np.empty(3), np.empty(3)
    for j in range(3):
        low[j] = min(corners[0, j], corners[1, j], corners[2, j]) - distance
        high[j] = max(corners[0, j], corners[1, j], corners[2, j]) + distance
    triangle = corners.reshape(1, 3, 3)
    squared = distance * distance
    stack, levels = np.empty(64, np.int64), np.empty(64, np.int64)
    stack[0], levels[0] = 1, 0
    size = 1
    while size > 0:
        size -= 1
        node, level = stack[size], levels[size]
        if (
            boxes[node, 0] > high[0]
            or boxes[node, 3] < low[0]
            or boxes[node, 1] > high[1]
            or boxes[node, 4] < low[1]
            or boxes[node, 2] > high[2]
            or boxes[node, 5] < low[2]
        ):
            continue
        if level < depth:
            stack[size], levels[size] = 2 * node, level + 1
            stack[size + 1], levels[size + 1] = 2 * node + 1, level + 1
            size += 2
            continue
        position = node - (1 << level)
        for i in range((count * position) >> level, (count * (position + 1)) >> level):
            at = where[i]
            if at < uncovered and triangle_squared(triangle, 0, points[i, 0, 0], points[i, 0, 1], points[i, 0, 2]) <= (
                squared
            ):
                uncovered -= 1
                other = order[uncovered]
                order[at], where[other] = other, at
                order[uncovered], where[i] = i, uncovered
    return uncovered


@kernel
def cover_panels(s: Record, r: Record, k: int, first: int, coverage: Coverage, distance: float, uncovered: int) -> int:
    """Cover what the triangles from ``first`` on and their images come near at driving angle k.

    Returns how many samples are uncovered then. Setting the number back undoes it, the latest first.
    """
    corners = np.empty((3, 3))
    for t in range(first, s.n_triangles):
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                for j in range(3):
                    place_corner(s, r, image_code(r, g, s.corners[t, j]), k, corners, j)
                uncovered = cover_triangle(coverage, corners, distance, uncovered)
    return uncovered
