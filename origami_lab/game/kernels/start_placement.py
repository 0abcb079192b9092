"""Start patterns: driven creases (*sources*) laid on the boundary of a flat sheet.

A source is a driven crease on a boundary segment; the flap outside it starts with no area. A panel start is a convex
panel with sources on its sides, or some of them; a single crease is a two-gon with one. The same operation later in the
game, on the segment between a leaf and its mirror image, is the paper's source action (section 3.3).
"""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.collisions import sweep_triangle
from origami_lab.game.kernels.corner_choice import start_corners
from origami_lab.game.kernels.state import (
    BARE,
    LARGEST_PANEL,
    PANEL,
    SELECTION,
    SINGLE,
    Record,
    add_crease,
    add_triangle,
    add_vertex,
    code_x,
    code_y,
    is_playable,
)
from origami_lab.jit import bare, kernel
from origami_lab.kinematics.three_units import hinge, mirror_frames


@bare
def lay_source(s: Record, r: Record, v: int, over_next: int, sign: int) -> None:
    """Lay a driven crease on the boundary segment beside leaf v, as far as v is concerned.

    The caller does the same for the segment's other end, unless that is v's image. Panel orientation
    beyond the segment from p to n: R·Rot(u_{p→n}, −ρ).
    """
    other = s.next[v] if over_next else s.prev[v]
    dx, dy = code_x(s, r, other) - s.xy[v, 0], code_y(s, r, other) - s.xy[v, 1]
    length = np.sqrt(float(dx * dx + dy * dy))
    ux, uy = dx / length, dy / length
    if not over_next:
        ux, uy = -ux, -uy
    for k in range(s.reach):
        if over_next:
            hinge(s.frame_next[v], s.frame_next[v], k, ux, uy, -sign * r.angles[k])
        else:
            hinge(s.frame_prev[v], s.frame_prev[v], k, ux, uy, -sign * r.angles[k])
    if over_next:
        s.first[v] = other
    else:
        s.last[v] = other


@bare
def set_flat(s: Record, v: int) -> None:
    """Position and panels of a vertex of the flat start panel."""
    for k in range(s.reach):
        s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2] = s.xy[v, 0], s.xy[v, 1], 0.0
        for j in range(6):
            s.frame_prev[v, k, j] = 0.0
            s.frame_next[v, k, j] = 0.0
        s.frame_prev[v, k, 0] = s.frame_next[v, k, 0] = 1.0
        s.frame_prev[v, k, 4] = s.frame_next[v, k, 4] = 1.0


@bare
def side_sign(r: Record, i: int) -> int:
    """Sign of the i-th side of the start pattern, as against the sign that the agent chooses; 0: it is not driven."""
    return int(r.sides[i]) if r.start == PANEL else 1


@kernel
def place_start(s: Record, r: Record, option: int, sign: int) -> None:
    """Lay down the start pattern; ``option`` chooses the square's half-width or the crease's height."""
    # corners counter-clockwise; a single crease is a polygon with two corners
    corners = np.empty((LARGEST_PANEL, 2), np.int32)
    n = start_corners(s, r, option, corners)
    codes = np.empty(LARGEST_PANEL, np.int32)
    for i in range(n):
        x, y = corners[i, 0], corners[i, 1]
        codes[i] = -1
        for v in range(s.n_vertices):
            for g in range(r.order):
                if codes[i] < 0 and code_x(s, r, 8 * v + g) == x and code_y(s, r, 8 * v + g) == y:
                    codes[i] = 8 * v + g
        if codes[i] < 0:
            # the playable image represents the orbit
            for g in range(r.order):
                gx = r.matrices[g, 0] * x + r.matrices[g, 1] * y
                gy = r.matrices[g, 2] * x + r.matrices[g, 3] * y
                if codes[i] < 0 and is_playable(r, gx, gy):
                    v = add_vertex(s, r, gx, gy)
                    codes[i] = 8 * v + r.inverses[g]
    for i in range(n):
        if codes[i] & 7 == 0:
            v = codes[i] >> 3
            s.prev[v], s.next[v] = codes[(i + n - 1) % n], codes[(i + 1) % n]
            s.first[v], s.last[v] = s.next[v], s.prev[v]
            set_flat(s, v)
            if s.head < 0 or s.prev[v] & 7 != 0:
                s.head = v
    for i in range(n):
        if codes[i] & 7 == 0:
            v = codes[i] >> 3
            if n > 2:
                lay_sides(s, r, v, sign * side_sign(r, (i + n - 1) % n), sign * side_sign(r, i))
            else:
                # the panel on the left, outside the segment back, stays flat
                if codes[i] == codes[0]:
                    lay_source(s, r, v, 1, sign)
                else:
                    lay_source(s, r, v, 0, sign)
                s.first[v] = s.last[v] = s.next[v]
    for i in range(n if n > 2 else 1):
        if n == 2 or side_sign(r, i) != 0:
            add_crease(s, codes[i], codes[(i + 1) % n], sign * (side_sign(r, i) if n > 2 else 1))
    for i in range(n - 2):
        add_triangle(s, r, codes[0], codes[i + 1], codes[i + 2], SINGLE)
        sweep_triangle(s, r, i, s.reach)
    s.phase = SELECTION
    s.unfinished = 0


@bare
def lay_sides(s: Record, r: Record, v: int, before: int, after: int) -> None:
    """Lay the driven creases on the two sides of a panel that meet at v, 0 for one that is not driven."""
    if s.axis[v] > 0:
        # exact symmetry: only one side is computed, the other is its mirror image
        if after != 0:
            m = r.matrices[s.axis[v]]
            lay_source(s, r, v, 1, after)
            for k in range(s.reach):
                mirror_frames(s.frame_prev[v], s.frame_next[v], k, m[0], m[1], m[2], m[3])
    else:
        if after != 0:
            lay_source(s, r, v, 1, after)
        if before != 0:
            lay_source(s, r, v, 0, before)
    if before == 0 and after == 0:
        s.locked[v] = BARE
        s.first[v], s.last[v] = s.prev[v], s.next[v]  # no crease lies along a side
    elif before == 0:
        s.last[v] = s.next[v]
    elif after == 0:
        s.first[v] = s.prev[v]
