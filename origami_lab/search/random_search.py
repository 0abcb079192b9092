"""RDM (paper, appendix A.1): uniformly random play, episode after episode."""

from __future__ import annotations

import numpy as np

from origami_lab.objectives.compiled_score import CompiledScore
from origami_lab.search.problem import Problem
from origami_lab.search.random_search_kernel import BETWEEN, ENDED, play_episodes
from origami_lab.search.random_stream import Draws

_PACE = 4096
"""Interactions that are played at most between two looks at the clock."""


class RandomSearch:
    """Samples every action uniformly from the legal ones."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws, score = Draws(rng), problem.compiled_score
        if score is not None:
            _play_compiled(problem, draws, score)
            return
        positions = problem.new_positions(1)
        while not problem.done:
            problem.clear(positions, 0)
            if problem.play_uniform(positions, 0, draws):
                problem.finish(positions, 0)


def _play_compiled(problem: Problem, draws: Draws, score: CompiledScore) -> None:
    """The same where the score is compiled: many episodes in a call."""
    positions, origin = problem.new_positions(1), problem.game.new_states(1)
    memos, rules = problem.evaluator.new_memos(2), problem.game.rules.record
    positions.memos = memos[:1]
    legal = np.empty(problem.game.rules.max_legal, dtype=np.int32)
    how = BETWEEN
    while not problem.done:
        limit = min(problem.remaining, draws.available, _PACE)
        line = positions.states, origin, rules, memos, score
        how, played, ended = play_episodes(*line, problem.best_value, draws.block, draws.used, how, limit, legal)
        draws.use(played)
        problem.spend(played)
        problem.episodes += ended
        if how == ENDED:
            problem.finish(positions, 0)
