"""Growth without a guide: whole moves, each uniformly random, taken back where they cannot be completed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import settle
from origami_lab.game.kernels.state import NOT_FOLDABLE, SELECTION, States, board_points
from origami_lab.game.kernels.undo import play_noted
from origami_lab.game.move_table import ACTIONS, take_back
from origami_lab.jit import kernel
from origami_lab.search.neighbourhood.ground import Room
from origami_lab.search.random_stream import Actions

DRAWS = ACTIONS
"""Random numbers that one attempt needs at most."""


@kernel
def random_move(
    states: States,
    i: int,
    rules: States,
    attempts: int,
    room: Room,
    draws: NDArray[np.float64],
    used: int,
    limit: int,
) -> tuple[bool, int, int]:
    """Play a random move on state i, which stands between two; other attempts follow one that cannot be completed.

    ``draws`` must hold :data:`DRAWS` numbers for each attempt, from index ``used`` on; at most ``limit`` actions are
    played. Returns whether a move is on the board (else the state is as before), the draws used in all, and the number
    of actions played.
    """
    s, r = states[i], rules[0]
    end = 3 * board_points(r)
    played = 0
    for _ in range(attempts):
        n = settle(s, r, room.legal)
        depth, complete = 0, False
        if n > 0 and s.phase == SELECTION:
            n = without(room.legal, n, end)
        while n > 0 and played < limit:
            action = room.legal[int(draws[used] * n)]
            used += 1
            played += 1
            n = play_noted(s, r, action, room.notes[depth], room.legal)
            depth += 1
            if s.phase == SELECTION:
                complete = s.status != NOT_FOLDABLE
                break
        if complete:
            return True, used, played
        take_back(s, room.notes, depth)
        if depth == 0 or played >= limit:
            break
    return False, used, played


@kernel
def without(legal: Actions, n: int, action: int) -> int:
    """Take an action out of a list of n; returns how many are left."""
    left = 0
    for j in range(n):
        if legal[j] != action:
            legal[left] = legal[j]
            left += 1
    return left
