"""The oracle of compiled changes: a run that is improved step by step, each step a call from Python.

The design is laid and grown by the bench and by :meth:`Covering.grow`, which have tests of their own; what is changed,
kept and scored is decided here, in the order of the draws that the search documents.
"""

from __future__ import annotations

import math

import numpy as np

from origami_lab.game.kernels.state import PLACEMENT
from origami_lab.game.move_table import EXTEND, SOURCE
from origami_lab.search.neighbourhood.changes import Change, placements, random_move, unchanged
from origami_lab.search.neighbourhood.covering import Covering
from origami_lab.search.neighbourhood.ground import BEST, REST, WORK
from origami_lab.search.neighbourhood.one_run import NONE_YET, LocalRun, RunDesign
from origami_lab.search.neighbourhood.threshold import sheet_strays


class StepByStep(Covering):
    """Runs that improve as those of :class:`Covering` do, without its kernel for whole changes."""

    def improve(self, run: LocalRun, until: int, patience: float = math.inf) -> None:
        problem = self.problem
        run.last = problem.interactions
        while not problem.done and problem.interactions < until and problem.interactions - run.last < patience:
            before = problem.interactions
            if run.design is None:
                self.construct(run)
            else:
                self.vary(run, run.design)
            run.idle = run.idle + 1 if problem.interactions <= before + 1 else 0
            if run.idle >= self.settings.idle_changes:
                break

    def construct(self, run: LocalRun) -> None:
        bench, problem, aim = self.bench, self.problem, self._aim(run)
        before = problem.interactions
        begun = bench.place(run.angle)
        sheet = bench.positions.states[WORK]
        if begun and not sheet_strays(sheet, bench.rules[0], aim, 0, 0):
            assert int(sheet["phase"]) != PLACEMENT
            left = self.grow(run, aim, self.covered(aim), -1)
            if int(sheet["n_extensions"]) > 0 or left == 0:
                run.design = bench.read(WORK, self.coverage.order[:left].copy())
                self.judge(run, WORK, run.design)
                return
        bench.spend(int(problem.interactions == before))

    def vary(self, run: LocalRun, design: RunDesign) -> None:
        bench, aim, change = self.bench, self._aim(run), self.change(design)
        if change is None:
            return
        bench.lay(change, aim, run.angle)
        rest = self.covered(aim)
        bench.copy(REST, WORK)
        outcomes: list[int] = []
        while len(outcomes) < self.settings.regrowths and not (outcomes and (min(outcomes) == 0 or self.problem.done)):
            bench.copy(WORK, REST)
            left = self.grow(run, aim, rest, len(design.uncovered))
            if left < min(outcomes, default=NONE_YET):
                bench.copy(BEST, WORK)
                uncovered = self.coverage.order[:left].copy()
            outcomes.append(left)
        best = min(outcomes)
        if best == 0 or best < run.lowest:
            self.judge(run, BEST, bench.read(BEST, uncovered))
        else:
            temperature = self.settings.temperature * len(self.coverage.order)
            if best <= len(design.uncovered) - temperature * math.log(max(self.draws.one(), 1e-300)):
                run.design = bench.read(BEST, uncovered)

    def change(self, design: RunDesign) -> Change | None:
        """What is changed, decided by dictionaries and lists."""
        s, draws, moves = self.settings, self.draws, design.moves
        count, placed = len(moves), placements(moves)
        if count == placed:
            return unchanged(design)
        chosen = random_move(design, draws)
        if len(design.uncovered) and draws.one() < s.near:
            point = self.coverage.samples.triangles[design.uncovered[draws.below(len(design.uncovered))], 0]
            far = [self.away(design, m, point) + s.noise * draws.one() for m in range(count)]
            chosen = min(range(placed, count), key=far.__getitem__)
            if draws.one() < s.parent:
                leaf = int(moves["leaf"][chosen])
                parents = [m for m in range(chosen) if moves["kind"][m] == EXTEND and leaf in self.children(design, m)]
                chosen = parents[-1] if parents else chosen
        goes = np.zeros(count, dtype=np.int8)
        if not draws.one() < s.shift:
            goes[chosen] = 1
            while draws.one() < s.more:
                goes[random_move(design, draws)] = 1
            return Change(design, goes, goes.tolist().index(1))
        if moves["kind"][chosen] != EXTEND:
            return None
        new = RunDesign(moves.copy(), design.points.copy(), design.places, design.own, design.uncovered)
        if draws.one() < s.flip:
            new.moves["sign"][chosen] *= -1
            return Change(new, goes, chosen)
        children = self.children(design, chosen)
        v = children[draws.below(len(children))]
        around = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1) if (x, y) != (0, 0)]
        new.points[v] += around[draws.below(8)]
        if v < design.own or (np.abs(new.points[v]) > self.problem.game.rules.half).any():
            return None
        names = [{int(moves["leaf"][m]), *self.children(design, m)} for m in range(count)]
        return Change(new, goes, next(m for m in range(count) if v in names[m]))

    @staticmethod
    def children(design: RunDesign, m: int) -> list[int]:
        row = design.moves[m]
        return [int(row[name]) for name in ("first", "second", "middle") if row[name] >= 0]

    def away(self, design: RunDesign, m: int, point: np.ndarray) -> float:
        """From a point to the nearest image of where a move lies."""
        row = design.moves[m]
        place = design.places[row["leaf"] if row["kind"] == SOURCE else row["middle"]]
        offsets = [(*(matrix @ place[:2] - point[:2]), place[2] - point[2]) for matrix in self.matrices]
        return min(math.hypot(*offset) for offset in offsets)

    @property
    def matrices(self) -> list[np.ndarray]:
        return list(self.problem.game.symmetry.matrices)
