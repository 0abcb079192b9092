"""Runs under a threshold: a design is changed and grown again until it covers all of the target.

Every vertex stays within the threshold, so that a design that leaves nothing uncovered is as near to the target as the
threshold asks. Then the threshold is lowered. The energy of the annealing is the number of uncovered samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import PLACEMENT
from origami_lab.objectives.coverage_gain import cover_panels, new_coverage
from origami_lab.search.neighbourhood.bench import Bench
from origami_lab.search.neighbourhood.changes import unchanged
from origami_lab.search.neighbourhood.draft import COURSE, new_draft, read_design, write_design
from origami_lab.search.neighbourhood.ground import BEST, WORK
from origami_lab.search.neighbourhood.growth import PAUSED, Effort, grow
from origami_lab.search.neighbourhood.improving import (
    BETWEEN,
    CHANGE_DRAWS,
    FOUND,
    FOUND_FIRST,
    SHORT,
    Habits,
    improve,
)
from origami_lab.search.neighbourhood.one_run import NONE_YET, LocalRun, RunDesign
from origami_lab.search.neighbourhood.threshold import Aim, sheet_strays
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

if TYPE_CHECKING:
    from origami_lab.search.neighbourhood.method_numbers import MethodNumbers


class Covering:
    """How runs improve where the objective says what is to be covered."""

    def __init__(self, problem: Problem, draws: Draws, settings: MethodNumbers) -> None:
        evaluator = problem.evaluator
        self.problem, self.draws, self.settings = problem, draws, settings
        self.bench = Bench(problem, draws)
        self.target = evaluator.compiled_bound  # type: ignore[attr-defined]
        self.coverage = new_coverage(evaluator.compiled_cover)  # type: ignore[attr-defined]
        samples = len(self.coverage.order)
        self.spacing = settings.panel_spacing if getattr(evaluator, "panels_bound", False) else 0.0
        self.habits = Habits(
            *(settings.near, settings.parent, settings.shift, settings.flip, settings.more, settings.noise),
            *(settings.regrowths, settings.idle_changes, settings.temperature * samples),
        )
        self.draft, self.course = new_draft(self.bench.positions.states, samples), np.zeros(1, dtype=COURSE)
        self.course["budget"] = problem.budget
        narrow = self._effort(settings.places, settings.actions)
        self.efforts = narrow, self._effort(settings.wide_places, settings.wide_actions)

    def _effort(self, places: int, actions: int) -> Effort:
        s = self.settings
        return Effort(places, actions, s.failures, s.goal_failures, s.idle, s.source, s.noise, s.look)

    # --- what the portfolio asks for ---------------------------------------------------------------------------------

    @property
    def angles(self) -> range:
        return self.bench.angles

    def rank(self, run: LocalRun) -> tuple[float, int]:
        """Runs are compared by the threshold that they are at, then by what they leave uncovered; less is better."""
        left = NONE_YET if run.design is None else len(run.design.uncovered)
        return round(run.threshold, 6), min(run.lowest, left)

    def improve(self, run: LocalRun, until: int, patience: float = math.inf) -> None:
        """Go on with a run until so many interactions are played in all, or so many since its last success."""
        problem = self.problem
        run.last = problem.interactions
        self.take_up(run)
        while not problem.done and problem.interactions < until and problem.interactions - run.last < patience:
            why = self.go_on(run, min(until, run.last + patience))
            if why in (FOUND_FIRST, FOUND):
                before = int(self.course["before"][0])
                i, left = (BEST if why == FOUND else WORK), int(self.course["best"][0])
                uncovered = self.draft.best_uncovered if why == FOUND else self.coverage.order
                design = self.bench.read(i, uncovered[:left].copy())
                if why == FOUND_FIRST:
                    run.design = design
                self.judge(run, i, design)
                run.idle = run.idle + 1 if problem.interactions <= before + 1 else 0
                self.take_up(run)
            if run.idle >= self.settings.idle_changes and why != SHORT:
                break

    def relax(self, run: LocalRun) -> bool:
        """Set a run that came near its threshold a threshold that it has nearly reached; whether it did."""
        s = self.settings
        if run.lowest == 0 or not -run.value < s.relax * run.threshold:
            return False
        run.threshold, run.lowest = -run.value * s.shrink, NONE_YET
        return True

    # --- one run -----------------------------------------------------------------------------------------------------

    def take_up(self, run: LocalRun) -> None:
        """Hand a run to compiled code."""
        course = self.course
        write_design(run.design, self.draft, course)
        course["phase"], course["idle"], course["lowest"], course["laid"] = (
            BETWEEN,
            run.idle,
            run.lowest,
            self.bench.own,
        )
        self.bench.fold_to(run.angle)

    def go_on(self, run: LocalRun, stop: float) -> int:
        """Change the run's design until one is to be judged, or so many interactions are played; returns why.

        The run is as it is then, save for what is to be judged.
        """
        bench, draws, problem, course = self.bench, self.draws, self.problem, self.course
        aim, effort, why = self._aim(run), self.efforts[run.wide], SHORT
        line = bench.ground, aim, effort, self.habits, self.coverage, self.draft, course, float(stop)
        while why == SHORT and not problem.done:
            course["interactions"], course["looked"] = problem.interactions, 0
            why, draws.used = improve(*line, draws.block, draws.used)
            problem.places_evaluated += int(course["looked"][0]) if effort.look else 0
            bench.spend(int(course["interactions"][0]) - problem.interactions)
            if why == SHORT:
                draws.reserve(max(self._draws_of_a_move(effort), draws.available + 1))
        bench.own, run.idle = int(course["laid"][0]), int(course["idle"][0])
        if course["has_design"][0]:
            run.design = read_design(self.draft, course)
        return int(why)

    def _draws_of_a_move(self, effort: Effort) -> int:
        """Random numbers at hand for a change, or for a move of growth: no fewer than either asks for."""
        places = int(self.bench.room.lists.shape[1])
        return CHANGE_DRAWS + self.problem.game.rules.capacity + (effort.actions + 1) * places

    def judge(self, run: LocalRun, i: int, design: RunDesign) -> None:
        """Score a design that leaves less uncovered than any before; with nothing left lower the threshold."""
        bench, problem = self.bench, self.problem
        if problem.done:
            return
        rejected = problem.rejected
        problem.evaluator.clear(bench.positions.memos, i)
        # measuring surfaces is slow: only what is a new best is measured to the end
        value = bench.score(i, problem.best_value if self.spacing > 0.0 else -math.inf)
        if problem.rejected > rejected:
            return
        run.design, run.last = design, problem.interactions
        run.value, run.lowest = max(run.value, value), min(run.lowest, len(design.uncovered))
        if len(design.uncovered) == 0:
            run.threshold = min(-value, run.threshold) * self.settings.shrink
            self.lower(run, design)

    def lower(self, run: LocalRun, design: RunDesign) -> None:
        """Under a lower threshold: what strays goes, and the rest is grown."""
        bench, aim = self.bench, self._aim(run)
        run.lowest = NONE_YET
        bench.lay(unchanged(design), aim, run.angle, recheck=True)
        states = bench.positions.states
        if int(states["phase"][WORK]) == PLACEMENT or sheet_strays(states[WORK], bench.rules[0], aim, 0, 0):
            run.design = None
            return
        left = self.grow(run, aim, self.covered(aim), -1)
        run.design = bench.read(WORK, self._uncovered(left))

    # --- the sheet on the bench --------------------------------------------------------------------------------------

    def _aim(self, run: LocalRun) -> Aim:
        return Aim(self.target, run.angle, run.threshold, self.spacing)

    def _uncovered(self, count: int) -> NDArray[np.int32]:
        return self.coverage.order[:count].copy()

    def covered(self, aim: Aim) -> int:
        """Cover what the sheet comes near; returns how many samples are left."""
        s, r = self.bench.positions.states[WORK], self.bench.rules[0]
        return int(cover_panels(s, r, aim.angle, 0, self.coverage, aim.threshold, len(self.coverage.order)))

    def grow(self, run: LocalRun, aim: Aim, left: int, goal: int) -> int:
        """Grow the sheet; returns how many samples are left uncovered."""
        bench, draws, problem = self.bench, self.draws, self.problem
        effort, why, failed = self.efforts[run.wide], PAUSED, 0
        while why == PAUSED and not problem.done:
            draws.reserve(self._draws_of_a_move(effort))
            why, left, failed, draws.used, played, looked = grow(
                *(bench.positions.states, WORK, bench.rules, aim, effort, self.coverage, left, goal, failed),
                *(bench.room, draws.block, draws.used, problem.remaining),
            )
            problem.places_evaluated += looked if effort.look else 0
            bench.spend(played)
        return int(left)
