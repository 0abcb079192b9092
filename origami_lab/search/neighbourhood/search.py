"""The searcher ``lns``: what it is told, and how it begins."""

from __future__ import annotations

import math

import numpy as np

from origami_lab.search.neighbourhood.accepting import Accepting
from origami_lab.search.neighbourhood.bench import WORK
from origami_lab.search.neighbourhood.covering import Covering
from origami_lab.search.neighbourhood.method_numbers import MethodNumbers
from origami_lab.search.neighbourhood.portfolio import Portfolio
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws


class NeighbourhoodSearch(MethodNumbers):
    """Large-neighbourhood search: cut a part of a design away, grow it again, take what is better.

    The parameters are those of :class:`~.method_numbers.MethodNumbers`.
    """

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws = Draws(rng)
        offered = [getattr(problem.evaluator, name, None) for name in ("compiled_bound", "compiled_cover")]
        covers = None not in offered
        improver: Covering | Accepting = Covering(problem, draws, self) if covers else Accepting(problem, draws, self)
        Portfolio(problem, draws, self, improver).search(self._start_alone(problem, improver))
        self._score_at_all_angles(problem)

    def _start_alone(self, problem: Problem, improver: Covering | Accepting) -> float:
        """The distance of the start pattern alone, half the longer side of the board if it has none."""
        bench = improver.bench
        bench.place(improver.angles[-1])
        if problem.done:
            return 0.0
        value = bench.score(WORK)
        return -value if math.isfinite(value) else float(max(problem.game.rules.half))

    def _score_at_all_angles(self, problem: Problem) -> None:
        """Runs look at driving angles up to their own: the best design may be worth more at a larger one."""
        found = problem.outcome()
        if found.succeeded:
            whole = problem.new_positions(1)
            whole.states[:] = problem.game.replay(found.actions)
            problem.finish(whole, 0)
