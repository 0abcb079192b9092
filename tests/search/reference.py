"""DFTS and BFTS in plain Python, with a copy of the position at every depth: what the compiled walk must agree with."""

from __future__ import annotations

import math

import numpy as np

from origami_lab.game.kernels.boundary import NEXT, PREV, near_side
from origami_lab.game.kernels.extension import outer_place
from origami_lab.game.kernels.state import SECOND, THIRD
from origami_lab.geometry.bvh import distances
from origami_lab.search.problem import Actions, Positions, Problem
from origami_lab.search.random_stream import Draws


class ReferenceTreeSearch:
    """Branch and bound as the paper's appendix describes it, with one restart after another."""

    def __init__(
        self, best_first: bool, children: int = 10, aspiration: float = math.inf, inside_moves: bool = False
    ) -> None:
        self.best_first, self.children = best_first, children
        self.floor, self.inside_moves = -aspiration, inside_moves
        self.cut_inside = 0
        """Branches that a bound inside a move has closed."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws = Draws(rng)
        positions = problem.new_positions(64)
        while not problem.done:
            own = [math.inf]
            self._visit(problem, draws, positions, own, problem.clear(positions, 0))

    def _visit(self, problem: Problem, draws: Draws, positions: Positions, own: list[float], legal: Actions) -> None:
        """Search below the position at depth ``len(own) - 1``; own[d] bounds the node at depth d."""
        depth = len(own) - 1
        if depth + 2 > len(positions):
            problem.grow(positions)
        tried: list[tuple[float, int]] = []
        for action in self._sample(draws, legal):
            if problem.done or own[depth] <= max(problem.best_value, self.floor):
                return
            below, complete = problem.branch(positions, depth + 1, depth, action)
            if len(below) == 0:
                rejected = problem.rejected
                problem.finish(positions, depth + 1)
                if problem.rejected > rejected:
                    self._trim(problem, positions, own)
                continue
            bound = problem.bound(positions, depth + 1) if complete else own[depth]
            if self.inside_moves and not complete:
                bound = min(bound, self._inside(problem, positions, depth + 1))
                self.cut_inside += bound <= max(problem.best_value, self.floor) < own[depth]
            if bound <= max(problem.best_value, self.floor):
                continue
            if self.best_first:
                tried.append((bound, action))
            else:
                self._below(problem, draws, positions, own, bound, below)
        for bound, action in sorted(tried, key=lambda child: -child[0]):
            if problem.done or min(bound, own[depth]) <= max(problem.best_value, self.floor):
                return
            below, _ = problem.branch(positions, depth + 1, depth, action, count=False)
            self._below(problem, draws, positions, own, min(bound, own[depth]), below)

    def _inside(self, problem: Problem, positions: Positions, i: int) -> float:
        """The bound of the sheet with the outer child that was chosen last as a vertex, for a symmetric target."""
        s, r, bvh = positions.states[i], problem.game.rules.record[0], problem.objective.target.bvh
        phase, stray = int(s["phase"]), positions.memos[i]["stray"]
        if phase not in (SECOND, THIRD):
            return math.inf
        on_axis = int(s["axis"][s["selected"]]) > 0
        side = near_side(s, r, s["selected"]) if on_axis else PREV if phase == SECOND else NEXT
        name = "first" if side == PREV else "second"
        x, y = int(s[f"{name}_x"]), int(s[f"{name}_y"])
        best = math.inf
        for k in range(problem.game.first_angle, int(s["reach"])):
            place = np.array([outer_place(s, r, k, side, x, y)])
            best = min(best, max(float(stray[k]), float(distances(bvh, place)[0])))
        return -best

    def _sample(self, draws: Draws, legal: Actions) -> list[int]:
        """Up to ``children`` legal actions, without replacement, each with one number of the stream."""
        pool = legal.tolist()
        chosen = []
        for _ in range(min(self.children, len(pool))):
            draws.reserve(1)
            i = int(draws.block[draws.used] * len(pool))
            draws.use(1)
            chosen.append(pool[i])
            pool[i] = pool[-1]
            pool.pop()
        return chosen

    def _below(
        self, problem: Problem, draws: Draws, positions: Positions, own: list[float], bound: float, legal: Actions
    ) -> None:
        own.append(bound)
        self._visit(problem, draws, positions, own, legal)
        own.pop()

    def _trim(self, problem: Problem, positions: Positions, own: list[float]) -> None:
        """Bound the nodes on the way to a refused design by what they can really reach."""
        for depth in range(len(own) - 1, -1, -1):
            if not problem.trim(positions, depth):
                return
            own[depth] = problem.bound(positions, depth)
