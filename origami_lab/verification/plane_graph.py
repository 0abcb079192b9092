"""Flat points and polygons: coincidence, triangulation; vector products."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Face = tuple[int, ...]

FLAT_TOLERANCE = 1e-9
"""Of the sheet's size: closer than this, flat points coincide."""
_YZX, _ZXY = [1, 2, 0], [2, 0, 1]


def cross(a: Array, b: Array) -> Array:
    """Vector products along the last axis; ``np.cross`` takes ten times as long for a few vectors."""
    return np.asarray(a[..., _YZX] * b[..., _ZXY] - a[..., _ZXY] * b[..., _YZX])


def coincident(points: Array, tolerance: float) -> tuple[int, int] | None:
    """Two points (of (V, 2)) that are within a tolerance of each other, if there are."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    for at, i in enumerate(order):
        for j in order[at + 1 :]:
            if points[j, 0] - points[i, 0] > tolerance:
                break
            if abs(points[j, 1] - points[i, 1]) <= tolerance:
                return int(min(i, j)), int(max(i, j))
    return None


def triangulated(points: Array, face: Sequence[int]) -> list[tuple[int, int, int]]:
    """A counter-clockwise simple polygon cut into triangles over all of its vertices, by clipping ears.

    Vertices in the middle of a side stay corners of triangles, so that neighbours meet corner to corner.
    """
    ring, found = list(face), []
    while len(ring) > 3:
        at = _ear(points[ring])
        found.append((ring[at - 1], ring[at], ring[(at + 1) % len(ring)]))
        del ring[at]
    return [*found, (ring[0], ring[1], ring[2])]


def _ear(ring: Array) -> int:
    """The corner to clip: the ear that is furthest from a sliver."""
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)

    def twice(a: Array, b: Array, c: Array) -> Array:
        u, w = b - a, c - a
        return np.asarray(u[..., 0] * w[..., 1] - u[..., 1] * w[..., 0])

    size = twice(before, ring, after)
    longest = np.max(
        [np.sum((p - q) ** 2, axis=1) for p, q in ((ring, before), (ring, after), (before, after))], axis=0
    )
    score = size / longest
    for at in np.argsort(-score):
        if score[at] <= 0.0:
            break
        a, b, c = before[at], ring[at], after[at]
        inside = (twice(a, b, ring) >= 0.0) & (twice(b, c, ring) >= 0.0) & (twice(c, a, ring) >= 0.0)
        inside[[at, at - 1, (at + 1) % len(ring)]] = False
        rest = np.delete(ring, at, axis=0)
        if not inside.any() and np.any(np.abs(twice(rest[0], rest[1], rest)) > 0.0):
            return int(at)
    return int(np.argmax(score))
