"""What the outer children of a leaf, once chosen, leave to its middle child."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origami_lab.game.kernels.state import FIRST, SECOND, Record
from origami_lab.game.kernels.straight_sectors import plane_side, starts_flat
from origami_lab.geometry.planar import cross
from origami_lab.jit import inlined
from origami_lab.kinematics.three_units import lift


class Middle(NamedTuple):
    """What the outer children of the selected leaf, once chosen, leave to its middle child.

    Attributes
    ----------
    a_length, b_length
        Lengths of the outer creases, in board cells.
    p_sq, m_sq
        |A + B|² and |A − B|² of their directions at the smallest driving angle.
    opens
        Whether the chosen mode's motion begins at the flat sheet.
    flat
        Whether it stays flat, in a plane with the panels beside it: there is a sector of π.
    """

    a_length: float
    b_length: float
    p_sq: float
    m_sq: float
    opens: bool
    flat: bool


@inlined
def middle_of(s: Record, r: Record) -> Middle:
    """The terms of the middle child, of no meaning before both outer children are chosen."""
    if s.phase == FIRST or s.phase == SECOND:
        return Middle(0.0, 0.0, 0.0, 0.0, True, False)
    v = s.selected
    x, y = s.xy[v, 0], s.xy[v, 1]
    ax, ay, bx, by = s.first_x - x, s.first_y - y, s.second_x - x, s.second_y - y
    a_length, b_length = np.sqrt(float(ax * ax + ay * ay)), np.sqrt(float(bx * bx + by * by))
    A = lift(s.frame_prev[v], 0, ax / a_length, ay / a_length)
    B = lift(s.frame_next[v], 0, bx / b_length, by / b_length)
    p_sq = (A[0] + B[0]) ** 2 + (A[1] + B[1]) ** 2 + (A[2] + B[2]) ** 2
    m_sq = (A[0] - B[0]) ** 2 + (A[1] - B[1]) ** 2 + (A[2] - B[2]) ** 2
    flat = plane_side(s, r) >= 0
    return Middle(a_length, b_length, p_sq, m_sq, cross(ax, ay, bx, by) != 0 or starts_flat(s, A, B), flat)
