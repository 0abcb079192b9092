"""The flat sheet as a plane graph: crossings, the faces between the edges, triangulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Face = tuple[int, ...]

FLAT_TOLERANCE = 1e-9
"""Of the sheet's size: closer than this, flat points coincide."""
_CHUNK = 500_000
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


def crossing_edges(points: Array, edges: Indices, tolerance: float) -> tuple[int, int] | None:
    """Two edges that meet anywhere but in a common end, if there are.

    They cross, overlap, or an end of one lies within ``tolerance`` of the inside of the other.
    """
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    low, high = np.minimum(a, b) - tolerance, np.maximum(a, b) + tolerance
    order = np.argsort(low[:, 0], kind="stable")
    ends = np.searchsorted(low[order, 0], high[order, 0], side="right")
    counts = np.maximum(ends - np.arange(len(order)) - 1, 0)
    start = 0
    while start < len(order):  # pairs whose x-ranges overlap, a bounded number at a time
        stop = max(start + 1, start + int(np.searchsorted(np.cumsum(counts[start:]), _CHUNK)))
        some = counts[start:stop]
        first = np.repeat(np.arange(start, stop), some)
        second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(some) - some, some)
        i, j = order[first], order[second]
        near = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
        i, j = i[near], j[near]
        found = np.flatnonzero(_meet(points, edges[i], edges[j], tolerance))
        if len(found):
            return int(min(i[found[0]], j[found[0]])), int(max(i[found[0]], j[found[0]]))
        start = stop
    return None


def _meet(points: Array, first: Indices, second: Indices, tolerance: float) -> NDArray[np.bool_]:
    """(N,) whether pairs of edges meet outside a common end."""
    a, b, c, d = (points[v] for v in (first[:, 0], first[:, 1], second[:, 0], second[:, 1]))
    out = (_side(a, b, c, tolerance) * _side(a, b, d, tolerance) < 0) & (
        _side(c, d, a, tolerance) * _side(c, d, b, tolerance) < 0
    )
    for edge, p, q, other in ((first, a, b, second), (second, c, d, first)):
        for column, point in ((0, points[other[:, 0]]), (1, points[other[:, 1]])):
            own_end = (other[:, column] == edge[:, 0]) | (other[:, column] == edge[:, 1])
            along = q - p
            t = np.einsum("nj,nj->n", point - p, along) / np.einsum("nj,nj->n", along, along)
            off = point - (p + np.clip(t, 0.0, 1.0)[:, None] * along)
            out |= ~own_end & (np.hypot(off[:, 0], off[:, 1]) <= tolerance)
    return np.asarray(out)


def _side(a: Array, b: Array, p: Array, tolerance: float) -> Indices:
    """On which side of the lines a–b the points lie; 0 within the tolerance."""
    u, w = b - a, p - a
    height = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / np.hypot(u[:, 0], u[:, 1])
    return np.where(np.abs(height) <= tolerance, 0, np.sign(height)).astype(np.int64)


def area(points: Array, face: Sequence[int]) -> float:
    """Signed area of a flat polygon, positive counter-clockwise."""
    ring = points[list(face)] - points[face[0]]
    following = np.roll(ring, -1, axis=0)
    return float(np.sum(ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0])) / 2.0


def faces_between(points: Array, edges: Indices) -> list[Face]:
    """The bounded faces of a plane graph, counter-clockwise; dangling edges are walked on both sides."""
    spokes: dict[int, list[int]] = {}
    for u, v in edges.tolist():
        spokes.setdefault(u, []).append(v)
        spokes.setdefault(v, []).append(u)
    following: dict[tuple[int, int], tuple[int, int]] = {}
    for v, ends in spokes.items():
        d = points[ends] - points[v]
        ring = [ends[i] for i in np.argsort(np.arctan2(d[:, 1], d[:, 0]), kind="stable")]
        for at, w in enumerate(ring):  # arriving from w, with the face on the left, leave clockwise next of w
            following[w, v] = (v, ring[at - 1])
    faces, left = [], dict.fromkeys(following)
    while left:
        start = next(iter(left))
        side, ring = start, []
        while True:
            ring.append(side[0])
            del left[side]
            side = following[side]
            if side == start:
                break
        if area(points, ring) > 0.0:
            faces.append(tuple(ring))
    return faces


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
