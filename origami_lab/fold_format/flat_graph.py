"""The crease pattern as a graph in the plane: where its edges meet, and the faces between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Face = tuple[int, ...]

_CHUNK = 500_000


def crossing_edges(points: Array, edges: Indices, tolerance: float) -> tuple[int, int] | None:
    """Two edges that meet anywhere but in a common end, if there are.

    They cross, overlap, or an end of one lies within ``tolerance`` of the inside of the other. ``points`` (V, 2),
    ``edges`` (E, 2), none of length 0.
    """
    for i, j in meetings(points, edges, tolerance):
        return int(min(i[0], j[0])), int(max(i[0], j[0]))
    return None


def meetings(points: Array, edges: Indices, tolerance: float) -> Iterator[tuple[Indices, Indices]]:
    """All pairs of edges that :func:`crossing_edges` speaks of, a bounded number at a time."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    low, high = np.minimum(a, b) - tolerance, np.maximum(a, b) + tolerance
    order = np.argsort(low[:, 0], kind="stable")
    ends = np.searchsorted(low[order, 0], high[order, 0], side="right")
    counts = np.maximum(ends - np.arange(len(order)) - 1, 0)
    start = 0
    while start < len(order):  # pairs whose x-ranges overlap
        stop = max(start + 1, start + int(np.searchsorted(np.cumsum(counts[start:]), _CHUNK)))
        some = counts[start:stop]
        first = np.repeat(np.arange(start, stop), some)
        second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(some) - some, some)
        i, j = order[first], order[second]
        near = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
        i, j = i[near], j[near]
        found = np.flatnonzero(_meet(points, edges[i], edges[j], tolerance))
        if len(found):
            yield i[found], j[found]
        start = stop


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
    """Signed area of a flat polygon, positive counter-clockwise; ``points`` (V, 2)."""
    x, y = (points[list(face)] - points[face[0]]).T  # what stands at the first vertex is 0
    return float(x[1:-1] @ y[2:] - y[1:-1] @ x[2:]) / 2.0


def faces_between(points: Array, edges: Indices) -> list[Face]:
    """The bounded faces of a plane graph, counter-clockwise; dangling edges are walked on both sides.

    ``points`` (V, 2), ``edges`` (E, 2); an edge that is listed twice counts once.
    """
    spokes: dict[int, list[int]] = {}
    for u, v in dict.fromkeys((min(edge), max(edge)) for edge in edges.tolist()):
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


def without_holes(faces: Sequence[Face], edges: Indices, outer: NDArray[np.bool_]) -> list[Face]:
    """The faces that are no holes: a hole has only boundary edges, each with another face on its other side.

    ``outer`` (E,) says which of ``edges`` (E, 2) are marked as boundary.
    """
    marked = {(min(edge), max(edge)): bool(border) for edge, border in zip(edges.tolist(), outer, strict=True)}
    beside: dict[tuple[int, int], int] = {}
    rings = [[(min(s), max(s)) for s in zip(face, (*face[1:], face[0]), strict=True)] for face in faces]
    for ring in rings:
        for side in ring:
            beside[side] = beside.get(side, 0) + 1
    return [
        face
        for face, ring in zip(faces, rings, strict=True)
        if not all(marked.get(side, False) and beside[side] == 2 for side in ring)
    ]
