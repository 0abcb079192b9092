"""Driven creases laid during the game on boundary segments that have none (paper, section 3.3).

Segments between a leaf and its mirror image have actions of their own. For any other one the sign is chosen first, then
the leaf before the segment, counter-clockwise. Between the two actions the state is placing, with a sheet on the board.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV, is_own_image
from origami_lab.game.kernels.limits import is_blunt_enough, is_long_enough
from origami_lab.game.kernels.start_placement import lay_source
from origami_lab.game.kernels.state import (
    BARE,
    ON_BOUNDARY,
    SELECTION,
    Record,
    add_crease,
    board_points,
    code_x,
    code_y,
    image_code,
    point_index,
)
from origami_lab.game.kernels.straight_sectors import close_sector, lock_beside, lock_of
from origami_lab.jit import bare, inlined
from origami_lab.kinematics.three_units import mirror_frames

Actions = NDArray[np.int32]


@bare
def boundary_action(r: Record) -> int:
    """The action that begins a boundary source with a negative sign; the next one is that with a positive sign."""
    return 3 * board_points(r) + 5 + 2 * r.n_placements


@inlined
def meets_bluntly(s: Record, r: Record, v: int, side: int) -> bool:
    """Whether a crease along leaf v's boundary segment on one side is far enough from the next crease into v."""
    if r.max_cosine > 1.0 or s.locked[v] == BARE:
        return True
    code, crease = (s.prev[v], s.last[v]) if side == PREV else (s.next[v], s.first[v])
    x, y = s.xy[v, 0], s.xy[v, 1]
    ax, ay = code_x(s, r, code) - x, code_y(s, r, code) - y
    return is_blunt_enough(r, ax, ay, code_x(s, r, crease) - x, code_y(s, r, crease) - y)


@inlined
def source_fits(s: Record, r: Record, v: int, side: int) -> bool:
    """Whether a source may be laid between leaf v and its mirror image on that side."""
    code, crease = (s.prev[v], s.last[v]) if side == PREV else (s.next[v], s.first[v])
    if not is_own_image(s, r, v, code) or s.axis[v] != 0 or same_place(s, r, crease, code):
        return False
    dx, dy = code_x(s, r, code) - s.xy[v, 0], code_y(s, r, code) - s.xy[v, 1]
    return is_long_enough(r, dx, dy) and meets_bluntly(s, r, v, side)


@inlined
def same_place(s: Record, r: Record, a: int, b: int) -> bool:
    return code_x(s, r, a) == code_x(s, r, b) and code_y(s, r, a) == code_y(s, r, b)


@bare
def segment_is_free(s: Record, r: Record, v: int) -> bool:
    """Whether a boundary source may lie between leaf v and the next one: inside the domain, and without a crease."""
    code = s.next[v]
    if code & 7 != 0:
        return False
    if code_x(s, r, s.first[v]) == code_x(s, r, code) and code_y(s, r, s.first[v]) == code_y(s, r, code):
        return False
    if not is_long_enough(r, code_x(s, r, code) - s.xy[v, 0], code_y(s, r, code) - s.xy[v, 1]):
        return False
    return meets_bluntly(s, r, v, NEXT) and meets_bluntly(s, r, code >> 3, PREV)


@bare
def count_free_segments(s: Record, r: Record) -> int:
    """How many segments boundary sources may lie on."""
    if r.sources != ON_BOUNDARY:
        return 0
    count, v = 0, s.head
    while True:
        count += segment_is_free(s, r, v)
        code = s.next[v]
        if code & 7 != 0 or code >> 3 == s.head:
            return count
        v = code >> 3


@bare
def free_segment(s: Record, r: Record, number: int) -> int:
    """The leaf before the free segment of that number, from the first leaf on."""
    v = s.head
    while True:
        if segment_is_free(s, r, v):
            if number == 0:
                return int(v)
            number -= 1
        v = s.next[v] >> 3


@bare
def write_free_segments(s: Record, r: Record, out: Actions) -> int:
    """Write the location actions that name free segments; returns their number."""
    base, n, v = 2 * board_points(r), 0, s.head
    while True:
        if segment_is_free(s, r, v):
            out[n] = base + point_index(r, s.xy[v, 0], s.xy[v, 1])
            n += 1
        code = s.next[v]
        if code & 7 != 0 or code >> 3 == s.head:
            return n
        v = code >> 3


@bare
def lay_boundary_source(s: Record, r: Record, v: int, sign: int) -> None:
    """Lay a driven crease between leaf v and the next one, and complete the move."""
    w = s.next[v] >> 3
    for end, over_next in ((v, 1), (w, 0)):
        was_bare = s.locked[end] == BARE
        if not was_bare:
            close_sector(s, end, lock_beside(s, r, end, NEXT if over_next else PREV))
        lay_source(s, r, end, over_next, sign)
        if was_bare:
            s.locked[end] = 0
            if over_next:
                s.last[end] = s.first[end]
            else:
                s.first[end] = s.last[end]
        g = s.axis[end]
        if g > 0:
            # the image of the segment begins at the same leaf
            m = r.matrices[g]
            for k in range(s.reach):
                if over_next:
                    mirror_frames(s.frame_prev[end], s.frame_next[end], k, m[0], m[1], m[2], m[3])
                else:
                    mirror_frames(s.frame_next[end], s.frame_prev[end], k, m[0], m[1], m[2], m[3])
            if over_next:
                s.last[end] = image_code(r, g, s.first[end])
            else:
                s.first[end] = image_code(r, g, s.last[end])
            if was_bare:
                close_sector(s, end, lock_of(s, r, end, s.first[end], s.last[end]))
    add_crease(s, 8 * v, 8 * w, sign)
    s.phase = SELECTION
    s.unfinished = 0
