"""The flat sheet of a folded form, by laying panel after panel into the plane."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from origami_lab.fold_format.flat_graph import Array, Face

_FITS = 1e-5
"""Of the form's size: panels that miss each other by no more come from one flat sheet."""


class UnfoldError(Exception):
    """The folded form does not come from one flat sheet; the message says why."""


class PiecesError(UnfoldError):
    """The panels do not hang together by edges."""


def unfold(faces: Sequence[Face], coords: Array, tolerance: float = 0.0) -> Array:
    """(V, 2) the flat sheet of panels whose folded vertices are ``coords`` (V, 3); NaN for vertices of no panel.

    ``tolerance`` is added to what panels may miss each other by. Raises :class:`UnfoldError` where they do not fit,
    :class:`PiecesError` where they do not hang together.
    """
    flat = np.full((len(coords), 2), np.nan)
    size = float(np.ptp(coords, axis=0).max()) or 1.0
    sides = defaultdict(list)
    for index, face in enumerate(faces):
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            sides[u, v].append(index)
    if any(len(found) > 1 for found in sides.values()):
        raise UnfoldError("panels that share an edge must run along it in opposite directions")
    first = faces[0]
    flat[[first[0], first[1]]] = [[0.0, 0.0], [float(np.linalg.norm(coords[first[1]] - coords[first[0]])), 0.0]]
    allowed = _FITS * size + tolerance
    _lay(flat, coords, first, 0, allowed)
    done, queue = {0}, [0]
    for at in queue:
        face = faces[at]
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            for index in sides.get((v, u), ()):
                if index not in done:
                    done.add(index)
                    queue.append(index)
                    _lay(flat, coords, faces[index], faces[index].index(v), allowed)
    if len(done) < len(faces):
        lost = min(set(range(len(faces))) - done)
        raise PiecesError(f"the sheet is in pieces: panel {lost} does not hang together with panel 0")
    return flat


def run_alike(faces: Sequence[Face]) -> tuple[tuple[Face, ...], bool]:
    """The faces, turned where need be so that neighbours run along their common side in opposite directions.

    Most keep the direction that they have. Also whether any was turned.
    """
    at = defaultdict(list)
    for index, face in enumerate(faces):
        for u, v in zip(face, (*face[1:], face[0]), strict=True):
            at[min(u, v), max(u, v)].append((index, u < v))
    beside = defaultdict(list)
    for found in at.values():
        if len(found) == 2:
            (i, one), (j, other) = found
            beside[i].append((j, one == other))
            beside[j].append((i, one == other))
    turned: dict[int, bool] = {}
    for start in range(len(faces)):
        if start in turned:
            continue
        piece, turned[start] = [start], False
        for i in piece:
            for j, alike in beside[i]:
                if j not in turned:
                    turned[j] = turned[i] ^ alike
                    piece.append(j)
        if 2 * sum(turned[i] for i in piece) > len(piece):
            turned |= {i: not turned[i] for i in piece}
    out = tuple(face[::-1] if turned[index] else tuple(face) for index, face in enumerate(faces))
    return out, any(turned.values())


def panel_normal(coords: Array, face: Face) -> Array:
    """(3,) the unit normal of a panel with folded vertices ``coords`` (V, 3); z where it has no area."""
    ring = coords[list(face)] - coords[face[0]]
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(normal))
    return np.asarray(normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0]))


def _lay(flat: Array, coords: Array, face: Face, start: int, allowed: float) -> None:
    """Lay a panel beside its side ``start``, whose ends are in place."""
    ring = [*face[start:], *face[:start]]
    p, q = coords[ring[0]], coords[ring[1]]
    x = (q - p) / (float(np.linalg.norm(q - p)) or 1.0)
    y = np.cross(panel_normal(coords, face), x)
    a, b = flat[ring[0]], flat[ring[1]]
    u = (b - a) / (float(np.linalg.norm(b - a)) or 1.0)
    across = np.array([-u[1], u[0]])
    for v in ring:
        d = coords[v] - p
        place = a + float(d @ x) * u + float(d @ y) * across
        if np.isnan(flat[v, 0]):
            flat[v] = place
        elif np.linalg.norm(flat[v] - place) > allowed:
            raise UnfoldError(f"the folded panels do not come from one flat sheet: they do not fit around vertex {v}")
