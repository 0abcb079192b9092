"""Squared distances from a point to a triangle, a segment and a box: scalars in, scalars out.

Everything here is called millions of times from compiled loops, so nothing allocates. Lengths are in board
units. The distance between surfaces built on these is the paper's section 4, Hausdorff distance.
"""

from __future__ import annotations

from origami_lab.jit import inlined

# A triangle whose first corner's angle has a sine below 1e-8 is treated as its three sides: its normal would
# be rounding noise, and every point of it is within 1e-8 of its size from them anyway.
SLIVER_SQUARED = 1e-16


@inlined
def point_segment_squared(px: float, py: float, pz: float, ux: float, uy: float, uz: float) -> float:
    """Squared distance from ``p`` to the segment from the origin to ``u`` (``u`` = 0: to the origin).

    Parameters
    ----------
    px, py, pz
        The point, relative to the start of the segment.
    ux, uy, uz
        The end of the segment, relative to its start.
    """
    length_squared = ux * ux + uy * uy + uz * uz
    along = px * ux + py * uy + pz * uz
    if along > 0.0:  # hence length_squared > 0
        t = 1.0 if along >= length_squared else along / length_squared
        px -= t * ux
        py -= t * uy
        pz -= t * uz
    return px * px + py * py + pz * pz


@inlined
def point_triangle_squared(
    px: float,
    py: float,
    pz: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
) -> float:
    """Squared distance from the point ``p`` to the filled triangle ``abc``, exact up to rounding.

    The signed areas under the projection of ``p`` say which sides it lies beyond. Beyond none, the distance
    is that to the plane; otherwise the closest point is on one of the sides it lies beyond (one or two), and
    only those are measured. Triangles that are segments or points work too.
    """
    bx -= ax
    by -= ay
    bz -= az
    cx -= ax
    cy -= ay
    cz -= az
    px -= ax
    py -= ay
    pz -= az
    nx = by * cz - bz * cy
    ny = bz * cx - bx * cz
    nz = bx * cy - by * cx
    n_squared = nx * nx + ny * ny + nz * nz
    b_squared = bx * bx + by * by + bz * bz
    c_squared = cx * cx + cy * cy + cz * cz
    return point_edges_squared(px, py, pz, bx, by, bz, cx, cy, cz, nx, ny, nz, n_squared, b_squared, c_squared)


@inlined
def point_edges_squared(
    px: float,
    py: float,
    pz: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
    nx: float,
    ny: float,
    nz: float,
    n_squared: float,
    b_squared: float,
    c_squared: float,
) -> float:
    """:func:`point_triangle_squared` for a = 0, with n = b×c and the squared lengths of n, b and c."""
    if n_squared > SLIVER_SQUARED * b_squared * c_squared:
        # weights of c and b in the projection of p, times |n|²
        weight_c = nx * (by * pz - bz * py) + ny * (bz * px - bx * pz) + nz * (bx * py - by * px)
        weight_b = nx * (py * cz - pz * cy) + ny * (pz * cx - px * cz) + nz * (px * cy - py * cx)
        weight_a = n_squared - weight_b - weight_c
        if weight_a >= 0.0 and weight_b >= 0.0 and weight_c >= 0.0:
            height = nx * px + ny * py + nz * pz
            return height * height / n_squared
    else:
        weight_a = -1.0
        weight_b = -1.0
        weight_c = -1.0
    best = 1e300
    if weight_c < 0.0:
        best = point_segment_squared(px, py, pz, bx, by, bz)
    if weight_b < 0.0:
        best = min(best, point_segment_squared(px, py, pz, cx, cy, cz))
    if weight_a < 0.0:
        best = min(best, point_segment_squared(px - bx, py - by, pz - bz, cx - bx, cy - by, cz - bz))
    return best


@inlined
def point_box_squared(
    px: float,
    py: float,
    pz: float,
    x0: float,
    y0: float,
    z0: float,
    x1: float,
    y1: float,
    z1: float,
) -> float:
    """Squared distance from ``p`` to the closed box ``[x0, x1] × [y0, y1] × [z0, z1]``; 0 inside."""
    dx = max(x0 - px, 0.0, px - x1)
    dy = max(y0 - py, 0.0, py - y1)
    dz = max(z0 - pz, 0.0, pz - z1)
    return dx * dx + dy * dy + dz * dz
