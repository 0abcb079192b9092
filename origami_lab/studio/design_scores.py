"""What designs are worth: at once by an objective of ours, by one of the user's once it has said so elsewhere."""

from __future__ import annotations

import math
from typing import Any

from origami_lab.game.game import Game
from origami_lab.game.kernels.state import States
from origami_lab.objectives.objective import Evaluator, Score, bind
from origami_lab.workers.guarded_objective import is_ours


def score_of(evaluator: Evaluator, states: States) -> Score | None:
    """The return of a state, and the index of its driving angle; None where it has none."""
    if not int(states["n_vertices"][0]):
        return None
    memos = evaluator.new_memos(1)
    evaluator.clear(memos, 0)
    score = evaluator.score(states, memos, 0)
    return score if score.angle >= 0 and math.isfinite(score.value) else None


class DesignScores:
    """Scores of designs, as logs of actions.

    A user's own objective is not asked here, where all tabs would wait for it: what a process of its own says is told
    to :meth:`learn`.
    """

    def __init__(self, objective: Any, game: Game) -> None:
        self._evaluator = bind(objective, game) if is_ours(objective) else None
        self._learnt: dict[tuple[int, ...], Score | None] = {}

    def knows(self, actions: tuple[int, ...]) -> bool:
        """Whether the return of a design is known, or that there is none."""
        return self._evaluator is not None or not actions or actions in self._learnt

    def learn(self, actions: tuple[int, ...], score: Score | None) -> None:
        """Take what a user's objective says of a design; None if it has said nothing."""
        self._learnt[actions] = score

    def of(self, actions: tuple[int, ...], states: States) -> Score | None:
        """The return of a design that is in a state; None where it has none, or none is known."""
        return self._learnt.get(actions) if self._evaluator is None else score_of(self._evaluator, states)
