"""Runs without a threshold: a changed design is grown at random, and late acceptance decides.

Whatever is on the board between two moves is a design, so each one on the way is scored, one interaction, and the best
of them is the candidate.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

from origami_lab.search.neighbourhood.bench import Bench
from origami_lab.search.neighbourhood.changes import Change, cut, is_bare, random_move, shift, unchanged
from origami_lab.search.neighbourhood.ground import BEST, REST, WORK
from origami_lab.search.neighbourhood.one_run import LocalRun, RunDesign
from origami_lab.search.neighbourhood.wandering import DRAWS
from origami_lab.search.neighbourhood.wandering import random_move as play_random_move
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

if TYPE_CHECKING:
    from origami_lab.search.neighbourhood.method_numbers import MethodNumbers


class Accepting:
    """How runs improve for any objective."""

    def __init__(self, problem: Problem, draws: Draws, settings: MethodNumbers) -> None:
        self.problem, self.draws, self.settings = problem, draws, settings
        self.bench = Bench(problem, draws)

    # --- what the portfolio asks for ---------------------------------------------------------------------------------

    @property
    def angles(self) -> range:
        return self.bench.angles

    def rank(self, run: LocalRun) -> float:
        return -run.value

    def improve(self, run: LocalRun, until: int, patience: float = math.inf) -> None:
        """Go on with a run until so many interactions are played in all, or so many since its last success."""
        problem = self.problem
        run.last = problem.interactions
        while not problem.done and problem.interactions < until and problem.interactions - run.last < patience:
            if run.design is None:
                self.construct(run)
            else:
                self.vary(run)

    def relax(self, run: LocalRun) -> bool:
        return False

    # --- one run -----------------------------------------------------------------------------------------------------

    def construct(self, run: LocalRun) -> None:
        """A first design: the start pattern alone."""
        bench = self.bench
        if bench.place(run.angle):
            run.value = bench.score(WORK)
            run.design = bench.read(WORK)
            run.accepted = deque([run.value], maxlen=self.settings.history)

    def vary(self, run: LocalRun) -> None:
        """One change of the design, grown again a few times; the best design on the way is accepted or not."""
        bench, problem, design = self.bench, self.problem, run.design
        assert design is not None
        before = problem.interactions
        change = self.change(design)
        bench.lay(change, None, run.angle)
        # not worse than now, or than some time ago
        enough = min(run.accepted[0], run.accepted[-1])
        value = self.best_regrowth(enough, laid_anew=change.first < len(change.goes))
        if problem.interactions == before:
            bench.spend(1)  # nothing could be played; an attempt is never free
        if value is not None and value >= enough:
            run.design = bench.read(BEST)
            if value > run.value:
                run.value, run.last = value, problem.interactions
        else:
            value = run.accepted[-1]
        run.accepted.append(value)

    def change(self, design: RunDesign) -> Change:
        """What is changed: a random move is cut away, a vertex of one is shifted, or nothing."""
        s, draws = self.settings, self.draws
        if is_bare(design) or draws.one() < s.free:
            return unchanged(design)
        chosen = random_move(design, draws)
        if draws.one() < s.shift:
            return shift(design, chosen, self.problem.game.rules.half, s.flip, draws) or unchanged(design)
        return cut(design, chosen, s.more, draws)

    def best_regrowth(self, enough: float, *, laid_anew: bool) -> float | None:
        """The best return of the designs met while what is on the bench grows a few times, and that design as BEST.

        None if there was none. What is on the bench is one, if it was laid anew. Growth stops where no continuation can
        be worth ``enough``.
        """
        bench, problem, settings = self.bench, self.problem, self.settings
        best: float | None = None

        def meet() -> None:
            nonlocal best
            value = bench.score(WORK)
            if best is None or value > best:
                best = value
                bench.copy(BEST, WORK)

        bench.copy(REST, WORK)
        if laid_anew and not problem.done:
            meet()
        for again in range(settings.regrowths):
            if again > 0:
                bench.copy(WORK, REST)
            while not problem.done and self.grow() and not problem.done:
                if bench.bound(WORK, math.nextafter(enough, -math.inf)) < enough:
                    break
                meet()
                if self.draws.one() >= settings.longer:
                    break
        return best

    def grow(self) -> bool:
        """A random move on the bench; False if none was found."""
        bench, draws, attempts = self.bench, self.draws, self.settings.attempts
        draws.reserve(attempts * DRAWS)
        grown, draws.used, played = play_random_move(
            *(bench.positions.states, WORK, bench.rules, attempts, bench.room),
            *(draws.block, draws.used, self.problem.remaining),
        )
        bench.spend(played)
        return bool(grown)
