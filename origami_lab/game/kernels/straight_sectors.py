"""Sectors of exactly π: at such a vertex the sheet folds along one straight line, or not at all.

The sectors of a vertex add up to 2π. If one of them is π, the two creases beside it point in opposite directions,
folded or not, and the others add up to π: on the unit sphere they are a path of length π between two opposite points,
so half a great circle. All creases but those two stay flat, and those two fold alike. That is a condition on the
creases that come into a leaf, and leaves its new ones nothing to choose: they are a closed case of their own, without
the spherical triangle (:mod:`origami_lab.kinematics.three_units`), whose sides are then a straight line.

Whether a sector is π is asked of whole numbers. Whether the creases into a leaf fold so is asked of the panels beside
it, at every driving angle that the motion reaches.
"""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.boundary import NEXT, PREV, near_side
from origami_lab.game.kernels.state import CLOSED, STRAIGHT, Record, code_x, code_y
from origami_lab.geometry.planar import cross
from origami_lab.jit import bare, inlined
from origami_lab.kinematics.three_units import lift

AGREES = 1e-20
"""Square of the distance within which two unit directions in space are one."""


@inlined
def opposite(ax: int, ay: int, bx: int, by: int) -> bool:
    """Whether two directions of the board are opposite, exactly."""
    return cross(ax, ay, bx, by) == 0 and ax * bx + ay * by < 0


@inlined
def lock_of(s: Record, r: Record, w: int, a: int, b: int) -> int:
    """What the sector at w from the coded vertex a counter-clockwise to b, of incoming creases, means for ``locked``.

    0 below π; at π :data:`~.state.STRAIGHT` if the rules know such sectors; else :data:`~.state.CLOSED`.
    """
    x, y = s.xy[w, 0], s.xy[w, 1]
    ax, ay, bx, by = code_x(s, r, a) - x, code_y(s, r, a) - y, code_x(s, r, b) - x, code_y(s, r, b) - y
    if cross(ax, ay, bx, by) > 0:
        return 0
    return STRAIGHT if r.straight_sectors and opposite(ax, ay, bx, by) else CLOSED


@inlined
def lock_beside(s: Record, r: Record, w: int, side: int) -> int:
    """What a crease along w's boundary segment on that side means for ``locked``."""
    if side == PREV:
        return lock_of(s, r, w, s.last[w], s.prev[w])
    return lock_of(s, r, w, s.next[w], s.first[w])


@inlined
def close_sector(s: Record, w: int, lock: int) -> None:
    """Enter what one more incoming sector means for a leaf: it has one of π or more at most."""
    if lock != 0:
        s.locked[w] = lock


@inlined
def agree_on(s: Record, v: int, dx: int, dy: int) -> bool:
    """Whether the panels on both sides of leaf v point a direction of the board the same way in space."""
    length = np.sqrt(float(dx * dx + dy * dy))
    for k in range(s.reach):
        a = lift(s.frame_prev[v], k, dx / length, dy / length)
        b = lift(s.frame_next[v], k, dx / length, dy / length)
        if not (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2 <= AGREES:
            return False
    return True


@inlined
def is_closed(s: Record, r: Record, v: int) -> bool:
    """Whether nothing new can fold at a leaf, whatever is played: an incoming sector of π or more, as the rules say."""
    return s.locked[v] == CLOSED or (s.locked[v] == STRAIGHT and r.straight_sectors == 0)


@bare
def leaf_folds_straight(s: Record, v: int) -> bool:
    """Whether a leaf with an incoming sector of π folds along its line: the panels on both sides are in one plane."""
    return agree_on(s, v, 1, 0) and agree_on(s, v, 0, 1)


@bare
def goes_straight_on(s: Record, r: Record, v: int, side: int) -> bool:
    """Whether the outer crease of leaf v on that side may go straight on, to the outer child: then the others are flat.

    They are if the plane beyond them has the crease where it is.
    """
    if not r.straight_sectors:
        return False
    if s.first[v] == s.last[v]:
        return True
    crease = s.last[v] if side == PREV else s.first[v]
    return agree_on(s, v, code_x(s, r, crease) - s.xy[v, 0], code_y(s, r, crease) - s.xy[v, 1])


@bare
def side_is_open(s: Record, r: Record, v: int, side: int) -> bool:
    """Whether a crease can leave v on that side: less than π between the last crease there and the boundary.

    Or π, if a crease along the boundary would go straight on.
    """
    x, y = s.xy[v, 0], s.xy[v, 1]
    if side == PREV:
        neighbour, crease = s.prev[v], s.last[v]
    else:
        neighbour, crease = s.next[v], s.first[v]
    nx, ny = code_x(s, r, neighbour) - x, code_y(s, r, neighbour) - y
    cx, cy = code_x(s, r, crease) - x, code_y(s, r, crease) - y
    sine = cross(cx, cy, nx, ny) if side == PREV else cross(nx, ny, cx, cy)
    return sine > 0 or (sine == 0 and (nx * cx + ny * cy > 0 or goes_straight_on(s, r, v, side)))


@inlined
def plane_side(s: Record, r: Record) -> int:
    """The side whose panel the new panels of the selected leaf continue, its outer children being chosen.

    −1 if all its sectors are below π: then they fold.
    """
    v = s.selected
    if s.locked[v] == STRAIGHT:
        return NEXT if s.axis[v] > 0 and near_side(s, r, v) == NEXT else PREV
    x, y = s.xy[v, 0], s.xy[v, 1]
    if opposite(code_x(s, r, s.last[v]) - x, code_y(s, r, s.last[v]) - y, s.first_x - x, s.first_y - y):
        return NEXT
    if opposite(code_x(s, r, s.first[v]) - x, code_y(s, r, s.first[v]) - y, s.second_x - x, s.second_y - y):
        return PREV
    return -1


@inlined
def starts_flat(s: Record, A: tuple[float, float, float], B: tuple[float, float, float]) -> bool:
    """Whether the chosen mode's motion begins at the flat sheet, for a and b in opposite directions.

    Then U1 = π in the flat state, and only one mode has its middle crease where the flat sheet has it; the other's lies
    folded back by 180°. The line a–b bends up or down, and the middle crease must bend the same way. In every other
    case both modes begin flat.
    """
    v = s.selected
    ux, uy, uz = lift(s.frame_prev[v], 0, 1.0, 0.0)
    wx, wy, wz = lift(s.frame_prev[v], 0, 0.0, 1.0)
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    return s.mode * ((A[0] + B[0]) * nx + (A[1] + B[1]) * ny + (A[2] + B[2]) * nz) > 0.0
