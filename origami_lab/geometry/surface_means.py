"""Means over surfaces: how far a surface lies from another one on average, and how much of it has a like near by.

A surface is cut into cells of about one area each, and each cell is looked at in its centroid, weighted by its area.
Distance to a plane is linear, so what lies before a flat piece is measured exactly; elsewhere the error falls with the
area of a cell.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, inside, nearest_squared, triangle_squared
from origami_lab.jit import kernel

Array = NDArray[np.float64]


class Cells(NamedTuple):
    """A surface in pieces.

    Attributes
    ----------
    points
        (n, 3) the centroids of the pieces.
    areas
        (n,) their areas.
    normals
        (n, 3) their unit normals.
    """

    points: Array
    areas: Array
    normals: Array


@kernel
def unit_normal(triangles: Array, t: int, out: Array, row: int) -> float:
    """Write the unit normal of triangle ``t``; returns its area, 0 for one without a normal."""
    nx = (triangles[t, 1, 1] - triangles[t, 0, 1]) * (triangles[t, 2, 2] - triangles[t, 0, 2])
    nx -= (triangles[t, 1, 2] - triangles[t, 0, 2]) * (triangles[t, 2, 1] - triangles[t, 0, 1])
    ny = (triangles[t, 1, 2] - triangles[t, 0, 2]) * (triangles[t, 2, 0] - triangles[t, 0, 0])
    ny -= (triangles[t, 1, 0] - triangles[t, 0, 0]) * (triangles[t, 2, 2] - triangles[t, 0, 2])
    nz = (triangles[t, 1, 0] - triangles[t, 0, 0]) * (triangles[t, 2, 1] - triangles[t, 0, 1])
    nz -= (triangles[t, 1, 1] - triangles[t, 0, 1]) * (triangles[t, 2, 0] - triangles[t, 0, 0])
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not length > 0.0:
        return 0.0
    out[row, 0], out[row, 1], out[row, 2] = nx / length, ny / length, nz / length
    return float(0.5 * length)


@kernel
def cells_of(triangles: Array, cell_area: float) -> Cells:
    """Cut (T, 3, 3) triangles into n² equal cells each, of at most ``cell_area`` > 0; one without area has none."""
    count = triangles.shape[0]
    normals, areas, parts = np.empty((count, 3)), np.zeros(count), np.zeros(count, np.int64)
    total = 0
    for t in range(count):
        areas[t] = unit_normal(triangles, t, normals, t)
        if areas[t] > 0.0:
            parts[t] = max(1, int(np.ceil(np.sqrt(areas[t] / cell_area) - 1e-9)))
            total += parts[t] * parts[t]
    cells = Cells(np.empty((total, 3)), np.empty(total), np.empty((total, 3)))
    row = 0
    for t in range(count):
        n = parts[t]
        for i in range(n):
            for j in range(2 * (n - i) - 1):
                # the upright cell (i, j/2), or the one turned round beside it
                u = (i + (2.0 if j % 2 else 1.0) / 3.0) / n
                v = (j // 2 + (2.0 if j % 2 else 1.0) / 3.0) / n
                for k in range(3):
                    a, b, c = triangles[t, 0, k], triangles[t, 1, k], triangles[t, 2, k]
                    cells.points[row, k] = a + u * (b - a) + v * (c - a)
                    cells.normals[row, k] = normals[t, k]
                cells.areas[row] = areas[t] / (n * n)
                row += 1
    return cells


@kernel
def mean_distance(cells: Cells, target: Bvh, solid: bool, enough: float) -> float:
    """The mean distance of a surface from another one; infinite as soon as it is known to be no less than ``enough``.

    Parameters
    ----------
    target
        Tree over the other one's triangles.
    solid
        Whether what lies inside the (watertight) other one counts as distance 0.
    """
    points = cells.points
    whole, so_far = 0.0, 0.0
    for i in range(points.shape[0]):
        whole += cells.areas[i]
    if not whole > 0.0:
        return np.inf
    for i in range(points.shape[0]):
        squared = nearest_squared(target, points[i, 0], points[i, 1], points[i, 2], 0.0, np.inf)
        if squared > 0.0 and not (solid and inside(target, points[i, 0], points[i, 1], points[i, 2])):
            so_far += cells.areas[i] * np.sqrt(squared)
            if so_far >= enough * whole:
                return np.inf
    return float(so_far / whole)


@kernel
def like_share(cells: Cells, triangles: Array, near: float, cosine: float) -> float:
    """The share of a surface's area that has a triangle within ``near`` whose plane is turned by little against it.

    Parameters
    ----------
    triangles
        (T, 3, 3) those of the other surface; ones without area are none.
    cosine
        That of the largest angle between the normals, either way round.
    """
    count, points = triangles.shape[0], cells.points
    normals, areas, boxes = np.empty((count, 3)), np.empty(count), np.empty((count, 6))
    for t in range(count):
        areas[t] = unit_normal(triangles, t, normals, t)
        for k in range(3):
            a, b, c = triangles[t, 0, k], triangles[t, 1, k], triangles[t, 2, k]
            boxes[t, k], boxes[t, 3 + k] = min(a, b, c) - near, max(a, b, c) + near
    whole, alike = 0.0, 0.0
    for i in range(points.shape[0]):
        whole += cells.areas[i]
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for t in range(count):
            if not (areas[t] > 0.0 and boxes[t, 0] <= x <= boxes[t, 3] and boxes[t, 1] <= y <= boxes[t, 4]):
                continue
            turned = 0.0
            for k in range(3):
                turned += cells.normals[i, k] * normals[t, k]
            if abs(turned) >= cosine and triangle_squared(triangles, t, x, y, z) <= near * near:
                alike += cells.areas[i]
                break
    return float(alike / whole) if whole > 0.0 else 0.0


def thinned(cells: Cells, count: int) -> Cells:
    """About so many of a surface's cells where it has more, chosen evenly by area, which they share."""
    if len(cells.areas) <= count:
        return cells
    sums = np.cumsum(cells.areas)
    chosen = np.searchsorted(sums, (np.arange(count) + 0.5) / count * sums[-1])
    chosen = np.minimum(chosen, len(cells.areas) - 1)
    return Cells(cells.points[chosen].copy(), np.full(count, sums[-1] / count), cells.normals[chosen].copy())
