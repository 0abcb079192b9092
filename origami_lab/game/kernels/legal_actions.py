"""Which actions are legal (paper, section 3.4): rules 1–4 and the limits on creases and panels, exactly.

A leaf v is extended by children a (next to its ``prev`` neighbour), c (middle) and b (next to its ``next``
neighbour). The new triangles (v, prev, a), (v, a, c), (v, c, b), (v, b, next) must be free of the rest of the sheet, so
that its boundary stays a simple polygon. Under a symmetry it is enough to look at the fundamental domain: triangles
of a playable leaf stay inside it, save those over a seam, where prev or next is the leaf's own mirror image; there
the free region is the symmetric quadrilateral.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV, is_own_image, mirror_between, near_side
from origami_lab.game.kernels.boundary_sources import (
    boundary_action,
    count_free_segments,
    meets_bluntly,
    source_fits,
    write_free_segments,
)
from origami_lab.game.kernels.corner_choice import write_picks
from origami_lab.game.kernels.limits import is_blunt_enough, is_long_enough, is_wide_enough
from origami_lab.game.kernels.state import (
    FIRST,
    ON_BOUNDARY,
    PLACEMENT,
    RUNNING,
    SECOND,
    SELECTION,
    STRAIGHT,
    Record,
    axis_of,
    board_points,
    code_x,
    code_y,
    is_playable,
    point_index,
)
from origami_lab.game.kernels.straight_sectors import (
    goes_straight_on,
    leaf_folds_straight,
    opposite,
    plane_side,
    side_is_open,
    starts_flat,
)
from origami_lab.geometry.planar import cross, in_sector, segments_touch, triangle_contains
from origami_lab.jit import bare, inlined
from origami_lab.kinematics.three_units import DEGENERATE, lift, triangle_slack

Edges = NDArray[np.int32]
"""(n, 4) boundary segments near the selected leaf: x, y of their two ends, in boundary order."""
Actions = NDArray[np.int32]


@bare
def is_selectable(s: Record, r: Record, v: int) -> bool:
    """Whether leaf v can be chosen: inside the board, on one axis at most, no sector that keeps it from folding."""
    x, y = s.xy[v, 0], s.xy[v, 1]
    if abs(x) >= r.half_x or abs(y) >= r.half_y or s.axis[v] < 0:
        return False
    if s.locked[v] != 0 and not (s.locked[v] == STRAIGHT and r.straight_sectors and leaf_folds_straight(s, v)):
        return False
    return side_is_open(s, r, v, PREV) and side_is_open(s, r, v, NEXT)


@bare
def gather_edges(s: Record, r: Record, v: int, edges: Edges) -> int:
    """Boundary segments that do not end at v and come near enough to matter; returns their number."""
    x, y = s.xy[v, 0], s.xy[v, 1]
    limit = 2.0 * max(r.half_x, r.half_y) + 1.0
    if r.max_length_sq < limit * limit:
        limit = np.sqrt(r.max_length_sq)
    low_x, high_x, low_y, high_y = x - limit, x + limit, y - limit, y + limit
    for code in (s.prev[v], s.next[v]):
        cx, cy = code_x(s, r, code), code_y(s, r, code)
        # over a seam the image's child comes into play, too
        margin = limit if is_own_image(s, r, v, code) else 0.0
        low_x, high_x = min(low_x, cx - margin), max(high_x, cx + margin)
        low_y, high_y = min(low_y, cy - margin), max(high_y, cy + margin)
    n = 0
    w = s.head
    wx, wy = s.xy[w, 0], s.xy[w, 1]
    if w != v and is_own_image(s, r, w, s.prev[w]):
        px, py = code_x(s, r, s.prev[w]), code_y(s, r, s.prev[w])
        if min(px, wx) <= high_x and max(px, wx) >= low_x and min(py, wy) <= high_y and max(py, wy) >= low_y:
            edges[n, 0], edges[n, 1], edges[n, 2], edges[n, 3] = px, py, wx, wy
            n += 1
    while True:
        code = s.next[w]
        px, py = wx, wy
        # beyond an axis only the segment that crosses it counts
        if w != v and code != 8 * v and (code & 7 == 0 or code >> 3 == w):
            wx, wy = code_x(s, r, code), code_y(s, r, code)
            if min(px, wx) <= high_x and max(px, wx) >= low_x and min(py, wy) <= high_y and max(py, wy) >= low_y:
                edges[n, 0], edges[n, 1], edges[n, 2], edges[n, 3] = px, py, wx, wy
                n += 1
        if code & 7 != 0 or code >> 3 == s.head:
            return n
        w = code >> 3
        wx, wy = s.xy[w, 0], s.xy[w, 1]


@inlined
def crease_is_free(edges: Edges, n: int, vx: int, vy: int, qx: int, qy: int) -> bool:
    """Whether the segment v–q meets none of the boundary segments."""
    for i in range(n):
        if segments_touch(vx, vy, qx, qy, edges[i, 0], edges[i, 1], edges[i, 2], edges[i, 3]):
            return False
    return True


@inlined
def triangle_is_free(edges: Edges, n: int, ax: int, ay: int, bx: int, by: int, cx: int, cy: int) -> bool:
    """Whether no boundary vertex other than the corners a, b lies in the closed triangle a, b, c."""
    for i in range(n):
        for j in range(0, 4, 2):
            x, y = edges[i, j], edges[i, j + 1]
            if j == 0 and i > 0 and x == edges[i - 1, 2] and y == edges[i - 1, 3]:
                continue
            if (x == ax and y == ay) or (x == bx and y == by):
                continue
            if triangle_contains(ax, ay, bx, by, cx, cy, x, y):
                return False
    return True


@bare
def outer_child_fits(s: Record, r: Record, edges: Edges, n: int, side: int, qx: int, qy: int) -> bool:
    """Whether the child of the selected leaf on one side may lie at q, whatever the others."""
    v = s.selected
    x, y = s.xy[v, 0], s.xy[v, 1]
    dx, dy = qx - x, qy - y
    if float(dx * dx + dy * dy) > r.max_length_sq or not is_long_enough(r, dx, dy):
        return False
    px, py = code_x(s, r, s.prev[v]) - x, code_y(s, r, s.prev[v]) - y
    nx, ny = code_x(s, r, s.next[v]) - x, code_y(s, r, s.next[v]) - y
    if not in_sector(px, py, nx, ny, dx, dy):
        return False
    neighbour = s.prev[v] if side == PREV else s.next[v]
    crease = s.last[v] if side == PREV else s.first[v]
    cx, cy = code_x(s, r, crease) - x, code_y(s, r, crease) - y
    wx, wy = (px, py) if side == PREV else (nx, ny)
    ox, oy = (nx, ny) if side == PREV else (px, py)
    # the sectors between the incoming crease, the boundary and the new crease lie in (0, π), or the new crease goes
    # straight on from the incoming one
    sine = cross(cx, cy, dx, dy) if side == PREV else cross(dx, dy, cx, cy)
    if sine < 0 or (cross(wx, wy, dx, dy) < 0 if side == PREV else cross(dx, dy, wx, wy) < 0):
        return False
    if sine == 0 and not (opposite(cx, cy, dx, dy) and goes_straight_on(s, r, v, side)):
        return False
    if not is_blunt_enough(r, cx, cy, dx, dy):
        return False
    # and room is left for the other two creases
    if cross(ox, oy, dx, dy) == 0 and ox * dx + oy * dy > 0:
        return False
    if dx == wx and dy == wy:
        # a merge: the neighbour becomes the child, unless it is the leaf's own image or already the other child
        if neighbour & 7 != 0:
            return False
        if s.phase == SECOND and s.first_x == qx and s.first_y == qy:
            return False
        return meets_bluntly(s, r, neighbour >> 3, NEXT if side == PREV else PREV)
    axis = axis_of(r, qx, qy)
    own = is_own_image(s, r, v, neighbour)
    if axis < 0 or (axis > 0 and axis == s.axis[v]):
        return False
    if axis > 0 and not (own and on_mirror(s, r, v, neighbour, axis)):
        return False
    mx, my = x + wx, y + wy
    if cross(wx, wy, dx, dy) == 0:
        # on the boundary segment itself, strictly inside it
        return wx * dx + wy * dy > 0 and dx * dx + dy * dy < wx * wx + wy * wy
    if not is_wide_enough(r, x, y, mx, my, qx, qy) or not crease_is_free(edges, n, x, y, qx, qy):
        return False
    if side == PREV:
        free = triangle_is_free(edges, n, x, y, mx, my, qx, qy)
    else:
        free = triangle_is_free(edges, n, mx, my, x, y, qx, qy)
    if free and own and axis == 0:
        # the other half of the symmetric quadrilateral over the seam
        g = mirror_between(s, r, v, neighbour)
        ix = r.matrices[g, 0] * qx + r.matrices[g, 1] * qy
        iy = r.matrices[g, 2] * qx + r.matrices[g, 3] * qy
        if not is_wide_enough(r, mx, my, ix, iy, qx, qy):
            return False
        if side == PREV:
            free = triangle_is_free(edges, n, mx, my, ix, iy, qx, qy)
        else:
            free = triangle_is_free(edges, n, ix, iy, mx, my, qx, qy)
    return free


@inlined
def on_mirror(s: Record, r: Record, v: int, code: int, axis: int) -> bool:
    """Whether the coded neighbour is the image of v across the given axis."""
    return mirror_between(s, r, v, code) == axis


@inlined
def comes_after(s: Record, r: Record, v: int, ax: int, ay: int, bx: int, by: int) -> bool:
    """Whether direction b lies strictly after a on the way round the outside of v, from prev to next."""
    nx, ny = code_x(s, r, s.next[v]) - s.xy[v, 0], code_y(s, r, s.next[v]) - s.xy[v, 1]
    if cross(ax, ay, bx, by) == 0 and ax * bx + ay * by > 0:
        return False
    return in_sector(ax, ay, nx, ny, bx, by)


@bare
def middle_child_fits(s: Record, r: Record, edges: Edges, n: int, qx: int, qy: int) -> bool:
    """Whether the middle child of the selected leaf may lie at q, its outer children being chosen."""
    v = s.selected
    x, y = s.xy[v, 0], s.xy[v, 1]
    ax, ay, bx, by = s.first_x - x, s.first_y - y, s.second_x - x, s.second_y - y
    dx, dy = qx - x, qy - y
    if float(dx * dx + dy * dy) > r.max_length_sq or not is_long_enough(r, dx, dy):
        return False
    if cross(ax, ay, dx, dy) <= 0 or cross(dx, dy, bx, by) <= 0:
        return False
    if not (is_blunt_enough(r, ax, ay, dx, dy) and is_blunt_enough(r, dx, dy, bx, by)):
        return False
    if not (is_wide_enough(r, 0, 0, ax, ay, dx, dy) and is_wide_enough(r, 0, 0, dx, dy, bx, by)):
        return False
    if axis_of(r, qx, qy) != s.axis[v]:
        return False
    if not crease_is_free(edges, n, x, y, qx, qy):
        return False
    return triangle_is_free(edges, n, x, y, s.first_x, s.first_y, qx, qy) and triangle_is_free(
        edges, n, s.second_x, s.second_y, x, y, qx, qy
    )


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


@inlined
def placing_side(s: Record, r: Record) -> int:
    """The side of the selected leaf whose child is placed now; of no meaning for the middle child."""
    on_axis = s.axis[s.selected] > 0
    if s.phase == SECOND or (s.phase == FIRST and on_axis and near_side(s, r, s.selected) == NEXT):
        return NEXT
    return PREV


@inlined
def location_fits(s: Record, r: Record, edges: Edges, n: int, middle: Middle, side: int, qx: int, qy: int) -> bool:
    """Whether the child that is placed now may lie at the board point q.

    ``edges`` are those of :func:`gather_edges`, ``middle`` and ``side`` the answers of :func:`middle_of` and
    :func:`placing_side`.
    """
    v = s.selected
    x, y = s.xy[v, 0], s.xy[v, 1]
    if (qx == x and qy == y) or not is_playable(r, qx, qy):
        return False
    if s.phase == FIRST or s.phase == SECOND:
        if s.phase == SECOND and not comes_after(s, r, v, s.first_x - x, s.first_y - y, qx - x, qy - y):
            return False
        return outer_child_fits(s, r, edges, n, side, qx, qy)
    ax, ay, bx, by = s.first_x - x, s.first_y - y, s.second_x - x, s.second_y - y
    dx, dy = qx - x, qy - y
    if cross(ax, ay, dx, dy) <= 0 or cross(dx, dy, bx, by) <= 0:
        return False
    if not middle.flat:
        length = np.sqrt(float(dx * dx + dy * dy))
        cos_u2 = (ax * dx + ay * dy) / (middle.a_length * length)
        cos_u3 = (bx * dx + by * dy) / (middle.b_length * length)
        if not triangle_slack(middle.p_sq, middle.m_sq, cos_u2, cos_u3) >= -DEGENERATE:
            return False
    return middle_child_fits(s, r, edges, n, qx, qy)


@bare
def locations(s: Record, r: Record, out: Actions) -> int:
    """Legal location actions in the three placing phases; returns their number."""
    middle, side = middle_of(s, r), placing_side(s, r)
    if not middle.opens:
        return 0
    x, y = s.xy[s.selected, 0], s.xy[s.selected, 1]
    half_x, half_y = r.half_x, r.half_y
    edges = s.edges
    n_edges = gather_edges(s, r, s.selected, edges)
    reach = 2 * max(half_x, half_y) + 1
    if r.max_length_sq < float(reach * reach):
        reach = int(np.sqrt(r.max_length_sq))
    base = 2 * board_points(r)
    n = 0
    for qy in range(max(-half_y, y - reach), min(half_y, y + reach) + 1):
        for qx in range(max(-half_x, x - reach), min(half_x, x + reach) + 1):
            if location_fits(s, r, edges, n_edges, middle, side, qx, qy):
                out[n] = base + point_index(r, qx, qy)
                n += 1
    return n


@bare
def location_is_legal(s: Record, r: Record, qx: int, qy: int) -> bool:
    """Whether the child that is placed now may lie at q, anywhere: one candidate of :func:`locations`."""
    if abs(qx) > r.half_x or abs(qy) > r.half_y:
        return False
    middle = middle_of(s, r)
    if not middle.opens:
        return False
    edges = s.edges
    n = gather_edges(s, r, s.selected, edges)
    return location_fits(s, r, edges, n, middle, placing_side(s, r), qx, qy)


@bare
def write_legal_actions(s: Record, r: Record, out: Actions) -> int:
    """Write the legal actions of the state and return how many there are.

    ``out`` needs room for 2n + 7 actions, n points of the board. An episode that has ended has none.
    """
    if s.status != RUNNING:
        return 0
    points = board_points(r)
    if s.phase == PLACEMENT:
        if s.n_vertices > 0:
            return write_free_segments(s, r, out)
        if s.unfinished < r.picks:
            return write_picks(s, r, out)
        for i in range(2 * r.n_placements):
            out[i] = 3 * points + 5 + i
        return 2 * r.n_placements
    if s.phase != SELECTION:
        return locations(s, r, out)
    n = 0
    w = s.head
    while True:
        if is_selectable(s, r, w):
            out[n] = point_index(r, s.xy[w, 0], s.xy[w, 1])
            n += 1
        code = s.next[w]
        if code & 7 != 0 or code >> 3 == s.head:
            break
        w = code >> 3
    for i in range(n):
        out[n + i] = out[i] + points
    n *= 2
    if s.n_extensions > 0:
        out[n] = 3 * points
        n += 1
    if r.sources and r.order > 1:
        if source_fits(s, r, s.head, PREV):
            out[n], out[n + 1] = 3 * points + 1, 3 * points + 2
            n += 2
        if source_fits(s, r, w, NEXT):
            out[n], out[n + 1] = 3 * points + 3, 3 * points + 4
            n += 2
    if r.sources == ON_BOUNDARY and count_free_segments(s, r) > 0:
        out[n], out[n + 1] = boundary_action(r), boundary_action(r) + 1
        n += 2
    return n
