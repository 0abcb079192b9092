"""Branch and bound on the game tree: DFTS and BFTS (paper, appendix A.2 and A.3), one loop in two orders.

Both look at no more than ten children of a node, sampled without replacement, and leave a branch as soon as its
bound is not above the best return so far. DFTS goes into each child at once. BFTS first plays all its children,
one interaction each, then goes into the best of them and backs up to the second best: it is no queue.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from origami_lab.checks import Flag, Number, Whole, checked_arguments
from origami_lab.game.kernels.undo import note_dtype, step_back, step_noted
from origami_lab.search.branch_and_bound_kernel import (
    CONTINUE,
    ENDED,
    EXHAUSTED,
    GIVEN,
    START,
    TAKE_BACK,
    UNBOUNDED,
    walk,
)
from origami_lab.search.problem import Positions, Problem
from origami_lab.search.random_stream import Draws

_SHORTEST = 100
"""Interactions of a tree at least: much shorter ones do not come to the end of an episode on large boards."""
_DEPTH = 64
"""Depth that a tree has room for at first."""
_PACE = 4096
"""Interactions that are played at most between two looks at the clock."""


class TreeSearch:
    """Depth-first branch and bound with limited branching; subclasses say in which order.

    Parameters
    ----------
    children
        Children looked at per node.
    restarts
        Searches that share the budget, fewer where they would be shorter than 100 interactions; a tree that is
        exhausted early starts anew, too. The paper's number is 10; 200 shorter searches lose less to a bad first
        decision (docs/how-it-works.md has the comparison).
    aspiration
        A distance to be reached, in the objective's unit: branches whose bound is not above its negative are left from
        the beginning. None for the best return so far alone.
    inside_moves
        Whether the places of outer children bound a move before it is complete. It says nothing of objectives other
        than target shapes.
    """

    best_first: bool

    @checked_arguments("search")
    def __init__(
        self,
        children: Annotated[int, Whole(1, 10**9)] = 10,
        restarts: Annotated[int, Whole(1, 10**9)] = 200,
        aspiration: Annotated[float | None, Number(-1e9, 1e9)] = None,
        inside_moves: Annotated[bool, Flag()] = False,
    ) -> None:
        self.children, self.restarts = children, restarts
        self.aspiration, self.inside_moves = aspiration, inside_moves

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        tree = _Tree(problem, Draws(rng), self)
        share = max(-(-problem.budget // self.restarts), _SHORTEST)
        while not problem.done:
            tree.search(problem.interactions + share)


class DepthFirstSearch(TreeSearch):
    """DFTS: into each new child at once."""

    best_first = False


class BreadthFirstSearch(TreeSearch):
    """BFTS: the most promising of the children first."""

    best_first = True


class _Tree:
    """A tree being searched: one state, the path to it, and the nodes on that path."""

    def __init__(self, problem: Problem, draws: Draws, settings: TreeSearch) -> None:
        game, evaluator = problem.game, problem.evaluator
        self.problem, self.draws, self.best_first = problem, draws, settings.best_first
        self.inside_moves, children = settings.inside_moves, min(settings.children, game.rules.max_legal)
        self.floor = -math.inf if settings.aspiration is None else -settings.aspiration
        """Bounds must be above this, too."""
        self.states = game.new_states(1)
        self.target = getattr(evaluator, "compiled_bound", None)
        self.legal = np.empty(game.rules.max_legal, dtype=np.int32)
        self.memos = evaluator.new_memos(_DEPTH)
        self.notes = np.empty(_DEPTH, dtype=note_dtype(len(game.angles)))
        self.counters = np.empty((_DEPTH, 3), dtype=np.int64)
        self.children = np.empty((_DEPTH, children), dtype=np.int32)
        self.bounds = np.empty((_DEPTH, children + 1))

    def search(self, until: int) -> None:
        """Search one tree from where episodes begin, until so many interactions are played or it is exhausted."""
        problem, draws, evaluator = self.problem, self.draws, self.problem.evaluator
        why, depth, how, given = EXHAUSTED, 0, START, 0.0
        problem.game.clear(self.states, 0)
        evaluator.clear(self.memos, 0)
        while not problem.done and problem.interactions < until:
            if depth + 2 >= len(self.memos):
                self._grow()
            draws.reserve(self.children.shape[1])
            line = self.states, problem.game.rules.record, self.notes, self.memos, self.legal
            tree = self.counters, self.children, self.bounds, self.best_first
            limit = min(until, problem.budget, problem.interactions + _PACE) - problem.interactions
            # a floor above the best return measures no further than to itself
            bounding = (
                self.target,
                self.inside_moves,
                None if problem.best_value < self.floor else problem.compiled_score,
            )
            why, depth, used, played, ended = walk(
                *line, *tree, *bounding, draws.block, draws.used, depth, how, given, self.best, limit
            )
            draws.used = used
            problem.spend(played)
            problem.episodes += ended
            how = CONTINUE
            if why == EXHAUSTED:
                return
            if why == UNBOUNDED:
                how, given = GIVEN, problem.bound(self._position(depth + 1), 0)
            elif why == ENDED:
                how = TAKE_BACK
                rejected = problem.rejected
                if problem.best_value < self.floor:
                    # where a driving angle cannot come below the aspiration its distance was measured no further
                    evaluator.clear(self.memos, depth + 1)
                problem.finish(self._position(depth + 1), 0)
                if problem.rejected > rejected:
                    step_back(self.states, 0, self.notes, depth)
                    how, depth = CONTINUE, self._trim_path(depth)

    @property
    def best(self) -> float:
        """What a bound must be above."""
        return max(self.problem.best_value, self.floor)

    def _position(self, depth: int) -> Positions:
        """The position on the board, which is at this depth."""
        return Positions(self.states, self.memos[depth : depth + 1])

    def _trim_path(self, depth: int) -> int:
        """Bound the nodes that led to a design whose dense motion was refused.

        Without this the search would go on completing the same colliding motion in a thousand ways. Returns the depth
        of the deepest node that still has a promise; the board is there.
        """
        problem, states = self.problem, self.states
        count = int(states["n_actions"][0])
        actions = states["actions"][0][count - depth : count].copy()  # the start pattern's come before
        reach: list[int] = []
        top = depth
        while problem.trim(self._position(top), 0):
            self.bounds[top, -1] = problem.bound(self._position(top), 0)
            reach.append(int(states["reach"][0]))
            if top == 0:
                break
            top -= 1
            step_back(states, 0, self.notes, top)
        # forward again, with the shorter reach
        if len(reach) > depth:
            reach.pop()
        while reach and self.bounds[top + 1, -1] > self.best:
            step_noted(states, 0, problem.game.rules.record, int(actions[top]), self.notes, top, self.legal)
            top += 1
            states["reach"][0] = reach.pop()
        return top

    def _grow(self) -> None:
        """Room for twice the depth."""
        size = len(self.memos)
        memos = self.problem.evaluator.new_memos(2 * size)
        memos[:size] = self.memos
        self.memos = memos
        for name in ("notes", "counters", "children", "bounds"):
            rows = getattr(self, name)
            setattr(self, name, np.concatenate([rows, np.empty_like(rows)]))
