"""Laying a whole design on a fine board, every place legal and every driving angle reached."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.start_placement import place_start
from origami_lab.game.kernels.state import PANEL, SQUARE, Record, States, axis_of, clear, is_playable
from origami_lab.game.kernels.undo import Notes
from origami_lab.game.move_table import Points, lay_move
from origami_lab.jit import inlined, kernel
from origami_lab.polish.finer_board import ANGLES, EXEMPT, EXEMPT_STRICT, LOOSE, STRICT, Layout


@inlined
def place_is_free(r: Record, x: int, y: int, axis: int) -> bool:
    """Whether a point is on the board, in the fundamental domain, and on the mirror axis it has to be on."""
    return abs(x) <= r.half_x and abs(y) <= r.half_y and is_playable(r, x, y) and axis_of(r, x, y) == axis


@kernel
def lay_start(s: Record, r: Record, layout: Layout, points: Points) -> bool:
    """Lay the start pattern with its corners at their points; returns whether it is one.

    A square keeps its corners on the diagonals, a crease its ends on a line along x; those of any other stay.
    """
    clear(s)
    if r.start == PANEL:
        place_start(s, r, 0, layout.moves[0].sign)
        for v in range(layout.corners):
            if s.xy[v, 0] != points[v, 0] or s.xy[v, 1] != points[v, 1]:
                return False
        return True
    if r.start == SQUARE:
        size = abs(points[0, 0])
        if size < 1 or size >= min(r.half_x, r.half_y):
            return False
        place_start(s, r, size, layout.moves[0].sign)
        for v in range(layout.corners):
            if s.xy[v, 0] != points[v, 0] or s.xy[v, 1] != points[v, 1]:
                return False
        return True
    height = points[0, 1]
    if abs(height) >= r.half_y:
        return False
    place_start(s, r, height, layout.moves[0].sign)
    for v in range(layout.corners):
        # the game's crease ends at x = −1 and 1; which end a corner is stays
        if points[v, 0] * s.xy[v, 0] <= 0 or points[v, 1] != height or abs(points[v, 0]) > r.half_x:
            return False
        s.xy[v, 0] = points[v, 0]
        for k in range(s.position.shape[1]):
            s.position[v, k, 0] = points[v, 0]
    return True


@kernel
def lay_design(
    states: States,
    rules: States,
    strict: bool,
    layout: Layout,
    points: Points,
    notes: Notes,
    angles: NDArray[np.float64],
) -> bool:
    """Lay a design on the first state; returns whether all its moves are legal and fold to all of (10,) driving angles.

    Moves must do what they did in the game: a child that has come to lie on a neighbour would merge into it.

    Parameters
    ----------
    rules
        Those of the fine board; they keep the driving angles.
    strict
        Whether panels may not pass through each other, if the game says so.
    notes
        Room to take back one move.
    """
    for which in range(rules.shape[0]):
        for k in range(angles.shape[0]):
            rules[which].angles[k] = angles[k]
    s = states[0]
    if not lay_start(s, rules[EXEMPT], layout, points):
        return False
    for m in range(1, layout.moves.shape[0]):
        if m < layout.exempt:
            r = rules[EXEMPT_STRICT if strict else EXEMPT]
        else:
            r = rules[STRICT if strict else LOOSE]
        laid, _ = lay_move(s, r, layout.moves[m], points, notes)
        if not laid or s.n_vertices != layout.counts[m]:
            return False
    return True


@kernel
def equal_steps(angle: float) -> NDArray[np.float64]:
    """(10,) equal steps up to a driving angle."""
    return angle * np.arange(1, ANGLES + 1).astype(np.float64) / ANGLES
