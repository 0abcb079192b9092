"""Random play, compiled: one episode after another, until one may be the best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import Actions, play_action, settle
from origami_lab.game.kernels.state import RUNNING, States, copy_state, is_penalised
from origami_lab.jit import bare
from origami_lab.objectives.compiled_score import CompiledScore, best_in_kernel
from origami_lab.objectives.objective import Memos

# why play stopped: an episode has ended that may be the best, or none is under way; one is
ENDED, BETWEEN, UNDER_WAY = 0, 1, 2


@bare
def play_episodes(
    states: States,
    origin: States,
    rules: States,
    memos: Memos,
    score: CompiledScore,
    best: float,
    draws: NDArray[np.float64],
    used: int,
    how: int,
    limit: int,
    legal: Actions,
) -> tuple[int, int, int]:
    """Play uniformly random episodes on the first state until one is better than ``best``, or to the limit.

    Parameters
    ----------
    states, origin, memos
        What is played on, where episodes begin, and the evaluator's notes: of the first state, and clear ones.
    score
        What says that an episode is no better.
    draws, used
        Random numbers, one for each action, and how many are used up.
    how
        What the last call returned.
    limit
        Actions that may be played, no more than there are draws left.

    Returns
    -------
    how
        ENDED: the episode on the state may be the best; its notes are clear.
    played, ended
        Actions played, and episodes that have ended and are no better.
    """
    s, r = states[0], rules[0]
    played = ended = 0
    while True:
        if how != UNDER_WAY:
            # an episode without an action brings none nearer to the limit
            if played >= limit or ended > limit:
                return BETWEEN, played, ended
            copy_state(s, origin[0])
            memos[0] = memos[1]
            how = UNDER_WAY
        while s.status == RUNNING:
            if played >= limit:
                return UNDER_WAY, played, ended
            n = settle(s, r, legal)
            if n > 0:
                play_action(s, r, legal[int(draws[used + played] * n)])
                played += 1
        if not is_penalised(s, r) and best_in_kernel(states, 0, rules, memos, 0, score, best)[1] >= 0:
            memos[0] = memos[1]
            return ENDED, played, ended
        ended += 1
        how = BETWEEN
