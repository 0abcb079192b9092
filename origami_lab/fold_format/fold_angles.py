"""Fold angles of creases, measured on folded vertices."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from origami_lab.fold_format.flat_graph import Array, Face, Indices
from origami_lab.fold_format.laid_flat import panel_normal

_FLAT_FOLDED = math.radians(0.02)
"""So near to 180° the sign of a measured angle is not known: it is the letter's."""


def measured_angles(edges: Indices, faces: Sequence[Face], coords: Array, letters: Sequence[str]) -> Array:
    """(E,) fold angles in radians at folded vertices ``coords`` (V, 3), valley positive; 0 for edges without two faces.

    ``faces`` run counter-clockwise in the flat sheet.
    """
    sides: dict[tuple[int, int], int] = {}
    for index, face in enumerate(faces):
        sides |= dict.fromkeys(zip(face, (*face[1:], face[0]), strict=True), index)
    normals = [panel_normal(coords, face) for face in faces]
    out = np.zeros(len(edges))
    for e, (u, v) in enumerate(edges.tolist()):
        if (u, v) not in sides or (v, u) not in sides:
            continue
        left, right = normals[sides[u, v]], normals[sides[v, u]]
        along = coords[v] - coords[u]
        sine = float(np.cross(right, left) @ along) / (float(np.linalg.norm(along)) or 1.0)
        angle = math.atan2(sine, float(right @ left))
        if abs(angle) > math.pi - _FLAT_FOLDED and letters[e] in "MV":
            angle = math.copysign(angle, 1.0 if letters[e] == "V" else -1.0)
        out[e] = angle
    return out
