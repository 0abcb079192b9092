"""Triangles that stay in touch edge to edge while they move: a plane that moves along parts them.

Creases on one line of the flat sheet may keep their panels' edges in contact over the whole motion. No fixed plane
parts such panels over an interval; the one through both edges does. Its normal is the product of a fixed side and a
moving one, a cubic in Bernstein form, so what it says of the corners are polynomials that lie between their
coefficients.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.plane_graph import cross

Array = NDArray[np.float64]

_NEXT = (1, 2, 0)


def sliding_gap(p: Array, controls: Array, error: Array) -> Array:
    """By how much planes through a side of each part a still triangle from a moving one, at worst.

    Parameters
    ----------
    p
        (N, 3, 3) corners of the still triangles.
    controls
        (N, 4, 3, 3) control points of the cubics on which the corners of the others move.
    error
        (N,) how far the true corners may be from the cubics.

    Returns
    -------
    (N,) distances, negative where no such plane parts them.
    """
    sides = p[:, _NEXT] - p
    moving = controls[:, :, _NEXT] - controls
    normals = cross(sides[:, :, None, None], moving.transpose(0, 2, 1, 3)[:, None])  # (N, 3, 3, 4, 3)
    still = np.einsum("nikrx,nijx->nikrj", normals, p[:, None] - p[:, :, None])
    rel = controls[:, None] - p[:, :, None, None]  # (N, 3 sides, 4, 3 corners, 3)
    products = np.einsum("nikrx,nisjx->nikrsj", normals, rel)
    moved = np.zeros((*products.shape[:3], 7, 3))
    for r in range(4):
        for s in range(4):
            moved[:, :, :, r + s] += products[:, :, :, r, s] * (math.comb(3, r) * math.comb(3, s) / math.comb(6, r + s))
    still, moved = still.reshape(len(p), 9, -1), moved.reshape(len(p), 9, -1)
    one = np.minimum(still.min(axis=2), -moved.max(axis=2))
    other = np.minimum(-still.max(axis=2), moved.min(axis=2))
    size = np.linalg.norm(normals, axis=4).min(axis=3).reshape(len(p), 9)
    lengths = np.linalg.norm(sides, axis=2)
    # an error of the corners shifts the plane, and turns it
    turned = 2.0 * np.repeat(lengths, 3, axis=1) * np.linalg.norm(rel, axis=4).max(axis=(1, 2, 3))[:, None]
    usable = size > 1e-6 * lengths.max(axis=1)[:, None] ** 2
    safe = np.where(usable, size, 1.0)
    gap = np.maximum(one, other) / safe - error[:, None] * (1.0 + turned / safe)
    return np.asarray(np.where(usable, gap, -np.inf).max(axis=1))
