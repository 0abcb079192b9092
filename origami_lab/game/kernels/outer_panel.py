"""The outer panel of an extension: it is known as soon as its child is chosen, and so is what it runs into."""

from __future__ import annotations

from origami_lab.game.kernels.boundary import PREV, is_own_image
from origami_lab.game.kernels.collisions import collision_free_reach
from origami_lab.game.kernels.extension import outer_place
from origami_lab.game.kernels.legal_actions import placing_side
from origami_lab.game.kernels.state import ALL_IMAGES, Record, add_triangle, add_vertex, code_x, code_y
from origami_lab.geometry.planar import cross
from origami_lab.jit import bare


@bare
def outer_panel_collides(s: Record, r: Record, reach: int, qx: int, qy: int) -> bool:
    """Whether an outer child at board point q, not yet played, has a panel that collides at one of ``reach`` angles.

    Then no choice of the other children folds that far. The panel is laid behind those of the sheet for a moment;
    the state is as before. Not looked at are panels that lie over a seam between images.
    """
    if r.collisions == 0:
        return False
    v, side = s.selected, placing_side(s, r)
    outer = s.prev[v] if side == PREV else s.next[v]
    x, y = s.xy[v, 0], s.xy[v, 1]
    along_boundary = cross(code_x(s, r, outer) - x, code_y(s, r, outer) - y, qx - x, qy - y) == 0
    if along_boundary or is_own_image(s, r, v, outer):
        return False
    vertices, triangles = s.n_vertices, s.n_triangles
    w = add_vertex(s, r, qx, qy)
    for k in range(reach):
        s.position[w, k, 0], s.position[w, k, 1], s.position[w, k, 2] = outer_place(s, r, k, side, qx, qy)
    add_triangle(s, r, 8 * v, outer, 8 * w, ALL_IMAGES)
    free = collision_free_reach(s, r, triangles, triangles + 1, reach)
    s.n_vertices, s.n_triangles = vertices, triangles
    return bool(free < reach)
