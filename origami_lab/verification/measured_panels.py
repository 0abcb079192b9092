"""Folded states as the file gives them: are panels rigid, what are the fold angles, what is the flat sheet."""

from __future__ import annotations

import numpy as np

from origami_lab.fold_format.laid_flat import PiecesError, UnfoldError, unfold
from origami_lab.verification.flat_sheet import Sheet, SheetError, UndecidableError
from origami_lab.verification.fold_document import Document
from origami_lab.verification.plane_graph import Array, Indices, cross


def bending(sheet: Sheet, coords: Array) -> Array:
    """(F,) how far each folded panel is from its flat self, as a part of the panel's diameter.

    The folded panel is laid back onto the flat one as well as a rigid motion can; the furthest vertex counts. That
    covers lengths of edges, all other distances, and planarity.
    """
    flat = np.column_stack([sheet.points, np.zeros(len(sheet.points))])
    out = np.zeros(len(sheet.faces))
    for numbers, rings in _by_corners(sheet):
        p, q = (points[rings] - points[rings].mean(axis=1, keepdims=True) for points in (flat, coords))
        turned = p.transpose(0, 2, 1) @ q
        usable = np.isfinite(turned).all(axis=(1, 2))
        u, _, vt = np.linalg.svd(np.where(usable[:, None, None], turned, np.eye(3)))
        side = np.sign(np.linalg.det(u @ vt))
        u[:, :, 2] *= np.where(side == 0.0, 1.0, side)[:, None]
        misfit = np.linalg.norm(p @ u @ vt - q, axis=2).max(axis=1)
        out[numbers] = np.where(usable, misfit, np.inf) / _widest(p)
    return out


def diameters(sheet: Sheet) -> Array:
    """(F,) the largest distance of two corners of each flat panel."""
    out = np.zeros(len(sheet.faces))
    for numbers, rings in _by_corners(sheet):
        out[numbers] = _widest(sheet.points[rings])
    return out


def _by_corners(sheet: Sheet) -> list[tuple[Indices, Indices]]:
    """Panels with equally many corners: their numbers (n,) and their rings of vertices (n, corners)."""
    groups: dict[int, list[int]] = {}
    for index, face in enumerate(sheet.faces):
        groups.setdefault(len(face), []).append(index)
    return [(np.array(some), np.array([sheet.faces[f] for f in some])) for some in groups.values()]


def _widest(rings: Array) -> Array:
    """(n,) the largest distance of two corners of polygons (n, corners, dimensions)."""
    far = np.zeros(len(rings))
    for shift in range(1, rings.shape[1] // 2 + 1):  # from corner to corner at each distance along the ring
        far = np.maximum(far, np.linalg.norm(rings - np.roll(rings, shift, axis=1), axis=2).max(axis=1))
    return far


def length_error(sheet: Sheet, coords: Array) -> tuple[float, int]:
    """The largest relative change of an edge's length, and the edge."""
    u, v = sheet.edges.T
    flat = np.linalg.norm(sheet.points[u] - sheet.points[v], axis=1)
    error = np.abs(np.linalg.norm(coords[u] - coords[v], axis=1) - flat) / flat
    return float(error.max()), int(np.argmax(error))


def fold_angles(sheet: Sheet, coords: Array) -> Array:
    """(E,) fold angles measured on folded vertices, in (−π, π], valley positive; 0 on the boundary."""
    normals = np.zeros((len(sheet.faces), 3))
    for numbers, rings in _by_corners(sheet):
        rel = coords[rings] - coords[rings[:, :1]]
        normal = cross(rel, np.roll(rel, -1, axis=1)).sum(axis=1)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normals[numbers] = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), [0.0, 0.0, 1.0])
    out = np.zeros(len(sheet.edges))
    inner = np.flatnonzero(sheet.inner)
    left, right = normals[sheet.beside[inner, 0]], normals[sheet.beside[inner, 1]]
    along = coords[sheet.edges[inner, 1]] - coords[sheet.edges[inner, 0]]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along /= np.where(length > 0.0, length, 1.0)  # a crease that a file folds to a point is refuted for its length
    sine = np.einsum("nj,nj->n", cross(right, left), along)
    out[inner] = np.arctan2(sine, np.einsum("nj,nj->n", right, left))
    return out


def unfolded(document: Document, coords: Array) -> Array:
    """(V, 2) the flat sheet of a file that has only folded states, by laying panel after panel into the plane.

    Raises :class:`SheetError` where panels do not fit: the state does not come from one flat sheet;
    :class:`UndecidableError` where the file does not name its panels.
    """
    if document.faces is None:
        raise UndecidableError("a file without a flat crease pattern must name its panels (faces_vertices)")
    try:
        return np.nan_to_num(unfold(document.faces, coords, 4.0 * document.precision.folded))
    except PiecesError as error:
        raise UndecidableError(str(error)) from None
    except UnfoldError as error:
        raise SheetError(str(error)) from None
