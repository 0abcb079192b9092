"""A bound inside a move: an outer child that is chosen has its place in space before the move is complete."""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.boundary import NEXT, PREV, near_side
from origami_lab.game.kernels.extension import outer_place
from origami_lab.game.kernels.state import SECOND, Record
from origami_lab.jit import bare
from origami_lab.objectives.known_places import Surface, strayed_squared


@bare
def stray_inside(s: Record, r: Record, memo: Record, target: Surface, enough: float) -> float:
    """The smallest d→ + penalty over the usable reachable angles, with the outer child that was chosen last.

    d→ of the vertices must have been measured by :func:`~.shape_kernels.stray`. At an angle whose sum
    has reached ``enough`` the rest is not measured: the returned value is then at least ``enough``, too.
    """
    v = s.selected
    side = PREV
    if s.axis[v] > 0:
        side = near_side(s, r, v)
    elif s.phase != SECOND:
        side = NEXT
    qx, qy = (s.first_x, s.first_y) if side == PREV else (s.second_x, s.second_y)
    best = np.inf
    for k in range(r.min_reach - 1, s.reach):
        far, penalty = memo.stray[k], memo.penalty[k]
        if far + penalty < enough:
            x, y, z = outer_place(s, r, k, side, qx, qy)
            if target.compactness > 0.0:
                penalty = max(penalty, target.compactness * np.sqrt(x * x + y * y + z * z))
            for g in range(r.order if target.images else 1):
                gx = r.matrices[g, 0] * x + r.matrices[g, 1] * y
                gy = r.matrices[g, 2] * x + r.matrices[g, 3] * y
                squared, memo.near = strayed_squared(target, gx, gy, z, far * far, enough * enough, memo.near, s.far)
                if squared > far * far:
                    far = np.sqrt(squared)
        best = min(best, far + penalty)
    return best
