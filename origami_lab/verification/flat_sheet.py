"""The flat sheet: is it one, and who is beside whom."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.fold_document import Document
from origami_lab.verification.plane_graph import (
    FLAT_TOLERANCE,
    Array,
    Face,
    Indices,
    area,
    coincident,
    crossing_edges,
    faces_between,
    triangulated,
)

_SMALLEST = 1e-6
"""Units: products of smaller coordinates lose their meaning."""


class SheetError(Exception):
    """The crease pattern is no valid sheet; the message says where."""


class UndecidableError(Exception):
    """What is checked here cannot be decided for this file; the message says why."""


@dataclass(frozen=True, eq=False)
class Fan:
    """An interior vertex with its edges, counter-clockwise, and the sector that follows each of them."""

    vertex: int
    edges: tuple[int, ...]
    sectors: Array
    """(d,) radians, 2π in all."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A valid flat sheet: a plane graph whose bounded faces are the panels."""

    points: Array
    """(V, 2)"""
    edges: Indices
    """(E, 2); of an edge with two panels the first one lies on the left of u→v."""
    beside: Indices
    """(E, 2) the panels on the left and on the right of u→v, −1 for none."""
    faces: tuple[Face, ...]
    """Counter-clockwise polygons."""
    fans: tuple[Fan, ...]
    triangles: Indices
    """(T, 3)"""
    owner: Indices
    """(T,) the panel of each triangle."""
    holes: tuple[Face, ...]
    """Boundary loops around holes."""

    @property
    def inner(self) -> NDArray[np.bool_]:
        """(E,) whether an edge lies between two panels."""
        return np.asarray((self.beside >= 0).all(axis=1))

    @property
    def size(self) -> float:
        """The larger side of the box around the sheet."""
        return float(np.ptp(self.points, axis=0).max())


def build_sheet(flat: Array, document: Document) -> Sheet:
    """Check the crease pattern and build the sheet, its panels from the graph where the file names none.

    Raises :class:`SheetError` with the first thing that is wrong, :class:`UndecidableError` on cuts.
    """
    edges, letters = document.edges, document.letters
    if "C" in letters:
        raise UndecidableError(f"edge {letters.index('C')} is a cut, and cuts are not supported")
    size = float(np.ptp(flat, axis=0).max())
    if not size > _SMALLEST:
        raise SheetError(f"the sheet is smaller than {_SMALLEST:g}")
    used = np.unique(edges)
    if (pair := coincident(flat[used], FLAT_TOLERANCE * size)) is not None:
        raise SheetError(f"vertices {used[pair[0]]} and {used[pair[1]]} are in one place")
    names, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if len(names) < len(edges):
        u, v = names[np.argmax(counts)]
        raise SheetError(f"there are {counts.max()} edges {u}–{v}")
    if (pair := crossing_edges(flat, edges, FLAT_TOLERANCE * size)) is not None:
        raise SheetError(f"edges {pair[0]} and {pair[1]} cross or overlap")
    between = faces_between(flat, edges)
    outer = np.array([letter == "B" for letter in letters])
    faces = (
        _given(flat, document.faces, between) if document.faces is not None else _without_holes(between, edges, outer)
    )
    for index, face in enumerate(faces):
        if len(set(face)) < len(face):
            raise SheetError(f"panel {index} is not a simple polygon: it visits a vertex twice")
        if area(flat, face) <= FLAT_TOLERANCE * size * size:
            raise SheetError(f"panel {index} has no area")
    beside = _beside(edges, faces)
    inner = np.asarray((beside >= 0).all(axis=1))
    for e in np.flatnonzero((beside < 0).all(axis=1)):
        raise SheetError(f"edge {e} belongs to no panel")
    for e in np.flatnonzero(inner & outer):
        raise SheetError(f"edge {e} is marked as boundary but lies between panels {beside[e, 0]} and {beside[e, 1]}")
    for e in np.flatnonzero(~inner & ~outer & np.array([letter in "MVFJ" for letter in letters])):
        raise SheetError(f"edge {e} is marked as a crease but has one panel only")
    _one_piece(len(faces), beside[inner])
    triangles = [(triangle, index) for index, face in enumerate(faces) for triangle in triangulated(flat, face)]
    return Sheet(
        points=flat,
        edges=edges,
        beside=beside,
        faces=tuple(faces),
        fans=_fans(flat, edges, inner),
        triangles=np.array([triangle for triangle, _ in triangles], dtype=np.int64),
        owner=np.array([index for _, index in triangles], dtype=np.int64),
        holes=_holes(flat, edges, beside),
    )


def _given(flat: Array, given: tuple[Face, ...], between: list[Face]) -> list[Face]:
    """The file's panels, counter-clockwise, each of which must be a face between the edges, and each once."""
    known = {_canonical(face) for face in between}
    faces: list[Face] = []
    seen: dict[Face, int] = {}
    for index, face in enumerate(given):
        ring = face if area(flat, face) > 0.0 else tuple(reversed(face))
        name = _canonical(ring)
        if name in seen:
            raise SheetError(f"panels {seen[name]} and {index} are the same")
        if name not in known:
            raise SheetError(f"panel {index} is not a face between the edges of the pattern")
        seen[name] = index
        faces.append(ring)
    return faces


def _canonical(face: Face) -> Face:
    start = face.index(min(face))
    return face[start:] + face[:start]


def _without_holes(between: list[Face], edges: Indices, outer: NDArray[np.bool_]) -> list[Face]:
    """Faces with boundary edges only, beside other faces, are holes."""
    if not between:
        raise SheetError("the edges enclose no panel")
    beside = _beside(edges, between)
    two = (beside >= 0).all(axis=1)
    lone = [not any(f in row for row in beside[~(outer & two)]) for f in range(len(between))]
    return [face for face, hole in zip(between, lone, strict=True) if not hole]


def _beside(edges: Indices, faces: list[Face]) -> Indices:
    """(E, 2) panels on the left and right of each edge; raises where a panel's side is no edge or is used twice."""
    number = {(int(u), int(v)): (e, 0) for e, (u, v) in enumerate(edges)}
    number |= {(int(v), int(u)): (e, 1) for e, (u, v) in enumerate(edges)}
    beside = np.full((len(edges), 2), -1, dtype=np.int64)
    for index, face in enumerate(faces):
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            if (u, v) not in number:
                raise SheetError(f"the side {u}–{v} of panel {index} is no edge")
            e, side = number[u, v]
            if beside[e, side] >= 0:
                raise SheetError(f"panels {beside[e, side]} and {index} lie on the same side of edge {e}")
            beside[e, side] = index
    return beside


def _one_piece(count: int, pairs: Indices) -> None:
    """Every panel hangs together with every other over edges."""
    neighbours = defaultdict(list)
    for p, q in pairs.tolist():
        neighbours[p].append(q)
        neighbours[q].append(p)
    seen, queue = {0}, [0]
    while queue:
        for q in neighbours[queue.pop()]:
            if q not in seen:
                seen.add(q)
                queue.append(q)
    if len(seen) < count:
        lost = min(set(range(count)) - seen)
        raise SheetError(f"the sheet is in pieces: panel {lost} does not hang together with panel 0")


def _fans(flat: Array, edges: Indices, inner: NDArray[np.bool_]) -> tuple[Fan, ...]:
    """The interior vertices; raises where the sheet touches itself in a vertex."""
    spokes = defaultdict(list)
    for e, (u, v) in enumerate(edges.tolist()):
        spokes[u].append((e, v))
        spokes[v].append((e, u))
    fans = []
    for vertex, found in sorted(spokes.items()):
        borders = sum(not inner[e] for e, _ in found)
        if borders not in (0, 2):
            raise SheetError(f"the sheet touches itself in vertex {vertex}")
        if borders:
            continue
        d = flat[[end for _, end in found]] - flat[vertex]
        heading = np.arctan2(d[:, 1], d[:, 0])
        order = np.argsort(heading)
        heading = heading[order]
        sectors = np.append(np.diff(heading), heading[0] + 2.0 * np.pi - heading[-1])
        fans.append(Fan(vertex, tuple(found[i][0] for i in order), sectors))
    return tuple(fans)


def _holes(flat: Array, edges: Indices, beside: Indices) -> tuple[Face, ...]:
    """Boundary loops that run clockwise when the sheet is on the left."""
    following = {}
    for e in np.flatnonzero((beside < 0).any(axis=1)):
        u, v = (int(x) for x in edges[e])
        if beside[e, 0] < 0:
            u, v = v, u
        following[u] = v
    holes = []
    while following:
        start, v = following.popitem()
        loop = [start]
        while v != start:
            loop.append(v)
            v = following.pop(v)
        if area(flat, loop) < 0.0:
            holes.append(tuple(loop))
    return tuple(holes)
