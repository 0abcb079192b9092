"""Extending a leaf: three new creases, the motion they give, and the new boundary."""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.boundary import (
    NEXT,
    PREV,
    is_own_image,
    mirror_between,
    near_side,
)
from origami_lab.game.kernels.collisions import collision_free_reach
from origami_lab.game.kernels.state import (
    ALL_IMAGES,
    BARE,
    NOT_FOLDABLE,
    SELECTION,
    Record,
    add_crease,
    add_triangle,
    add_vertex,
    axis_of,
    code_x,
    code_y,
    image_code,
)
from origami_lab.game.kernels.straight_sectors import close_sector, lock_beside, lock_of, plane_side
from origami_lab.geometry.planar import cross
from origami_lab.jit import bare, inlined
from origami_lab.kinematics.three_units import frame_from_edge, lift, middle_crease, mirror_frames


@inlined
def cross3(a: tuple[float, float, float], b: tuple[float, float, float]) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def displaced(
    s: Record, r: Record, axis: int, v: int, k: int, dx: float, dy: float, dz: float
) -> tuple[float, float, float]:
    """A place in space at driving angle k, displaced from v; for a vertex on an axis exactly in its mirror plane."""
    x, y = s.position[v, k, 0] + dx, s.position[v, k, 1] + dy
    if axis > 0:
        m = r.matrices[axis]
        x, y = 0.5 * (x + (m[0] * x + m[1] * y)), 0.5 * (y + (m[2] * x + m[3] * y))
    return x, y, s.position[v, k, 2] + dz


@inlined
def place_vertex(s: Record, r: Record, w: int, v: int, k: int, dx: float, dy: float, dz: float) -> None:
    """Position of w at driving angle k, displaced from v."""
    x, y, z = displaced(s, r, s.axis[w], v, k, dx, dy, dz)
    s.position[w, k, 0], s.position[w, k, 1], s.position[w, k, 2] = x, y, z


@inlined
def outer_place(s: Record, r: Record, k: int, side: int, qx: int, qy: int) -> tuple[float, float, float]:
    """Where an outer child of the selected leaf at board point q will be at driving angle k, known before it is played.

    The panel on its side fixes it, whatever the other children.
    """
    v = s.selected
    dx, dy = qx - s.xy[v, 0], qy - s.xy[v, 1]
    length = np.sqrt(float(dx * dx + dy * dy))
    frames = s.frame_prev[v] if side == PREV else s.frame_next[v]
    ux, uy, uz = lift(frames, k, dx / length, dy / length)
    return displaced(s, r, axis_of(r, qx, qy), v, k, length * ux, length * uy, length * uz)


@inlined
def middle_place(s: Record, r: Record, k: int, qx: int, qy: int) -> tuple[bool, float, float, float]:
    """Where the middle child at board point q will be at driving angle k, and whether the vertex exists there.

    Both outer children are chosen. That the vertex exists at smaller driving angles is not looked at.
    """
    v = s.selected
    x, y = s.xy[v, 0], s.xy[v, 1]
    ax, ay, bx, by = s.first_x - x, s.first_y - y, s.second_x - x, s.second_y - y
    cx, cy = qx - x, qy - y
    la, lb, lc = (
        np.sqrt(float(ax * ax + ay * ay)),
        np.sqrt(float(bx * bx + by * by)),
        np.sqrt(float(cx * cx + cy * cy)),
    )
    plane = plane_side(s, r)
    if plane >= 0:
        exists = True
        ux, uy, uz = lift(s.frame_prev[v] if plane == PREV else s.frame_next[v], k, cx / lc, cy / lc)
    else:
        A = lift(s.frame_prev[v], k, ax / la, ay / la)
        B = lift(s.frame_next[v], k, bx / lb, by / lb)
        cos_u2, cos_u3 = (ax * cx + ay * cy) / (la * lc), (bx * cx + by * cy) / (lb * lc)
        exists, ux, uy, uz = middle_crease(A, B, cos_u2, cos_u3, s.mode)
    px, py, pz = displaced(s, r, axis_of(r, qx, qy), v, k, lc * ux, lc * uy, lc * uz)
    return exists, px, py, pz


@bare
def fold_vertex(s: Record, r: Record, v: int, mode: int, a: int, c: int, b: int) -> int:
    """Solve leaf v with children a, c, b at every reachable angle; returns how many angles, from flat up, exist.

    ``a`` or ``b`` is −1 where it is known already: a merge, or the mirror image of the other one. The panels
    (a, c) and (c, b) become the prev and next frames of c. Where a sector is π they lie in the plane of a panel
    beside v.
    """
    x, y = s.xy[v, 0], s.xy[v, 1]
    ax, ay, bx, by = s.first_x - x, s.first_y - y, s.second_x - x, s.second_y - y
    cx, cy = s.xy[c, 0] - x, s.xy[c, 1] - y
    la, lb, lc = (
        np.sqrt(float(ax * ax + ay * ay)),
        np.sqrt(float(bx * bx + by * by)),
        np.sqrt(float(cx * cx + cy * cy)),
    )
    cos_u2, cos_u3 = (ax * cx + ay * cy) / (la * lc), (bx * cx + by * cy) / (lb * lc)
    on_axis = s.axis[v] > 0
    side = near_side(s, r, v) if on_axis else -1
    plane = plane_side(s, r)
    for k in range(s.reach):
        A = lift(s.frame_prev[v], k, ax / la, ay / la)
        B = lift(s.frame_next[v], k, bx / lb, by / lb)
        if plane >= 0:
            frames = s.frame_prev[v] if plane == PREV else s.frame_next[v]
            ux, uy, uz = lift(frames, k, cx / lc, cy / lc)
            for j in range(6):
                s.frame_prev[c, k, j] = s.frame_next[c, k, j] = frames[k, j]
        else:
            exists, ux, uy, uz = middle_crease(A, B, cos_u2, cos_u3, mode)
            if not exists:
                return k
            C = (ux, uy, uz)
            if side != NEXT:
                frame_from_edge(s.frame_prev[c], k, C, cross3(A, C), cx / lc, cy / lc)
            if side != PREV:
                frame_from_edge(s.frame_next[c], k, C, cross3(C, B), cx / lc, cy / lc)
        if on_axis:
            m = r.matrices[s.axis[v]]
            if side == NEXT:
                mirror_frames(s.frame_prev[c], s.frame_next[c], k, m[0], m[1], m[2], m[3])
            else:
                mirror_frames(s.frame_next[c], s.frame_prev[c], k, m[0], m[1], m[2], m[3])
        place_vertex(s, r, c, v, k, lc * ux, lc * uy, lc * uz)
        if a >= 0:
            place_vertex(s, r, a, v, k, la * A[0], la * A[1], la * A[2])
        if b >= 0:
            place_vertex(s, r, b, v, k, lb * B[0], lb * B[1], lb * B[2])
    return s.reach


@bare
def add_side_triangles(s: Record, r: Record, v: int, side: int, child: int, merged: int, c: int) -> None:
    """The triangles of one side of an extension: the panel beside the middle crease, then the outer panel."""
    outer = s.prev[v] if side == PREV else s.next[v]
    end = 8 * merged if child < 0 else 8 * child
    if side == PREV:
        add_triangle(s, r, 8 * v, end, 8 * c, ALL_IMAGES)
    else:
        add_triangle(s, r, 8 * v, 8 * c, end, ALL_IMAGES)
    if child < 0:
        return
    x, y = s.xy[v, 0], s.xy[v, 1]
    ox, oy = code_x(s, r, outer) - x, code_y(s, r, outer) - y
    dx, dy = s.xy[child, 0] - x, s.xy[child, 1] - y
    if cross(ox, oy, dx, dy) == 0:
        return  # the child lies on the boundary segment: the outer panel gains nothing
    images = mirror_between(s, r, v, outer) if is_own_image(s, r, v, outer) else ALL_IMAGES
    if side == PREV:
        add_triangle(s, r, 8 * v, outer, end, images)
    else:
        add_triangle(s, r, 8 * v, end, outer, images)
    if images != ALL_IMAGES and s.axis[child] == 0:
        across = image_code(r, images, end)
        if side == PREV:
            add_triangle(s, r, outer, across, end, images)
        else:
            add_triangle(s, r, outer, end, across, images)


@inlined
def copy_frames(s: Record, target: int, target_side: int, source: int, source_side: int) -> None:
    for k in range(s.reach):
        for j in range(6):
            value = s.frame_prev[source, k, j] if source_side == PREV else s.frame_next[source, k, j]
            if target_side == PREV:
                s.frame_prev[target, k, j] = value
            else:
                s.frame_next[target, k, j] = value


@bare
def link_side(s: Record, r: Record, v: int, side: int, child: int, merged: int, c: int) -> None:
    """Put the child of one side into the boundary between the middle child and v's neighbour on that side."""
    outer = s.prev[v] if side == PREV else s.next[v]
    w = merged if child < 0 else child
    crease, panel_side = 8 * v, side
    was_bare = child < 0 and s.locked[w] == BARE
    # towards the middle: the crease from v and the panel beside the middle crease
    if side == PREV:
        if was_bare:
            s.locked[w], s.last[w] = 0, crease
        elif child < 0:
            close_sector(s, w, lock_beside(s, r, w, NEXT))
        s.next[w], s.first[w] = 8 * c, crease
        copy_frames(s, w, NEXT, c, panel_side)
        s.prev[c] = 8 * w
    else:
        if was_bare:
            s.locked[w], s.first[w] = 0, crease
        elif child < 0:
            close_sector(s, w, lock_beside(s, r, w, PREV))
        s.prev[w], s.last[w] = 8 * c, crease
        copy_frames(s, w, PREV, c, panel_side)
        s.next[c] = 8 * w
    if child >= 0:
        # away from it: the outer panel continues flat
        copy_frames(s, w, side, v, side)
        if side == PREV:
            s.last[w], s.prev[w] = crease, outer
        else:
            s.first[w], s.next[w] = crease, outer
        if outer & 7 == 0:
            u = outer >> 3
            if side == PREV:
                s.next[u] = 8 * w
            else:
                s.prev[u] = 8 * w
            if s.axis[u] > 0:
                if side == PREV:
                    s.prev[u] = image_code(r, s.axis[u], 8 * w)
                else:
                    s.next[u] = image_code(r, s.axis[u], 8 * w)
        elif s.axis[w] == 0:
            g = mirror_between(s, r, v, outer)
            if side == PREV:
                s.prev[w] = image_code(r, g, 8 * w)
            else:
                s.next[w] = image_code(r, g, 8 * w)
    g = s.axis[w]
    if g > 0 and (child < 0 or outer & 7 != 0):
        # on an axis: the other side of w is the mirror image of this one
        m = r.matrices[g]
        for k in range(s.reach):
            if side == PREV:
                mirror_frames(s.frame_prev[w], s.frame_next[w], k, m[0], m[1], m[2], m[3])
            else:
                mirror_frames(s.frame_next[w], s.frame_prev[w], k, m[0], m[1], m[2], m[3])
        if side == PREV:
            s.prev[w], s.last[w] = image_code(r, g, s.next[w]), image_code(r, g, s.first[w])
        else:
            s.next[w], s.first[w] = image_code(r, g, s.prev[w]), image_code(r, g, s.last[w])
        if child >= 0 or was_bare:
            close_sector(s, w, lock_of(s, r, w, s.first[w], s.last[w]))


@bare
def extend(s: Record, r: Record, cx: int, cy: int) -> None:
    """Extend the selected leaf with its chosen outer children and the middle child at (cx, cy).

    Nothing is changed if the extension cannot fold: then the status says so (paper, section 3.4, rule 5).
    """
    v, mode = s.selected, s.mode
    on_axis = s.axis[v] > 0
    near = near_side(s, r, v) if on_axis else -1
    n_vertices, n_triangles = s.n_vertices, s.n_triangles
    a = b = -1
    merged_a = merged_b = -1
    if near != NEXT:
        merges = code_x(s, r, s.prev[v]) == s.first_x and code_y(s, r, s.prev[v]) == s.first_y
        if merges:
            merged_a = s.prev[v] >> 3
        else:
            a = add_vertex(s, r, s.first_x, s.first_y)
    if near != PREV:
        merges = code_x(s, r, s.next[v]) == s.second_x and code_y(s, r, s.next[v]) == s.second_y
        if merges:
            merged_b = s.next[v] >> 3
        else:
            b = add_vertex(s, r, s.second_x, s.second_y)
    c = add_vertex(s, r, cx, cy)
    reach = fold_vertex(s, r, v, mode, a, c, b)
    if reach >= r.min_reach:
        if near != NEXT:
            add_side_triangles(s, r, v, PREV, a, merged_a, c)
        if near != PREV:
            add_side_triangles(s, r, v, NEXT, b, merged_b, c)
        if r.collisions:
            reach = collision_free_reach(s, r, n_triangles, s.n_triangles, reach)
    s.phase = SELECTION
    if reach < r.min_reach:
        s.n_vertices, s.n_triangles = n_vertices, n_triangles
        s.status = NOT_FOLDABLE
        return
    s.reach = reach
    s.first[c] = s.last[c] = 8 * v
    outer_prev = s.prev[v]
    if near != NEXT:
        link_side(s, r, v, PREV, a, merged_a, c)
        add_crease(s, 8 * v, s.prev[c], 0)
    if near != PREV:
        link_side(s, r, v, NEXT, b, merged_b, c)
        add_crease(s, 8 * v, s.next[c], 0)
    add_crease(s, 8 * v, 8 * c, 0)
    if on_axis:
        if near == NEXT:
            s.prev[c] = image_code(r, s.axis[c], s.next[c])
        else:
            s.next[c] = image_code(r, s.axis[c], s.prev[c])
    if s.head == v:
        s.head = a if a >= 0 else c
        if a < 0 and outer_prev & 7 == 0:
            s.head = outer_prev >> 3
    s.modes[v] = mode
    s.n_extensions += 1
    s.unfinished = 0
