"""Relay: the moves of a design laid again after a change, as far as they still can be.

A move goes if its leaf lost a crease (:func:`~origami_lab.game.move_table.lay_rest`), and under a threshold also if it
would stray beyond it.
"""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.collisions import sweep_triangle
from origami_lab.game.kernels.state import States
from origami_lab.game.kernels.undo import Notes
from origami_lab.game.move_table import Flags, Moves, Points, hangs_loose, lay_move, loosen, replay_move, take_back
from origami_lab.jit import kernel
from origami_lab.search.neighbourhood.threshold import Aim, sheet_strays


@kernel
def relay(
    states: States,
    i: int,
    rules: States,
    plain: States,
    aim: Aim | None,
    moves: Moves,
    points: Points,
    goes: Flags,
    first: int,
    recheck: bool,
    notes: Notes,
) -> int:
    """Lay a table of moves on state i, where an episode begins; returns how many actions are to be counted.

    Actions count from the first move that goes or has changed: what comes before is a state that was paid for.

    Parameters
    ----------
    rules, plain
        The run's rules, and the same without collisions, for moves that are known to be free of them.
    aim
        The threshold that moves must keep; None for none.
    goes
        (M,) not 0 for moves that go in any case.
    first
        The first move that goes or is not as it was when the table was read.
    recheck
        Whether the moves before it are to be held against a threshold that has become lower.
    """
    s, r = states[i], rules[0]
    loose = np.zeros(points.shape[0], np.int8)
    counted, same = 0, True
    for m in range(moves.shape[0]):
        vertices, triangles = s.n_vertices, s.n_triangles
        same = same and m < first
        if same and not recheck:
            replay_move(s, plain[0], moves[m], points)
            for t in range(triangles, s.n_triangles):
                sweep_triangle(s, r, t, s.reach)
            continue
        if goes[m] == 0 and not hangs_loose(loose, moves[m]):
            laid, played = lay_move(s, r, moves[m], points, notes)
            if not same:
                counted += played
            if laid:
                if aim is None or not sheet_strays(s, r, aim, vertices, triangles):
                    continue
                take_back(s, notes, played)
        same = False
        loosen(loose, moves[m])
    return counted
