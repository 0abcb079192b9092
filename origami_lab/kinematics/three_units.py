"""The principle of three units (PTU; paper, section 3.2) in vector form.

A vertex has known incoming creases and three outgoing ones, a, c, b in counter-clockwise order. Folded, the
outer two point along the unit vectors A and B: their directions are fixed by the panels on either side. The
middle one, C, closes the vertex: it stands at the sector angles U2 = ∠(a, c) from A and U3 = ∠(c, b) from B.
With the unit angle U1 = ∠(A, B), the three are the sides of a spherical triangle, and C is its third corner.

On the orthogonal axes p = A + B, m = A − B, n = A × B,

    C = α p + β m − M γ n,    α = (cos U2 + cos U3)/|p|²,   β = (cos U2 − cos U3)/|m|²,
    γ² = (1 − α²|p|² − β²|m|²)/|n|²,

which is the paper's solution by spherical cosines (angles U, θ, δ, β, φ of Luca et al.) without their arc
cosines: γ² ≥ 0 *is* the triangle inequality U_max ≤ U_min + U_med, and the rigid body mode M = +1 is the branch on
which the middle crease is a valley, since its fold angle has the sign of −C·n.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import inlined

Frames = NDArray[np.float64]
"""(K, 6) orientation of a panel at each driving angle: the images of the board's x and y directions."""

PARALLEL = 1e-12
"""Below this |p|² or |m|² the outer creases are parallel and the middle one is free to turn about them."""

DEGENERATE = 1e-13
"""Where γ²|n|² is this close to 0 the spherical triangle is a straight line and the middle crease does not fold.

Rounding shall not decide whether such a vertex exists, nor give its middle crease an angle.
"""


@inlined
def triangle_slack(p_sq: float, m_sq: float, cos_u2: float, cos_u3: float) -> float:
    """γ²|n|²: not negative, up to rounding, exactly where the spherical triangle (U1, U2, U3) exists."""
    if p_sq < PARALLEL or m_sq < PARALLEL:
        return -1.0
    both, apart = cos_u2 + cos_u3, cos_u2 - cos_u3
    return 1.0 - both * both / p_sq - apart * apart / m_sq


@inlined
def middle_crease(
    A: tuple[float, float, float], B: tuple[float, float, float], cos_u2: float, cos_u3: float, mode: int
) -> tuple[bool, float, float, float]:
    """Direction C of the middle crease, and whether it exists.

    Parameters
    ----------
    A, B
        Unit directions of the outer creases in space.
    cos_u2, cos_u3
        Cosines of the sector angles a–c and c–b.
    mode
        Rigid body mode M: +1 valley, −1 mountain for the middle crease.
    """
    px, py, pz = A[0] + B[0], A[1] + B[1], A[2] + B[2]
    mx, my, mz = A[0] - B[0], A[1] - B[1], A[2] - B[2]
    p_sq, m_sq = px * px + py * py + pz * pz, mx * mx + my * my + mz * mz
    slack = triangle_slack(p_sq, m_sq, cos_u2, cos_u3)
    if not slack >= -DEGENERATE:
        return False, 0.0, 0.0, 0.0
    nx = A[1] * B[2] - A[2] * B[1]
    ny = A[2] * B[0] - A[0] * B[2]
    nz = A[0] * B[1] - A[1] * B[0]
    alpha = (cos_u2 + cos_u3) / p_sq
    beta = (cos_u2 - cos_u3) / m_sq
    gamma = 0.0
    if slack > DEGENERATE:
        gamma = -mode * np.sqrt(slack / (nx * nx + ny * ny + nz * nz))
    cx = alpha * px + beta * mx + gamma * nx
    cy = alpha * py + beta * my + gamma * ny
    cz = alpha * pz + beta * mz + gamma * nz
    size = np.sqrt(cx * cx + cy * cy + cz * cz)
    return True, cx / size, cy / size, cz / size


@inlined
def lift(frames: Frames, k: int, dx: float, dy: float) -> tuple[float, float, float]:
    """Image in space of the board vector (dx, dy) on a panel, at driving angle k."""
    return (
        frames[k, 0] * dx + frames[k, 3] * dy,
        frames[k, 1] * dx + frames[k, 4] * dy,
        frames[k, 2] * dx + frames[k, 5] * dy,
    )


@inlined
def frame_from_edge(
    out: Frames, k: int, E: tuple[float, float, float], N: tuple[float, float, float], ex: float, ey: float
) -> None:
    """Orientation of the panel whose board direction (ex, ey) (a unit vector) lies along E, with normal N.

    ``N`` need not be a unit vector, but must be orthogonal to the unit vector ``E``.
    """
    size = np.sqrt(N[0] * N[0] + N[1] * N[1] + N[2] * N[2])
    nx, ny, nz = N[0] / size, N[1] / size, N[2] / size
    # image of the board direction a quarter turn counter-clockwise of (ex, ey)
    px, py, pz = ny * E[2] - nz * E[1], nz * E[0] - nx * E[2], nx * E[1] - ny * E[0]
    out[k, 0], out[k, 1], out[k, 2] = ex * E[0] - ey * px, ex * E[1] - ey * py, ex * E[2] - ey * pz
    out[k, 3], out[k, 4], out[k, 5] = ey * E[0] + ex * px, ey * E[1] + ex * py, ey * E[2] + ex * pz


@inlined
def hinge(out: Frames, frames: Frames, k: int, ux: float, uy: float, angle: float) -> None:
    """Orientation R·Rot(u, angle) of the panel across a crease along the board's unit direction u."""
    ax, ay, az = frames[k, 0], frames[k, 1], frames[k, 2]
    bx, by, bz = frames[k, 3], frames[k, 4], frames[k, 5]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    c, s = np.cos(angle), np.sin(angle)
    xx, xy, yy = ux * ux + c * (1.0 - ux * ux), ux * uy * (1.0 - c), uy * uy + c * (1.0 - uy * uy)
    out[k, 0], out[k, 1], out[k, 2] = (
        ax * xx + bx * xy - nx * (s * uy),
        ay * xx + by * xy - ny * (s * uy),
        az * xx + bz * xy - nz * (s * uy),
    )
    out[k, 3], out[k, 4], out[k, 5] = (
        ax * xy + bx * yy + nx * (s * ux),
        ay * xy + by * yy + ny * (s * ux),
        az * xy + bz * yy + nz * (s * ux),
    )


@inlined
def mirror_frames(out: Frames, frames: Frames, k: int, a: int, b: int, c: int, d: int) -> None:
    """Orientation G·R·Gᵀ of the image of a panel under the board symmetry G = [[a, b], [c, d]].

    Entries are 0 or ±1, so the image is exact.
    """
    x0, y0 = frames[k, 0] * a + frames[k, 3] * b, frames[k, 1] * a + frames[k, 4] * b
    z0 = frames[k, 2] * a + frames[k, 5] * b
    x1, y1 = frames[k, 0] * c + frames[k, 3] * d, frames[k, 1] * c + frames[k, 4] * d
    z1 = frames[k, 2] * c + frames[k, 5] * d
    out[k, 0], out[k, 1], out[k, 2] = a * x0 + b * y0, c * x0 + d * y0, z0
    out[k, 3], out[k, 4], out[k, 5] = a * x1 + b * y1, c * x1 + d * y1, z1
