"""The flat sheet: is it one, and who is beside whom."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.flat_graph import area, faces_between, meetings, without_holes
from origami_lab.verification.fold_document import Document
from origami_lab.verification.plane_graph import FLAT_TOLERANCE, Array, Face, Indices, coincident, triangulated

_SMALLEST = 1e-6
"""Units: products of smaller coordinates lose their meaning."""


class SheetError(Exception):
    """The crease pattern is no valid sheet; the message says where."""


class OverlapError(SheetError):
    """Vertices, edges or panels lie upon each other, as they do in a folded form."""


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

    @cached_property
    def inner(self) -> NDArray[np.bool_]:
        """(E,) whether an edge lies between two panels."""
        return np.asarray((self.beside >= 0).all(axis=1))

    @cached_property
    def size(self) -> float:
        """The larger side of the box around the panels."""
        return float(np.ptp(self.points[np.unique(np.concatenate(self.faces))], axis=0).max())


def build_sheet(flat: Array, document: Document) -> Sheet:
    """Check the crease pattern ``flat`` (V, 2) and build the sheet; panels that the file does not name are found.

    Auxiliary lines are no part of it. Raises :class:`SheetError` with the first thing that is wrong,
    :class:`UndecidableError` on cuts, on separate pieces, and on what the file's rounding may have brought about.
    """
    if document.fault:
        raise SheetError(document.fault)
    letters = document.letters
    loose = np.zeros(len(letters), dtype=np.bool_) if document.loose is None else document.loose
    edges, kept = document.edges, np.flatnonzero(~loose)
    used = np.unique(edges[kept])
    size = float(np.ptp(flat[used], axis=0).max())
    if not size > _SMALLEST:
        raise (UndecidableError if size > 0.0 else SheetError)(f"the sheet is smaller than {_SMALLEST:g}")
    off = document.precision.flat
    if (pair := coincident(flat[used], FLAT_TOLERANCE * size)) is not None:
        text = f"vertices {used[pair[0]]} and {used[pair[1]]} are in one place"
        raise too_imprecise(document, text, 10.0) if off > 0.0 else OverlapError(text)
    names, counts = np.unique(np.sort(edges[kept], axis=1), axis=0, return_counts=True)
    if len(names) < len(kept):
        u, v = names[np.argmax(counts)]
        raise SheetError(f"there are {counts.max()} edges {u}–{v}")
    _uncrossed(flat, document, kept, size)
    _no_ends(document, kept)
    between = faces_between(flat, edges[kept])
    outer = np.array([letter == "B" for letter in letters])
    if document.faces is not None:
        faces = _given(flat, document.faces, between)
    elif not between:
        raise OverlapError("the edges enclose no panel")
    else:
        faces = without_holes(between, edges[kept], np.array([letters[e] in "BC" for e in kept]))
    for index, face in enumerate(faces):
        if len(set(face)) < len(face):
            raise SheetError(f"panel {index} is not a simple polygon: it visits a vertex twice")
        size_of = area(flat, face)
        if size_of <= FLAT_TOLERANCE * size * size:
            raise OverlapError(f"panel {index} has no area")
        if (thin := 2.0 * off * _around(flat, face) / size_of) > 0.5:
            raise too_imprecise(document, f"panel {index} is as thin as what the file rounds off", 10.0 * thin)
    beside = _beside(edges, kept, faces)
    inner = np.asarray((beside >= 0).all(axis=1))
    for e in np.flatnonzero((beside < 0).all(axis=1) & ~loose):
        raise SheetError(f"edge {e} belongs to no panel")
    for e in np.flatnonzero(inner & np.array([letter == "C" for letter in letters])):
        raise UndecidableError(f"edge {e} is a cut between two panels, and cuts are not supported")
    for e in np.flatnonzero(inner & outer):
        raise SheetError(f"edge {e} is marked as boundary but lies between panels {beside[e, 0]} and {beside[e, 1]}")
    for e in np.flatnonzero(~inner & ~loose & np.array([letter in "MV" for letter in letters])):
        raise SheetError(f"edge {e} is marked as a crease but has one panel only")
    _one_piece(len(faces), beside[inner])
    triangles = [(triangle, index) for index, face in enumerate(faces) for triangle in triangulated(flat, face)]
    return Sheet(
        points=flat,
        edges=edges,
        beside=beside,
        faces=tuple(faces),
        fans=_fans(flat, edges, kept, inner),
        triangles=np.array([triangle for triangle, _ in triangles], dtype=np.int64),
        owner=np.array([index for _, index in triangles], dtype=np.int64),
        holes=_holes(flat, edges, beside),
    )


def too_imprecise(document: Document, text: str, factor: float) -> UndecidableError:
    """The error that says what the file's rounding leaves open, and the digits that would do.

    ``factor`` is how many times smaller what is rounded off would have to be.
    """
    known = document.precision
    return UndecidableError(f"too imprecise to tell: {text} ({known.words()}; {known.finer(factor)} would do)")


def _uncrossed(flat: Array, document: Document, kept: Indices, size: float) -> None:
    """Raise where edges meet outside a common end; within what the file rounds off that is left open."""
    edges, off = document.edges[kept], document.precision.flat
    open_pair: tuple[int, int] | None = None
    for i, j in meetings(flat, edges, FLAT_TOLERANCE * size):
        near = _end_distance(flat, edges[i], edges[j]) <= 4.0 * off
        for p, q, close in zip(kept[i].tolist(), kept[j].tolist(), near.tolist(), strict=True):
            if not close:
                raise OverlapError(f"edges {min(p, q)} and {max(p, q)} cross or overlap")
            open_pair = open_pair or (min(p, q), max(p, q))
        if off == 0.0:
            p, q = int(kept[i[0]]), int(kept[j[0]])
            raise OverlapError(f"edges {min(p, q)} and {max(p, q)} cross or overlap")
    if open_pair is not None:
        raise too_imprecise(document, f"edges {open_pair[0]} and {open_pair[1]} cross or overlap", 10.0)


def _end_distance(flat: Array, first: Indices, second: Indices) -> Array:
    """(N,) the smallest distance of an end of one edge from the other edge, ends that they share left out."""
    found = []
    for edge, other in ((first, second), (second, first)):
        p, along = flat[edge[:, 0]], flat[edge[:, 1]] - flat[edge[:, 0]]
        for end in other.T:
            t = np.einsum("nj,nj->n", flat[end] - p, along) / np.einsum("nj,nj->n", along, along)
            far = np.linalg.norm(flat[end] - p - np.clip(t, 0.0, 1.0)[:, None] * along, axis=1)
            found.append(np.where((end == edge[:, 0]) | (end == edge[:, 1]), np.inf, far))
    return np.asarray(np.min(found, axis=0))


def _no_ends(document: Document, kept: Indices) -> None:
    """Raise where a crease ends inside a panel: it cannot fold, and a file that says by how much it does is wrong."""
    ends = document.edges[kept].ravel()
    names, counts = np.unique(ends, return_counts=True)
    lone = set(names[counts == 1].tolist())
    stated = [angles for angles in (document.angles, *(f.angles for f in document.frames)) if angles is not None]
    for e in kept.tolist():
        if not lone & set(document.edges[e].tolist()):
            continue
        if document.letters[e] == "B":
            raise SheetError(f"edge {e} is marked as boundary but ends where no other edge begins")
        if any(np.nan_to_num(angles[e]) != 0.0 for angles in stated):
            raise SheetError(f"edge {e} is said to fold but ends inside a panel")
        raise UndecidableError(f"edge {e} is {document.letters[e]} and ends inside a panel, where no crease can fold")


def _around(flat: Array, face: Face) -> float:
    """The length of a panel's outline."""
    ring = flat[list(face)]
    return float(np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).sum())


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
            raise OverlapError(f"panel {index} is not a face between the edges of the pattern")
        seen[name] = index
        faces.append(ring)
    return faces


def _canonical(face: Face) -> Face:
    start = face.index(min(face))
    return face[start:] + face[:start]


def _beside(edges: Indices, kept: Indices, faces: list[Face]) -> Indices:
    """(E, 2) panels on the left and right of each edge; raises where a panel's side is no edge or is used twice."""
    number = {(int(u), int(v)): (int(e), 0) for e, (u, v) in zip(kept, edges[kept], strict=True)}
    number |= {(int(v), int(u)): (int(e), 1) for e, (u, v) in zip(kept, edges[kept], strict=True)}
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
        raise UndecidableError(f"the sheet is in pieces: panel {lost} does not hang together with panel 0")


def _fans(flat: Array, edges: Indices, kept: Indices, inner: NDArray[np.bool_]) -> tuple[Fan, ...]:
    """The interior vertices; raises where the sheet touches itself in a vertex."""
    spokes = defaultdict(list)
    for e in kept.tolist():
        u, v = edges[e].tolist()
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
    for e in np.flatnonzero((beside < 0).any(axis=1) & (beside >= 0).any(axis=1)):
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
