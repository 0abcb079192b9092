"""Branch and bound on the game tree: DFTS and BFTS (paper, appendix A.2 and A.3), one loop in two orders.

Both look at no more than ten children of a node, sampled without replacement, and leave a branch as soon as its
bound is not above the best return so far. DFTS goes into each child at once. BFTS first plays all its children,
one interaction each, then goes into the best of them and backs up to the second best: it is no queue.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from origami_lab.errors import InputError
from origami_lab.search.draws import Draws
from origami_lab.search.problem import Actions, Positions, Problem

_DEPTH = 64
"""Positions that a search starts with: one for each action on the way to the current one."""


@dataclass
class _Node:
    """An open node: what is left to do there. Its position is the one at its depth."""

    bound: float
    queue: list[tuple[float, int]] = field(default_factory=list)
    """Children still to enter, the next one last: their bound (DFTS: the node's own) and action."""


class TreeSearch:
    """Depth-first branch and bound with limited branching; subclasses order the children.

    Parameters
    ----------
    children
        Children looked at per node.
    restarts
        Searches that share the budget; a tree that is exhausted early starts anew, too. The paper's number is 10;
        200 shorter searches lose less to a bad first decision (docs/how-it-works.md has the comparison).
    """

    def __init__(self, children: int = 10, restarts: int = 200) -> None:
        if children < 1:
            raise InputError("search.children", children, "must be at least 1")
        if restarts < 1:
            raise InputError("search.restarts", restarts, "must be at least 1")
        self.children, self.restarts = children, restarts

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws = Draws(rng)
        positions = problem.new_positions(_DEPTH)
        share = -(-problem.budget // self.restarts)
        while not problem.done:
            self._search_tree(problem, draws, positions, problem.interactions + share)

    def _open(
        self, problem: Problem, draws: Draws, positions: Positions, depth: int, bound: float, legal: Actions
    ) -> _Node:
        raise NotImplementedError

    def _enter(
        self, problem: Problem, positions: Positions, depth: int, node: _Node, child: tuple[float, int]
    ) -> tuple[float, Actions] | None:
        raise NotImplementedError

    def _search_tree(self, problem: Problem, draws: Draws, positions: Positions, until: int) -> None:
        legal = problem.clear(positions, 0)
        path = [self._open(problem, draws, positions, 0, math.inf, legal)]
        while path and not problem.done and problem.interactions < until:
            node = path[-1]
            if not node.queue or node.bound <= problem.best_value:
                path.pop()
                continue
            if len(path) + 1 >= len(positions):
                problem.grow(positions)
            child = node.queue.pop()
            if child[0] <= problem.best_value:
                continue
            rejected = problem.rejected
            entered = self._enter(problem, positions, len(path) - 1, node, child)
            if entered is not None:
                bound, legal = entered
                path.append(self._open(problem, draws, positions, len(path), bound, legal))
            if problem.rejected > rejected:
                self._trim_path(problem, positions, path)

    def _trim_path(self, problem: Problem, positions: Positions, path: list[_Node]) -> None:
        """After a design was refused for its dense motion: bound the nodes that led to it by theirs.

        Without this the search would go on completing the same colliding motion in a thousand ways.
        """
        for depth in range(len(path) - 1, -1, -1):
            if not problem.trim(positions, depth):
                return  # what came before is free, too
            path[depth].bound = problem.bound(positions, depth)

    def _sample(self, draws: Draws, legal: Actions) -> list[int]:
        """Up to ``children`` legal actions in random order."""
        pool = legal.tolist()
        chosen = []
        for _ in range(min(self.children, len(pool))):
            i = draws.below(len(pool))
            chosen.append(pool[i])
            pool[i] = pool[-1]
            pool.pop()
        return chosen

    def _try(
        self, problem: Problem, positions: Positions, depth: int, bound: float, action: int
    ) -> tuple[float, Actions] | None:
        """Play a child of the node at ``depth``: its bound and legal actions, or None if the episode ended."""
        legal, complete = problem.branch(positions, depth + 1, depth, action)
        if len(legal) == 0:
            problem.finish(positions, depth + 1)
            return None
        if complete:
            bound = problem.bound(positions, depth + 1)
        return bound, legal


class DepthFirstSearch(TreeSearch):
    """DFTS: into each new child at once."""

    def _open(
        self, problem: Problem, draws: Draws, positions: Positions, depth: int, bound: float, legal: Actions
    ) -> _Node:
        return _Node(bound, [(bound, action) for action in self._sample(draws, legal)])

    def _enter(
        self, problem: Problem, positions: Positions, depth: int, node: _Node, child: tuple[float, int]
    ) -> tuple[float, Actions] | None:
        entered = self._try(problem, positions, depth, node.bound, child[1])
        return entered if entered is not None and entered[0] > problem.best_value else None


class BreadthFirstSearch(TreeSearch):
    """BFTS: the most promising of the children first."""

    def _open(
        self, problem: Problem, draws: Draws, positions: Positions, depth: int, bound: float, legal: Actions
    ) -> _Node:
        queue = []
        for action in self._sample(draws, legal):
            if problem.done:
                break
            tried = self._try(problem, positions, depth, bound, action)
            if tried is not None and tried[0] > problem.best_value:
                queue.append((tried[0], action))
        queue.reverse()  # among equals, the first one sampled is entered first
        queue.sort(key=lambda child: child[0])
        return _Node(bound, queue)

    def _enter(
        self, problem: Problem, positions: Positions, depth: int, node: _Node, child: tuple[float, int]
    ) -> tuple[float, Actions] | None:
        legal, _ = problem.branch(positions, depth + 1, depth, child[1], count=False)
        return min(child[0], node.bound), legal
