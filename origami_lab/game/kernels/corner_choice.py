"""Where the corners of a start pattern lie, and which of them may be chosen.

A start pattern is a convex panel, counter-clockwise, or a single crease, a polygon with two corners: the panel on the
left of the way from the first to the second stays in the plane. It is mapped to itself by the symmetry.

**Picks.** A rectangle or a crease may be chosen by its corners. Of each the agent names the playable image: first the
lower left corner of the rectangle or one end of the crease, then the opposite one, unless the symmetry says where that
is; the sign comes last. So that no pattern is chosen twice, the second end lies to the right of the first, or above it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import CREASE, PANEL, RECTANGLE, SQUARE, Record, board_points, point_index
from origami_lab.jit import bare

Ints = NDArray[np.int32]
Corners = NDArray[np.int32]
"""(LARGEST_PANEL, 2) board points; a pattern uses the first rows."""


@bare
def picked_box(r: Record, px: int, py: int, qx: int, qy: int) -> tuple[int, int, int, int]:
    """Lower left and upper right corner (x, y, x, y) of the rectangle that two picks name.

    Mirrored in x, the picks are its left corners; in y, its upper ones; in both, the first is the upper left one and
    the second plays no part.
    """
    left, right = px, -px if r.flips_x else qx
    low, high = (-py, py) if r.flips_y else (py, qy)
    return left, low, right, high


@bare
def picked_ends(r: Record, px: int, py: int, qx: int, qy: int) -> tuple[int, int, int, int]:
    """The ends (x, y, x, y) of the crease that two picks name, the left or lower one first."""
    if r.flips_x:
        return px, py, -px, py
    if r.flips_y:
        return px, -py, px, py
    return px, py, qx, qy


@bare
def start_corners(s: Record, r: Record, option: int, out: Corners) -> int:
    """Write the corners of the start pattern that an option, or the picks of a state, name; returns their number."""
    if r.start == PANEL:
        for i in range(r.n_corners):
            out[i, 0], out[i, 1] = r.corners[i, 0], r.corners[i, 1]
        return int(r.n_corners)
    value = r.first_placement + option
    x0, y0, x1, y1 = -1, value, 1, value
    if r.start == SQUARE:
        x0, y0, x1, y1 = r.centre[0] - value, r.centre[1] - value, r.centre[0] + value, r.centre[1] + value
    elif r.start == RECTANGLE:
        x0, y0, x1, y1 = picked_box(r, s.first_x, s.first_y, s.second_x, s.second_y)
    elif r.start != CREASE:
        x0, y0, x1, y1 = picked_ends(r, s.first_x, s.first_y, s.second_x, s.second_y)
    if r.start == SQUARE or r.start == RECTANGLE:
        out[0, 0], out[0, 1], out[1, 0], out[1, 1] = x1, y1, x0, y1
        out[2, 0], out[2, 1], out[3, 0], out[3, 1] = x0, y0, x1, y0
        return 4
    if r.stays_below:
        x0, y0, x1, y1 = x1, y1, x0, y0
    out[0, 0], out[0, 1], out[1, 0], out[1, 1] = x0, y0, x1, y1
    return 2


@bare
def is_inside(r: Record, x: int, y: int) -> bool:
    """Whether a point is on the board, but not on its edge, where nothing can be extended."""
    return abs(x) < r.half_x and abs(y) < r.half_y


@bare
def picks_fit(r: Record, px: int, py: int, qx: int, qy: int) -> bool:
    """Whether two picks name a start pattern of the rules."""
    if r.start == RECTANGLE:
        if r.is_pinned and (px != r.pin[0] or py != r.pin[1]):
            return False
        if (r.flips_x and qx != px) or (r.flips_y and qy != py):
            return False
        x0, y0, x1, y1 = picked_box(r, px, py, qx, qy)
        width, height = x1 - x0, y1 - y0
        if width < r.least[0] or width > r.most[0] or height < r.least[1] or height > r.most[1]:
            return False
        return (not r.is_square or width == height) and is_inside(r, x0, y0) and is_inside(r, x1, y1)
    x0, y0, x1, y1 = picked_ends(r, px, py, qx, qy)
    if r.picks == 1 and (qx != px or qy != py):
        return False
    return (x1 > x0 or (x1 == x0 and y1 > y0)) and is_inside(r, x0, y0) and is_inside(r, x1, y1)


@bare
def pick_is_legal(s: Record, r: Record, x: int, y: int) -> bool:
    """Whether a place may be the next pick of a state."""
    if s.unfinished > 0:
        return picks_fit(r, s.first_x, s.first_y, x, y)
    if r.picks == 1:
        return picks_fit(r, x, y, x, y)
    # a second pick that fits lies above or to the right; nearly always the next point does
    for qy in range(y, r.half_y):
        for qx in range(x, r.half_x):
            if picks_fit(r, x, y, qx, qy):
                return True
    if r.start == RECTANGLE:
        return False
    for qy in range(-r.half_y + 1, y):
        for qx in range(x + 1, r.half_x):
            if picks_fit(r, x, y, qx, qy):
                return True
    return False


@bare
def write_picks(s: Record, r: Record, out: Ints) -> int:
    """Write the location actions that are legal picks of a state; returns their number."""
    base, n = 2 * board_points(r), 0
    # the edge is never legal, and under a mirror the other half is not: picks_fit says so
    for y in range(-r.half_y + 1, r.half_y):
        for x in range(-r.half_x + 1, r.half_x):
            if pick_is_legal(s, r, x, y):
                out[n] = base + point_index(r, x, y)
                n += 1
    return n
