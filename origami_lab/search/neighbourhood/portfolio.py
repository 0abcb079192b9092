"""The portfolio: rounds of short runs that race for the budget.

In each round many fresh runs begin, the best of them go on, and the best of all goes on until it finds nothing more.
The first rounds are tiny, so that small tasks are solved in them, and each is longer than the one before until a fresh
run has its full share of the budget.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from origami_lab.search.neighbourhood.one_run import LocalRun
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

if TYPE_CHECKING:
    from origami_lab.search.neighbourhood.method_numbers import MethodNumbers


class Improver(Protocol):
    """How runs improve."""

    @property
    def angles(self) -> Sequence[int]:
        """Driving angles that runs can have."""
        ...

    def improve(self, run: LocalRun, until: int, patience: float = math.inf) -> None:
        """Go on with a run until so many interactions are played in all, or so many since its last success."""
        ...

    def rank(self, run: LocalRun) -> Any:
        """What runs are compared by; less is better."""
        ...

    def relax(self, run: LocalRun) -> bool:
        """Make the run's threshold one that it has nearly reached; whether that pays."""
        ...


class Portfolio:
    """Rounds of runs until the budget is spent."""

    def __init__(self, problem: Problem, draws: Draws, settings: MethodNumbers, improver: Improver) -> None:
        self.problem, self.draws, self.settings, self.improver = problem, draws, settings, improver
        self.full = max(settings.first_run, round(settings.run * problem.budget))
        self.length = float(settings.first_run)
        self.factor = settings.threshold
        self.best_angles: list[int] = []
        self.runs: list[LocalRun] = []
        """Those of the present round, or of an earlier search that is to go on."""

    def search(self, reference: float) -> None:
        """Rounds until the search ends; no threshold is above ``reference``, in board cells."""
        if self.runs and not self.problem.done:
            self.race(self.runs, min(round(self.length), self.full))
        while not self.problem.done:
            self.round(min(round(self.length), self.full), reference)
            self.length *= self.settings.growth

    def round(self, length: int, reference: float) -> None:
        """One round, in which a fresh run has so many interactions."""
        problem, settings, improver = self.problem, self.settings, self.improver
        before, grown_up = problem.best_value, length >= self.full
        factor = self.factor if grown_up else self._factor_at(length)
        runs = self.runs = []
        for angle in self._angles(grown_up):
            threshold = factor * min(reference, -problem.best_value)
            run = LocalRun(angle, wide=self.draws.one() < settings.wide, threshold=threshold)
            improver.improve(run, problem.interactions + length)
            runs.append(run)
            if problem.done:
                return
        runs.sort(key=improver.rank)
        self.best_angles = [run.angle for run in runs[: max(1, round(settings.elite_part * len(runs)))]]
        self.race(runs, length)
        if grown_up and not problem.best_value > before + settings.enough * abs(before):
            self.factor = math.sqrt(self.factor)

    def race(self, runs: list[LocalRun], length: int) -> None:
        """Let the best of a round's runs, which come first, go on, and the best of all until it finds nothing more."""
        problem, settings, improver = self.problem, self.settings, self.improver
        runs = runs[: settings.kept]
        for run in runs:
            improver.improve(run, problem.interactions + round(settings.kept_run * length))
        best = min(runs, key=improver.rank)
        patience = settings.patience * length
        improver.improve(best, problem.budget, patience)
        if length >= self.full and improver.relax(best):
            improver.improve(best, problem.budget, patience)

    def _factor_at(self, length: int) -> float:
        """What part of the best distance a run is to reach: more is asked of short runs."""
        s = self.settings
        way = math.log(length / s.first_run) / math.log(self.full / s.first_run)
        return s.first_threshold + way * (s.threshold - s.first_threshold)

    def _angles(self, grown_up: bool) -> list[int]:
        """Driving angles of a round's fresh runs: each as often as the others, save for those that did well before."""
        settings, draws, angles = self.settings, self.draws, self.improver.angles
        known = (settings.elite if grown_up else settings.first_elite) if self.best_angles else 0.0
        chosen: list[int] = []
        pool: list[int] = []
        for _ in range(settings.runs):
            if draws.one() < known:
                chosen.append(self.best_angles[draws.below(len(self.best_angles))])
                continue
            pool = pool or list(angles)
            chosen.append(pool.pop(draws.below(len(pool))))
        return chosen
