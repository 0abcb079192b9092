"""Flat polygons in space, and the triangles that they consist of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_STRAIGHT = 1e-9
"""Sine of the turn up to which a corner counts as straight."""


class Polygons(NamedTuple):
    """The faces of a file as it has them."""

    vertices: Array
    """(V, 3)"""
    corners: Indices
    """All polygons' vertices, one polygon after the other."""
    sizes: Indices
    """(P,) corners of each polygon."""

    @classmethod
    def of(cls, vertices: Array, rings: Sequence[Sequence[int]]) -> Polygons:
        """From one sequence of vertices a polygon."""
        corners = np.array([vertex for ring in rings for vertex in ring], dtype=np.int64)
        return cls(vertices, corners, np.array([len(ring) for ring in rings], dtype=np.int64))

    @property
    def triangle_count(self) -> int:
        """How many triangles :func:`triangulate` makes of them."""
        return int(np.maximum(self.sizes - 2, 0).sum())

    @property
    def exist(self) -> bool:
        """Whether all vertices that are named are there."""
        corners = self.corners
        return len(corners) == 0 or bool(corners.min() >= 0 and corners.max() < len(self.vertices))


def triangulate(polygons: Polygons) -> Indices:
    """The triangles (T, 3) of polygons, in their order and with their sense of rotation.

    A polygon of n corners becomes n − 2 triangles between its own corners, also where corners lie on a straight side,
    so that no neighbour gets a gap. Convex ones are fans about their first corner; the others are cut by ears
    (``manifold3d``) as they look along their normal. Of a polygon that crosses itself, no triangulation is right.
    """
    found, owners = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    first = np.cumsum(polygons.sizes) - polygons.sizes
    for size in np.unique(polygons.sizes[polygons.sizes >= 3]):
        which = np.nonzero(polygons.sizes == size)[0]
        rings = polygons.corners[first[which, None] + np.arange(size)]
        fans = np.column_stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)])
        cut = np.repeat(fans[None], len(which), axis=0)  # places in the ring
        if size > 3:
            for k in np.nonzero(~_is_convex(polygons.vertices[rings], fans))[0]:
                cut[k] = _ears(polygons.vertices[rings[k]], fans)
        found.append(rings[np.arange(len(which))[:, None, None], cut].reshape(-1, 3))
        owners.append(np.repeat(which, size - 2))
    return np.concatenate(found)[np.argsort(np.concatenate(owners), kind="stable")]


def _is_convex(points: Array, fans: Indices) -> NDArray[np.bool_]:
    """(P,) whether rings (P, n, 3) are strictly convex as seen along their normals."""
    points = _scaled(points)
    here, ahead = points - np.roll(points, 1, axis=1), np.roll(points, -1, axis=1) - points
    normals = _normals(points)
    turns = np.einsum("pnk,pk->pn", np.cross(here, ahead), normals)
    lengths = np.linalg.norm(here, axis=2) * np.linalg.norm(ahead, axis=2)
    a, b, c = (points[:, fans[:, k]] for k in range(3))
    fan_areas = np.einsum("ptk,pk->pt", np.cross(b - a, c - a), normals)  # one that winds twice has negative ones
    return np.asarray((turns > _STRAIGHT * lengths).all(axis=1) & (fan_areas > 0.0).all(axis=1))


def _ears(ring: Array, fans: Indices) -> Indices:
    """(n − 2, 3) places in a ring (n, 3) of any shape."""
    import manifold3d  # here: most meshes have no such polygon

    points = _scaled(ring[None])
    normal = _normals(points)[0]
    axis = int(np.argmax(np.abs(normal)))
    if normal[axis] == 0.0:  # no area, or as much of it to the left as to the right
        return fans
    # leaving out a coordinate keeps straight sides straight to the last bit; what is counter-clockwise must stay so
    others = [(axis + 1) % 3, (axis + 2) % 3][:: 1 if normal[axis] > 0.0 else -1]
    return np.asarray(manifold3d.triangulate([np.ascontiguousarray(points[0][:, others])]), dtype=np.int64)


def _scaled(rings: Array) -> Array:
    """Each ring moved and scaled to about 1, so that no product is too large or too small."""
    moved = rings - rings[:, :1]
    size = np.abs(moved).max(axis=(1, 2), keepdims=True)
    return np.asarray(moved / np.where(size > 0.0, size, 1.0))


def _normals(rings: Array) -> Array:
    """(P, 3) unit normals by Newell's sum, which holds for rings of any shape; zero where there is no area."""
    total = np.cross(rings, np.roll(rings, -1, axis=1)).sum(axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-14, total / np.where(length > 0.0, length, 1.0), 0.0))
