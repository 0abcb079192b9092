"""The compiled walk of DFTS and BFTS against the plain Python one that copies every position."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.objective import Score
from origami_lab.objectives.shape import ShapeEvaluator, ShapeObjective
from origami_lab.search import branch_and_bound as tree
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from origami_lab.search.problem import Problem
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target
from tests.search.reference import ReferenceTreeSearch


class AskingEvaluator:
    """The shape objective's evaluator, but the walk has to ask it for every bound."""

    compiled_bound = None

    def __init__(self, inner: ShapeEvaluator) -> None:
        self.inner, self.asked = inner, 0
        self.new_memos, self.clear, self.score = inner.new_memos, inner.clear, inner.score

    def bound(self, *arguments: Any) -> float:
        self.asked += 1
        return self.inner.bound(*arguments)


class AskingObjective(ShapeObjective):
    def bind(self, game: Game) -> Any:
        return AskingEvaluator(super().bind(game))


class Tall:
    """Highest point, with no bound at all."""

    def score(self, sheet: Any) -> Score:
        heights = sheet.points[: sheet.reach, :, 2].max(axis=1)
        return Score(float(heights.max()), int(heights.argmax()))


GAMES: dict[str, tuple[Callable[[], Game], Callable[[], Target]]] = {
    "bowl": (lambda: Game(25, "xyd", Square("choose"), max_crease_length=2.9), bowl),
    "cube": (lambda: Game(9, "xy", Square(1), max_crease_length=2), cube),
    # of these games some designs are refused
    "pyramid": (lambda: Game(9, "none", Square(1), straight_sectors=False), pyramid),
}


def outcome(make: Callable[[], Game], objective: Any, searcher: Any, seed: int, budget: int) -> tuple[Any, Problem]:
    problem = Problem(make(), objective, budget)
    searcher.search(problem, np.random.default_rng(seed))
    return problem.outcome(), problem


@pytest.mark.slow
@pytest.mark.parametrize("best_first", [False, True])
@pytest.mark.parametrize("name", GAMES)
def test_the_walk_is_the_search_it_claims_to_be(name: str, best_first: bool) -> None:
    make, target = GAMES[name]
    method = BreadthFirstSearch if best_first else DepthFirstSearch
    rejected = 0
    for seed in range(3):
        theirs, _ = outcome(make, ShapeObjective(target()), ReferenceTreeSearch(best_first), seed, 6000)
        ours, _ = outcome(make, ShapeObjective(target()), method(restarts=1), seed, 6000)
        asked, problem = outcome(make, AskingObjective(target()), method(restarts=1), seed, 6000)
        assert ours == theirs
        assert asked == theirs
        assert problem.evaluator.asked > 0  # type: ignore[attr-defined]
        rejected += ours.rejected
    if name == "pyramid":
        assert rejected > 0  # designs were refused, and the path to them trimmed


@pytest.mark.parametrize("best_first", [False, True])
def test_the_walk_with_an_objective_that_has_no_bound(best_first: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is pruned; lines of play grow deeper than the room that is made for them at first."""
    monkeypatch.setattr(tree, "_DEPTH", 4)
    method = BreadthFirstSearch if best_first else DepthFirstSearch
    make = GAMES["cube"][0]
    theirs, _ = outcome(make, Tall(), ReferenceTreeSearch(best_first, children=3), 0, 1500)
    ours, problem = outcome(make, Tall(), method(children=3, restarts=1), 0, 1500)
    assert ours == theirs
    assert ours.value > 0
    assert problem.interactions == 1500
    assert len(ours.actions) > 4


@pytest.mark.parametrize("best_first", [False, True])
def test_an_aspiration_and_bounds_inside_moves_leave_branches_sooner(best_first: bool) -> None:
    """As the plain search does that measures every vertex and every chosen child from scratch."""
    method = BreadthFirstSearch if best_first else DepthFirstSearch
    cut = scored = 0
    for seed in range(1):
        options = {"aspiration": 2.47, "inside_moves": True}  # no distance on the grid, which rounding could decide
        reference = ReferenceTreeSearch(best_first, **options)
        theirs, _ = outcome(GAMES["bowl"][0], ShapeObjective(bowl()), reference, seed, 1200)
        ours, _ = outcome(GAMES["bowl"][0], ShapeObjective(bowl()), method(restarts=1, **options), seed, 1200)
        assert ours == theirs
        cut += reference.cut_inside
        scored += ours.episodes
    assert cut > 20
    assert scored > 5
