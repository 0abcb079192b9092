"""Folded states as the file gives them: are panels rigid, what are the fold angles, what is the flat sheet."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from origami_lab.verification.flat_sheet import Sheet, SheetError
from origami_lab.verification.fold_document import Document
from origami_lab.verification.plane_graph import Array, Face, cross


def bending(sheet: Sheet, coords: Array) -> Array:
    """(F,) how far each folded panel is from its flat self, as a part of the panel's diameter.

    The folded panel is laid back onto the flat one as well as a rigid motion can; the furthest vertex counts. That
    covers lengths of edges, all other distances, and planarity.
    """
    flat = np.column_stack([sheet.points, np.zeros(len(sheet.points))])
    return np.array([_misfit(flat[list(face)], coords[list(face)]) for face in sheet.faces])


def _misfit(flat: Array, folded: Array) -> float:
    p, q = flat - flat.mean(axis=0), folded - folded.mean(axis=0)
    u, _, vt = np.linalg.svd(p.T @ q)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0]) @ vt
    return float(np.linalg.norm(p @ turn - q, axis=1).max() / np.linalg.norm(p[:, None] - p[None], axis=2).max())


def length_error(sheet: Sheet, coords: Array) -> tuple[float, int]:
    """The largest relative change of an edge's length, and the edge."""
    u, v = sheet.edges.T
    flat = np.linalg.norm(sheet.points[u] - sheet.points[v], axis=1)
    error = np.abs(np.linalg.norm(coords[u] - coords[v], axis=1) - flat) / flat
    return float(error.max()), int(np.argmax(error))


def fold_angles(sheet: Sheet, coords: Array) -> Array:
    """(E,) fold angles measured on folded vertices, in (−π, π], valley positive; 0 on the boundary."""
    normals = np.array([_normal(coords, face) for face in sheet.faces])
    out = np.zeros(len(sheet.edges))
    inner = np.flatnonzero(sheet.inner)
    left, right = normals[sheet.beside[inner, 0]], normals[sheet.beside[inner, 1]]
    along = coords[sheet.edges[inner, 1]] - coords[sheet.edges[inner, 0]]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along /= np.where(length > 0.0, length, 1.0)  # a crease that a file folds to a point is refuted for its length
    sine = np.einsum("nj,nj->n", cross(right, left), along)
    out[inner] = np.arctan2(sine, np.einsum("nj,nj->n", right, left))
    return out


def _normal(coords: Array, face: Face) -> Array:
    ring = coords[list(face)] - coords[face[0]]
    normal = cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(normal))
    return normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])


def unfolded(document: Document, coords: Array) -> Array:
    """(V, 2) the flat sheet of a file that has only folded states, by laying panel after panel into the plane.

    Raises :class:`SheetError` where panels do not fit: the state does not come from one flat sheet.
    """
    if document.faces is None:
        raise SheetError("a file without a flat crease pattern must name its panels (faces_vertices)")
    flat = np.full((len(coords), 2), np.nan)
    size = float(np.ptp(coords, axis=0).max()) or 1.0
    sides = defaultdict(list)
    for index, face in enumerate(document.faces):
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            sides[u, v].append(index)
    if any(len(found) > 1 for found in sides.values()):
        raise SheetError("panels that share an edge must run along it in opposite directions")
    first = document.faces[0]
    flat[[first[0], first[1]]] = [[0.0, 0.0], [float(np.linalg.norm(coords[first[1]] - coords[first[0]])), 0.0]]
    _lay(flat, coords, first, 0, size)
    done, queue = {0}, [0]
    while queue:
        face = document.faces[queue.pop(0)]
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            for index in sides.get((v, u), ()):
                if index not in done:
                    done.add(index)
                    queue.append(index)
                    _lay(flat, coords, document.faces[index], document.faces[index].index(v), size)
    return np.where(np.isnan(flat), 0.0, flat)


def _lay(flat: Array, coords: Array, face: Face, start: int, size: float) -> None:
    """Lay a panel beside its side ``start``, whose ends are in place."""
    ring = [*face[start:], *face[:start]]
    p, q = coords[ring[0]], coords[ring[1]]
    x = (q - p) / (float(np.linalg.norm(q - p)) or 1.0)
    normal = _normal(coords, face)
    y = cross(normal, x)
    a, b = flat[ring[0]], flat[ring[1]]
    u = (b - a) / (float(np.linalg.norm(b - a)) or 1.0)
    across = np.array([-u[1], u[0]])
    for v in ring:
        d = coords[v] - p
        place = a + float(d @ x) * u + float(d @ y) * across
        if np.isnan(flat[v, 0]):
            flat[v] = place
        elif np.linalg.norm(flat[v] - place) > 1e-5 * size:
            raise SheetError(f"the folded panels do not come from one flat sheet: they do not fit around vertex {v}")
