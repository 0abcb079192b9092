"""A face as a target: a height field made of a few smooth hills and hollows, our own.

Board units, looked at along −z: x to the right, y up. The mask ends at a rounded outline, from which it curves forward.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.targets.mesh_target import alignment_point, surface_height
from origami_lab.targets.target import Target

Array = NDArray[np.float64]

WIDTH, HEIGHT = 13.0, 18.0
"""Of the mask, board units."""
RISE = 4.6
"""From the rim to the middle of the mask without its features; with them it is 7 deep."""
MIDDLE = 0.4
"""y of the middle of the mask."""
TIP = (0.0, -0.75)
"""x, y of the tip of the nose: a start crease at y = 0 lies just above it."""
FINEST, COARSEST = 0.05, 1.0
"""Spacings of the mesh that still show a face, or need not."""


def features(x: Array, y: Array) -> Array:
    """Heights of brow, eyes, nose, cheeks, mouth and chin over the mask, for x ≥ 0; the other half is the same."""
    z = np.zeros_like(x)
    # the brow, and the hollow of the eye below it with the eyeball and the slit between the lids
    z += 0.55 * _ridge(y - 4.0 + 0.07 * (x - 2.0) ** 2, 0.8) * _ridge(x - 2.2, 2.4)
    z -= 1.2 * _hill(x, y, 2.6, 2.5, 1.6, 1.05)
    z -= 0.4 * _hill(x, y, 1.25, 2.6, 0.7, 0.9)
    z += 0.95 * _hill(x, y, 2.6, 2.4, 1.05, 0.68)
    z -= 0.26 * _ridge(y - 2.3 + 0.14 * (x - 2.6) ** 2, 0.17) * _ridge(x - 2.6, 1.05)
    # the nose: a back that rises from the brow to the tip, the tip, the wings
    along = np.clip((3.4 - y) / (3.4 - TIP[1]), 0.0, 1.0)
    under = _smooth((y - TIP[1] + 1.3) / 1.1)
    z += (0.5 + 1.45 * along**1.25) * _ridge(x, 0.62 + 0.4 * along) * under * _smooth((4.7 - y) / 1.7)
    z += 0.5 * _hill(x, y, *TIP, 0.85, 0.7)
    z += 0.85 * _hill(x, y, 1.1, -1.2, 0.52, 0.6)
    # the cheekbones, and the folds from the wings of the nose to the corners of the mouth
    z += 0.5 * _hill(x, y, 3.5, 0.0, 1.6, 1.5)
    z -= 0.16 * _ridge(x - 1.65 + 0.36 * (y + 1.4), 0.42) * _smooth((-1.1 - y) / 0.9) * _smooth((y + 4.3) / 1.3)
    # the mouth: upper lip, lower lip, the line between them; the groove above and the hollow below
    wide = np.exp(-((x / 1.8) ** 4))
    z += 0.55 * _ridge(y + 3.3 + 0.05 * x * x, 0.42) * wide
    z += 0.7 * _ridge(y + 4.3 - 0.08 * x * x, 0.5) * wide
    z -= 0.42 * _ridge(y + 3.76 + 0.01 * x * x, 0.17) * np.exp(-((x / 2.0) ** 4))
    z -= 0.2 * _hill(x, y, 0.0, -2.65, 0.32, 0.5)
    z -= 0.4 * _hill(x, y, 0.0, -5.25, 1.8, 0.55)
    return np.asarray(z + 0.95 * _hill(x, y, 0.0, -6.6, 1.5, 1.05))


def _ridge(distance: Array, width: float | Array) -> Array:
    return np.asarray(np.exp(-((distance / width) ** 2)))


def _hill(x: Array, y: Array, at_x: float, at_y: float, wide: float, high: float) -> Array:
    return _ridge(x - at_x, wide) * _ridge(y - at_y, high)


def _smooth(t: Array) -> Array:
    """From 0 at 0 to 1 at 1, level there and beyond."""
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def _disc(steps: int) -> tuple[Array, Array, NDArray[np.int64]]:
    """x, y of the vertices of a unit disc and its faces, counter-clockwise: a square grid pressed into it.

    Mirror-symmetric in x to the last bit; the y axis is a line of the mesh.
    """
    line = np.arange(-steps, steps + 1) / steps
    u, v = np.meshgrid(line, line)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    # every square is cut away from the centre, so that no triangle has its three corners on the rim's flat side
    rising = (u[:-1, :-1] + u[1:, 1:]) * (v[:-1, :-1] + v[1:, 1:]) > 0
    cuts = (((a, b, c), rising), ((a, c, d), rising), ((a, b, d), ~rising), ((b, c, d), ~rising))
    faces = np.concatenate([np.stack(corners, axis=-1)[where] for corners, where in cuts])
    x, y = u * np.sqrt(1.0 - 0.5 * v * v), v * np.sqrt(1.0 - 0.5 * u * u)
    return x.ravel(), y.ravel(), faces


def face(spacing: float = 0.25, align_z: bool | Sequence[float] = True) -> Target:
    """A human face, 13 wide, 18 high and 7 deep: open. Its highest point is the tip of the nose, at x = 0, y ≈ −0.8.

    Parameters
    ----------
    spacing
        Largest step of the mesh across the face, board units. The mesh is mirror-symmetric in x to the last bit.
    align_z
        True: the surface at the origin, where the start crease lies, is at z = 0; ``[x, y]``: at that point.
        False: the tip of the nose is.

    Raises
    ------
    InputError
        If ``spacing`` is out of range, or ``align_z`` not a point of the face.
    """
    if isinstance(spacing, bool) or not isinstance(spacing, int | float) or not FINEST <= spacing <= COARSEST:
        raise InputError("target.spacing", spacing, f"must be a number from {FINEST} to {COARSEST} (board units)")
    x, y, faces = _disc(math.ceil(0.5 * HEIGHT / spacing))
    rim = np.hypot(x, y)
    # the outline narrows towards the chin
    across = 0.5 * WIDTH * np.abs(x) * (1.0 - 0.24 * np.clip(-y, 0.0, 1.0) ** 1.5)
    up = MIDDLE + 0.5 * HEIGHT * y
    z = features(across, up) * (1.0 - rim**8) - RISE * rim**2.8
    vertices = np.column_stack([np.copysign(across, x), up, z])
    place = alignment_point(align_z)
    vertices[:, 2] -= z.max() if place is None else surface_height(vertices[faces], place, "the face")
    return Target("face", vertices, faces, closed=False, up=(0.0, 1.0, 0.0), front=(0.0, 0.0, 1.0))
