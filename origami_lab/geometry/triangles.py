"""Do two triangles in space pass through each other?

Contact is not collision: triangles that touch, share a vertex or an edge, or lie in one plane (stacked sheets
of no thickness) do not cross. They cross where the interior of each reaches through the plane of the other by
more than a tolerance, along a segment longer than it. Touching configurations of a folded sheet are exact up
to rounding (about 1e-13 board cells), so a tolerance of 1e-9 separates contact from collision.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import bare, inlined

CONTACT_TOLERANCE = 1e-9
"""Penetration in board cells up to which two panels are in contact, not in collision."""

Array = NDArray[np.float64]


@inlined
def _plane_interval(t: Array, d0: float, d1: float, d2: float, ux: float, uy: float, uz: float) -> tuple[float, float]:
    """The interval along u in which triangle t meets a plane, given its corners' signed distances to it.

    At least one distance is positive and one negative; zeros lie in the plane.
    """
    low, high = np.inf, -np.inf
    s0 = ux * t[0, 0] + uy * t[0, 1] + uz * t[0, 2]
    s1 = ux * t[1, 0] + uy * t[1, 1] + uz * t[1, 2]
    s2 = ux * t[2, 0] + uy * t[2, 1] + uz * t[2, 2]
    if d0 * d1 < 0.0:
        s = s0 + (s1 - s0) * (d0 / (d0 - d1))
        low, high = min(low, s), max(high, s)
    if d1 * d2 < 0.0:
        s = s1 + (s2 - s1) * (d1 / (d1 - d2))
        low, high = min(low, s), max(high, s)
    if d2 * d0 < 0.0:
        s = s2 + (s0 - s2) * (d2 / (d2 - d0))
        low, high = min(low, s), max(high, s)
    if d0 == 0.0:
        low, high = min(low, s0), max(high, s0)
    if d1 == 0.0:
        low, high = min(low, s1), max(high, s1)
    if d2 == 0.0:
        low, high = min(low, s2), max(high, s2)
    return low, high


@inlined
def _snap(d: float, limit: float) -> float:
    return 0.0 if -limit <= d <= limit else d


@bare
def triangles_cross(p: Array, q: Array, tolerance: float) -> bool:
    """Whether triangles ``p`` and ``q``, each (3, 3) rows of corners, pass through each other."""
    # signed distances of p's corners to q's plane, times |n|
    ax, ay, az = q[1, 0] - q[0, 0], q[1, 1] - q[0, 1], q[1, 2] - q[0, 2]
    bx, by, bz = q[2, 0] - q[0, 0], q[2, 1] - q[0, 1], q[2, 2] - q[0, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    limit = tolerance * np.sqrt(nx * nx + ny * ny + nz * nz)
    d0 = _snap(nx * (p[0, 0] - q[0, 0]) + ny * (p[0, 1] - q[0, 1]) + nz * (p[0, 2] - q[0, 2]), limit)
    d1 = _snap(nx * (p[1, 0] - q[0, 0]) + ny * (p[1, 1] - q[0, 1]) + nz * (p[1, 2] - q[0, 2]), limit)
    d2 = _snap(nx * (p[2, 0] - q[0, 0]) + ny * (p[2, 1] - q[0, 1]) + nz * (p[2, 2] - q[0, 2]), limit)
    if (d0 >= 0.0 and d1 >= 0.0 and d2 >= 0.0) or (d0 <= 0.0 and d1 <= 0.0 and d2 <= 0.0):
        return False
    # and of q's corners to p's plane
    ax, ay, az = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    bx, by, bz = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    mx, my, mz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    limit = tolerance * np.sqrt(mx * mx + my * my + mz * mz)
    e0 = _snap(mx * (q[0, 0] - p[0, 0]) + my * (q[0, 1] - p[0, 1]) + mz * (q[0, 2] - p[0, 2]), limit)
    e1 = _snap(mx * (q[1, 0] - p[0, 0]) + my * (q[1, 1] - p[0, 1]) + mz * (q[1, 2] - p[0, 2]), limit)
    e2 = _snap(mx * (q[2, 0] - p[0, 0]) + my * (q[2, 1] - p[0, 1]) + mz * (q[2, 2] - p[0, 2]), limit)
    if (e0 >= 0.0 and e1 >= 0.0 and e2 >= 0.0) or (e0 <= 0.0 and e1 <= 0.0 and e2 <= 0.0):
        return False
    # both reach through: compare where they meet the common line of the planes
    ux, uy, uz = my * nz - mz * ny, mz * nx - mx * nz, mx * ny - my * nx
    size = np.sqrt(ux * ux + uy * uy + uz * uz)
    if size == 0.0:
        return False
    ux, uy, uz = ux / size, uy / size, uz / size
    p_low, p_high = _plane_interval(p, d0, d1, d2, ux, uy, uz)
    q_low, q_high = _plane_interval(q, e0, e1, e2, ux, uy, uz)
    return min(p_high, q_high) - max(p_low, q_low) > tolerance
