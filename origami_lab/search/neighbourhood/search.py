"""The searcher ``lns``: what it is told, and how it begins."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from origami_lab.search.neighbourhood.accepting import Accepting
from origami_lab.search.neighbourhood.covering import Covering
from origami_lab.search.neighbourhood.ground import WORK
from origami_lab.search.neighbourhood.method_numbers import MethodNumbers
from origami_lab.search.neighbourhood.portfolio import Portfolio
from origami_lab.search.neighbourhood.saved_runs import load_portfolio, save_portfolio
from origami_lab.search.problem import Problem, SearcherState
from origami_lab.search.random_stream import Draws


class NeighbourhoodSearch(MethodNumbers):
    """Large-neighbourhood search: cut a part of a design away, grow it again, take what is better.

    The parameters are those of :class:`~.method_numbers.MethodNumbers`.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        self._portfolio: Portfolio | None = None
        self._loaded: SearcherState | None = None

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws = Draws(rng)
        offered = [getattr(problem.evaluator, name, None) for name in ("compiled_bound", "compiled_cover")]
        covers = None not in offered
        improver: Covering | Accepting = Covering(problem, draws, self) if covers else Accepting(problem, draws, self)
        self._portfolio = portfolio = Portfolio(problem, draws, self, improver)
        loaded, self._loaded = self._loaded, None
        if loaded is not None:
            load_portfolio(portfolio, loaded)
        portfolio.search(self._start_alone(problem, improver))
        self._score_at_all_angles(problem)

    def save(self) -> Mapping[str, ArrayLike]:
        """How far the rounds have come, and the best runs of the last one with their designs."""
        return {} if self._portfolio is None else save_portfolio(self._portfolio)

    def load(self, state: SearcherState) -> None:
        """Take up saved rounds: the best of their runs go on first."""
        self._loaded = state or None

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
