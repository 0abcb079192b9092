"""Auxiliary lines: what editors leave in a crease pattern that is neither a crease nor an edge of the sheet."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.flat_graph import Array, Face, Indices, area, faces_between, meetings

MOST_EDGES = 8_000
"""Edges whose crossings are looked for: files with more are read without."""


def without_spurs(faces: Sequence[Face], edges: Indices, still: NDArray[np.bool_]) -> tuple[Face, ...]:
    """Faces that do not walk along a line into their inside and back again.

    Programs that find the faces between all lines write such walks. Only lines that do not fold, (E,) ``still``, are
    left out; a face keeps three vertices at least.
    """
    lines = {(min(edge), max(edge)) for edge, flat in zip(edges.tolist(), still, strict=True) if flat}
    return tuple(_without_spurs(face, lines) for face in faces)


def _without_spurs(face: Face, lines: set[tuple[int, int]]) -> Face:
    if len(set(face)) == len(face):
        return face
    ring = list(face)
    at = 0
    while at < len(ring) and len(ring) > 4:
        before, tip, after = ring[at - 1], ring[at], ring[(at + 1) % len(ring)]
        if before == after and (min(before, tip), max(before, tip)) in lines:
            for index in sorted({at, (at + 1) % len(ring)}, reverse=True):
                del ring[index]
            at = max(0, at - 2)
        else:
            at += 1
    return tuple(ring)


def auxiliary_lines(
    points: Array,
    edges: Indices,
    still: NDArray[np.bool_],
    border: NDArray[np.bool_],
    faces: Sequence[Face] | None,
    tolerance: float,
) -> NDArray[np.bool_]:
    """(E,) which edges are neither sides of panels nor creases.

    Parameters
    ----------
    points, edges
        (V, 2) and (E, 2), the flat pattern.
    still
        (E,) edges that may be auxiliary: neither boundary nor crease, nor said to fold.
    border
        (E,) edges that are marked as boundary.
    faces
        The panels that the file lists, None if it lists none; then the lines must do without: they end nowhere, lie
        apart from the sheet, meet other edges where there is no vertex, or lie outside.
    tolerance
        Lengths that count as 0.
    """
    loose = np.zeros(len(edges), dtype=np.bool_)
    sure = not still.all()  # without assignments every edge may be any
    if not still.any():
        return loose
    if faces is not None:
        sides = {(min(u, v), max(u, v)) for face in faces for u, v in zip(face, (*face[1:], face[0]), strict=True)}
        used = np.array([(min(edge), max(edge)) in sides for edge in edges.tolist()], dtype=np.bool_)
        loose = still & ~used
        return loose | _repeated(edges, still, loose)
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    loose |= still & (length <= tolerance)
    loose |= _repeated(edges, still, loose)
    solid = np.flatnonzero(~loose & (length > 0.0))
    if sure and len(solid) <= MOST_EDGES:
        for i, j in meetings(points, edges[solid], tolerance):
            for one in (solid[i], solid[j]):
                loose[one[still[one]]] = True
    while True:
        before = int(loose.sum())
        for block in _blocks(edges, np.flatnonzero(~loose)):
            if still[block].all() and (sure or len(block) == 1):
                loose[block] = True
        if sure and before == loose.sum():
            loose[list(_outside(points, edges, still, border, loose))] = True
        if before == loose.sum():
            return loose


def _repeated(edges: Indices, still: NDArray[np.bool_], loose: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(E,) lines between the same two vertices as another edge, which is kept."""
    kept: dict[tuple[int, int], int] = {}
    out = np.zeros(len(edges), dtype=np.bool_)
    for e in sorted(np.flatnonzero(~loose).tolist(), key=lambda e: (bool(still[e]), e)):  # creases come first
        u, v = edges[e].tolist()
        out[e] = kept.setdefault((min(u, v), max(u, v)), e) != e and still[e]
    return out


def _blocks(edges: Indices, kept: Indices) -> Iterator[list[int]]:
    """The edges by blocks: two edges are in one block where a cycle runs through both.

    A line of a panel's inside that ends there is a block by itself; lines that hang on the sheet by one vertex, or by
    none, are blocks without any edge of it. Hopcroft and Tarjan's walk, without recursion.
    """
    at: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for e in kept.tolist():
        u, v = edges[e].tolist()
        at[u].append((e, v))
        at[v].append((e, u))
    order: dict[int, int] = {}
    lowest: dict[int, int] = {}
    for root in at:
        if root in order:
            continue
        order[root] = lowest[root] = len(order)
        walk = [(root, -1, iter(at[root]))]
        taken: list[int] = []
        while walk:
            v, come, ways = walk[-1]
            step = next(ways, None)
            if step is None:
                walk.pop()
                if walk:
                    u = walk[-1][0]
                    lowest[u] = min(lowest[u], lowest[v])
                    if lowest[v] >= order[u]:
                        block = [taken.pop()]
                        while block[-1] != come:
                            block.append(taken.pop())
                        yield block
                continue
            e, w = step
            if e == come:
                continue
            if w not in order:
                order[w] = lowest[w] = len(order)
                taken.append(e)
                walk.append((w, e, iter(at[w])))
            elif order[w] < order[v]:
                taken.append(e)
                lowest[v] = min(lowest[v], order[w])


def _outside(
    points: Array, edges: Indices, still: NDArray[np.bool_], border: NDArray[np.bool_], loose: NDArray[np.bool_]
) -> set[int]:
    """Lines outside the sheet: the face that they close has, beside them, only boundary that has a face already."""
    kept = np.flatnonzero(~loose)
    number = {(min(edge), max(edge)): e for e, edge in zip(kept.tolist(), edges[kept].tolist(), strict=True)}
    faces = [
        [number[min(s), max(s)] for s in zip(face, (*face[1:], face[0]), strict=True)]
        for face in faces_between(points, edges[kept])
    ]
    count: dict[int, int] = defaultdict(int)
    for ring in faces:
        for e in ring:
            count[e] += 1
    found: set[int] = set()
    for ring in faces:
        lines = [e for e in ring if still[e] and count[e] == 1]
        others = [e for e in ring if not still[e]]
        if lines and others and all(border[e] and count[e] == 2 for e in others):
            found |= set(lines)
    return found


def net_area(points: Array, faces: Sequence[Face]) -> float:
    """The sum of the faces' signed areas: negative where most of the sheet is listed clockwise."""
    return float(sum(area(points, face) for face in faces))
