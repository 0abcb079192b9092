"""An orthographic camera that looks down at the sheet from one side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

AZIMUTH, ELEVATION = -62.0, 36.0
"""Degrees. Into a bowl rather than at its side, and off the planes of symmetry, which would hide half."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the picture is taken from and how large things appear."""

    axes: NDArray[np.float64]
    """(3, 3) rows: to the right, down and towards the viewer."""
    scale: float
    """Pixels per board cell."""
    offset: NDArray[np.float64]
    """(2,) pixels at which the origin appears."""

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) points in board cells → column, row and nearness in pixels."""
        seen: NDArray[np.float64] = points @ self.axes.T * self.scale
        seen[..., :2] += self.offset
        return seen

    def facing(self, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) directions in the frame right, up, towards the viewer."""
        turned: NDArray[np.float64] = normals @ self.axes.T * np.array([1.0, -1.0, 1.0])
        return turned


def frame_points(
    points: NDArray[np.float64],
    window: tuple[float, float, float, float],
    azimuth: float = AZIMUTH,
    elevation: float = ELEVATION,
    upright: NDArray[np.float64] | None = None,
) -> Camera:
    """The camera for which (N, 3) ``points`` just fill the window (left, top, right, bottom in pixels).

    ``upright`` (3, 3) is the rotation that stands the sheet as it is used.
    """
    a, e = math.radians(azimuth), math.radians(elevation)
    viewer = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    axes = np.array([right, np.cross(right, viewer), viewer])
    if upright is not None:
        axes = axes @ upright
    seen = points @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = np.array([window[2] - window[0], window[3] - window[1]])
    scale = float(np.min(room / np.maximum(high - low, 1e-9)))
    centre = np.array([window[0] + window[2], window[1] + window[3]]) / 2
    return Camera(axes, scale, centre - scale * (low + high) / 2)
