"""A small z-buffer: which triangle is seen at each pixel, and how near it is.

matplotlib sorts whole polygons by depth, which draws large or crossing panels wrongly; here every pixel
decides for itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import kernel

NOTHING = -1
"""Owner of a pixel that no triangle covers."""

_SAME_DEPTH = 1e-3
"""Pixels. Of two triangles nearer than this the first wins, so that panels in contact do not flicker."""


def fill_z_buffer(
    corners: NDArray[np.float64],
    owners: NDArray[np.int32],
    shape: tuple[int, int],
    buffers: tuple[NDArray[np.float32], NDArray[np.int32]] | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Fill a z-buffer with triangles.

    Parameters
    ----------
    corners
        (T, 3, 3): column, row and nearness of each corner, in pixels; larger is nearer.
    owners
        (T,) what to write where the triangle is seen, ≥ 0.
    shape
        Rows and columns of the buffers.
    buffers
        The two that are to be filled, whatever is in them; by default new ones.

    Returns
    -------
    nearness, owner
        Two arrays of that shape; −inf and :data:`NOTHING` where there is nothing.
    """
    nearness, owner = buffers or (np.empty(shape, dtype=np.float32), np.empty(shape, dtype=np.int32))
    nearness[...], owner[...] = -np.inf, NOTHING
    _fill(np.ascontiguousarray(corners, dtype=np.float64), owners.astype(np.int32), nearness, owner)
    return nearness, owner


@kernel
def _fill(
    corners: NDArray[np.float64],
    owners: NDArray[np.int32],
    nearness: NDArray[np.float32],
    owner: NDArray[np.int32],
) -> None:
    """Write every triangle into the two buffers, span by span."""
    height, width = nearness.shape
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
        bx, by, bz = corners[t, 1, 0], corners[t, 1, 1], corners[t, 1, 2]
        cx, cy, cz = corners[t, 2, 0], corners[t, 2, 1], corners[t, 2, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(area) > 1e-9:  # seen edge-on, or not a number
            continue
        slope_x = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area
        slope_y = ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)) / area
        first = max(0, int(np.ceil(min(ay, by, cy) - 0.5)))
        last = min(height - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        for row in range(first, last + 1):
            y = row + 0.5
            left, right = np.inf, -np.inf
            for side in range(3):  # where the line of pixel centres crosses the outline
                px, py = corners[t, side, 0], corners[t, side, 1]
                qx, qy = corners[t, (side + 1) % 3, 0], corners[t, (side + 1) % 3, 1]
                if py == qy or y < min(py, qy) or y > max(py, qy):
                    continue
                x = px + (qx - px) * ((y - py) / (qy - py))
                left = min(left, x)
                right = max(right, x)
            if left > right:
                continue
            begin = max(0, int(np.ceil(left - 0.5)))
            end = min(width - 1, int(np.floor(right - 0.5)))
            for column in range(begin, end + 1):
                near = az + slope_x * (column + 0.5 - ax) + slope_y * (y - ay)
                if near > nearness[row, column] + _SAME_DEPTH:
                    nearness[row, column] = near
                    owner[row, column] = owners[t]
