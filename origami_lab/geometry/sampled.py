"""Random points on a surface and the nearest of them, compiled: the paper's Hausdorff distance has them on both sides.

The points of one triangle stand together, so the tree over the triangles serves for their points, too: those of a
triangle are never nearer than the triangle. Sampling thousands of points and building a tree over them for every sheet
and driving angle would take twenty times as long.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, box_squared, build_bvh, nearest_squared, nearest_triangle
from origami_lab.jit import bare, inlined, kernel

Array = NDArray[np.float64]


class Sampled(NamedTuple):
    """A surface, or the points drawn on it; see :func:`sample_surface`.

    Attributes
    ----------
    tree
        Over the T triangles of the surface.
    starts
        (T + 1,) int64: triangle ``t``, in the order before the tree was built, has the points from ``starts[t]`` to
        ``starts[t + 1]``.
    points
        (n, 3) float64. None: the surface itself is meant.
    """

    tree: Bvh
    starts: NDArray[np.int64]
    points: Array


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
    points = np.empty((number, 3))
    if number == 0:
        return Sampled(build_bvh(triangles), starts, points)
    cumulative = np.empty(count)
    total = 0.0
    for t in range(count):
        ux, uy, uz = triangles[t, 1] - triangles[t, 0]
        vx, vy, vz = triangles[t, 2] - triangles[t, 0]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        total += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
        cumulative[t] = total
    t = 0
    for i in range(number):
        while t < count - 1 and draws[i, 0] * total >= cumulative[t]:
            t += 1
            starts[t] = i
        root, along = draws[i, 1], draws[i, 2]
        for axis in range(3):
            points[i, axis] = (
                (1.0 - root) * triangles[t, 0, axis]
                + root * (1.0 - along) * triangles[t, 1, axis]
                + root * along * triangles[t, 2, axis]
            )
    starts[t + 1 :] = number
    return Sampled(build_bvh(triangles), starts, points)


@inlined
def _nearest_of(sampled: Sampled, t: int, x: float, y: float, z: float, best: float) -> float:
    """The smaller of ``best`` and the squared distance to the points of triangle ``t`` of the tree."""
    points = sampled.points
    original = sampled.tree.original[t]
    for i in range(sampled.starts[original], sampled.starts[original + 1]):
        dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
        best = min(best, dx * dx + dy * dy + dz * dz)
    return best


@bare
def nearest_sample_squared(sampled: Sampled, x: float, y: float, z: float, enough_sq: float, start_sq: float) -> float:
    """Squared distance from (x, y, z) to the nearest point, or to the surface if there are no points.

    ``enough_sq`` and ``start_sq`` are those of :func:`~origami_lab.geometry.bvh.nearest_squared`.
    """
    tree = sampled.tree
    if sampled.points.shape[0] == 0:
        return nearest_squared(tree, x, y, z, enough_sq, start_sq)
    _, nearest = nearest_triangle(tree, x, y, z, 0.0, start_sq)
    if nearest < 0:
        return start_sq
    # it most likely has the nearest point, too; the other triangles are looked at if they might have a nearer one
    best = _nearest_of(sampled, nearest, x, y, z, start_sq)
    count, leaves = tree.triangles.shape[0], tree.boxes.shape[0] >> 1
    for leaf in range(leaves):
        if best <= enough_sq:
            return best
        if box_squared(tree.boxes, leaves + leaf, x, y, z) < best:
            for t in range(count * leaf // leaves, count * (leaf + 1) // leaves):
                if t != nearest:
                    best = _nearest_of(sampled, t, x, y, z, best)
    return best
