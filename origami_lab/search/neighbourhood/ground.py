"""What runs work on, as compiled code holds it, and how an episode begins there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import play_action, settle
from origami_lab.game.kernels.state import PLACEMENT, Record, States, copy_state
from origami_lab.game.kernels.undo import Notes
from origami_lab.jit import bare
from origami_lab.search.neighbourhood.known_strays import KnownStrays
from origami_lab.search.random_stream import Actions

WORK, REST, BEST = 0, 1, 2
"""States: the one worked on, what was left of a design to grow from, the best that came of it."""

DEPTHS = 3
"""Children of an extension: lists of places that are open at once."""

PLACE_DRAWS = 3
"""Random numbers that placing a start pattern takes at most."""


class Room(NamedTuple):
    """What growth writes to besides the state: notes to take actions back, legal actions, open lists, known strays.

    Each of the :data:`DEPTHS` lists has room for all places that a child of one leaf can have.
    """

    notes: Notes
    legal: Actions
    lists: NDArray[np.int32]
    known: KnownStrays


class Ground(NamedTuple):
    """What runs work on.

    Attributes
    ----------
    states
        :data:`WORK` and so on.
    origin
        Where episodes begin.
    rules, plain
        The run's rules, and the same without collisions, for moves that are known to be free of them.
    room
        What growth writes to.
    """

    states: States
    origin: States
    rules: States
    plain: States
    room: Room


@bare
def begin_at(ground: Ground, angle: int) -> None:
    """Make the state worked on one where episodes begin, to fold to a driving angle."""
    s = ground.states[WORK]
    copy_state(s, ground.origin[0])
    s.reach = min(s.reach, angle + 1)


@bare
def place_at_random(s: Record, r: Record, legal: Actions, draws: NDArray[np.float64], used: int, limit: int) -> int:
    """Lay a random start pattern with ``limit`` actions at most; returns their number, one draw is used for each."""
    played = 0
    while s.phase == PLACEMENT and played < limit:
        n = settle(s, r, legal)
        play_action(s, r, legal[int(draws[used + played] * n)])
        settle(s, r, legal)
        played += 1
    return played


@bare
def place_start(ground: Ground, draws: NDArray[np.float64], used: int, limit: int) -> int:
    """:func:`place_at_random` on the state worked on."""
    return place_at_random(ground.states[WORK], ground.rules[0], ground.room.legal, draws, used, limit)
