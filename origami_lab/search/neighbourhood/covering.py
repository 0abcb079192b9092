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
from origami_lab.search.neighbourhood.bench import BEST, REST, WORK, Bench
from origami_lab.search.neighbourhood.changes import (
    Change,
    cut,
    is_bare,
    move_near,
    parent_of,
    random_move,
    shift,
    unchanged,
)
from origami_lab.search.neighbourhood.growth import PAUSED, Effort, grow
from origami_lab.search.neighbourhood.one_run import NONE_YET, LocalRun, RunDesign
from origami_lab.search.neighbourhood.threshold import Aim, sheet_strays
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

if TYPE_CHECKING:
    from origami_lab.search.neighbourhood.method_numbers import MethodNumbers


class Covering:
    """How runs improve where the objective says what is to be covered."""

    def __init__(self, problem: Problem, draws: Draws, settings: MethodNumbers) -> None:
        evaluator, game = problem.evaluator, problem.game
        self.problem, self.draws, self.settings = problem, draws, settings
        self.bench = Bench(problem, draws)
        self.target = evaluator.compiled_bound  # type: ignore[attr-defined]
        self.coverage = new_coverage(evaluator.compiled_cover)  # type: ignore[attr-defined]
        self.points = self.coverage.samples.triangles[:, 0].copy()
        self.spacing = settings.panel_spacing if getattr(evaluator, "panels_bound", False) else 0.0
        self.temperature = settings.temperature * len(self.points)
        self.matrices = game.rules.record["matrices"][0][: game.symmetry.order].copy()
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
        while not problem.done and problem.interactions < until and problem.interactions - run.last < patience:
            before = problem.interactions
            if run.design is None:
                self.construct(run)
            else:
                self.vary(run)
            run.idle = run.idle + 1 if problem.interactions <= before + 1 else 0
            if run.idle >= self.settings.idle_changes:
                break

    def relax(self, run: LocalRun) -> bool:
        """Set a run that came near its threshold a threshold that it has nearly reached; whether it did."""
        s = self.settings
        if run.lowest == 0 or not -run.value < s.relax * run.threshold:
            return False
        run.threshold, run.lowest = -run.value * s.shrink, NONE_YET
        return True

    # --- one run -----------------------------------------------------------------------------------------------------

    def construct(self, run: LocalRun) -> None:
        """A first design: the start pattern, grown."""
        bench, problem = self.bench, self.problem
        before = problem.interactions
        aim = self._aim(run)
        bench.place(run.angle)
        states = bench.positions.states
        if problem.done or sheet_strays(states[WORK], bench.rules[0], aim, 0, 0):
            bench.spend(int(problem.interactions == before))
            return
        left = self.grow(run, aim, self.covered(aim), -1)
        if int(states["n_extensions"][WORK]) == 0 and left > 0:
            bench.spend(int(problem.interactions == before))
            return
        run.design = bench.read(WORK, self._uncovered(left))
        self.judge(run, WORK, run.design)

    def vary(self, run: LocalRun) -> None:
        """One change of the design, grown again a few times; the best of these is taken or left."""
        bench, design = self.bench, run.design
        assert design is not None
        aim, change = self._aim(run), self.change(design)
        if change is None:
            return
        bench.lay(change, aim, run.angle)
        rest = self.covered(aim)
        bench.copy(REST, WORK)
        best, uncovered = NONE_YET, self._uncovered(0)
        for again in range(self.settings.regrowths):
            if again > 0:
                bench.copy(WORK, REST)
            left = self.grow(run, aim, rest, len(design.uncovered))
            if left < best:
                best, uncovered = left, self._uncovered(left)
                bench.copy(BEST, WORK)
            if best == 0 or self.problem.done:
                break
        if best == 0 or best < run.lowest:
            self.judge(run, BEST, bench.read(BEST, uncovered))
        elif best <= len(design.uncovered) - self.temperature * math.log(max(self.draws.one(), 1e-300)):
            run.design = bench.read(BEST, uncovered)

    def change(self, design: RunDesign) -> Change | None:
        """What is changed: a move near something uncovered, or any, is cut away, or a vertex of it is shifted."""
        s, draws = self.settings, self.draws
        if is_bare(design):
            return unchanged(design)
        chosen = random_move(design, draws)
        if len(design.uncovered) and draws.one() < s.near:
            point = self.points[design.uncovered[draws.below(len(design.uncovered))]]
            chosen = move_near(design, point, self.matrices, s.noise, draws)
            if draws.one() < s.parent:
                chosen = int(parent_of(design.moves, chosen))
        if draws.one() < s.shift:
            return shift(design, chosen, self.problem.game.rules.half, s.flip, draws)
        return cut(design, chosen, s.more, draws)

    def judge(self, run: LocalRun, i: int, design: RunDesign) -> None:
        """Score a design that leaves less uncovered than any before; with nothing left lower the threshold."""
        bench, problem = self.bench, self.problem
        if problem.done:
            return
        rejected = problem.rejected
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
        return int(cover_panels(s, r, aim.angle, 0, self.coverage, aim.threshold, len(self.points)))

    def grow(self, run: LocalRun, aim: Aim, left: int, goal: int) -> int:
        """Grow the sheet; returns how many samples are left uncovered."""
        bench, draws, problem = self.bench, self.draws, self.problem
        effort, why, failed = self.efforts[run.wide], PAUSED, 0
        need = 8 + problem.game.rules.capacity + (effort.actions + 1) * bench.room.lists.shape[1]
        while why == PAUSED and not problem.done:
            draws.reserve(need)
            why, left, failed, draws.used, played, looked = grow(
                *(bench.positions.states, WORK, bench.rules, aim, effort, self.coverage, left, goal, failed),
                *(bench.room, draws.block, draws.used, problem.remaining),
            )
            problem.places_evaluated += looked if effort.look else 0
            bench.spend(played)
        return int(left)
