"""Searches whose kernels judge episodes are those that ask Python for each of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.objectives.bucket import BucketObjective
from origami_lab.objectives.chair import ChairObjective
from origami_lab.objectives.compiled_score import answered_by
from origami_lab.objectives.objective import Score
from origami_lab.objectives.packaging import PackagingObjective
from origami_lab.objectives.shape import ShapeEvaluator, ShapeObjective
from origami_lab.objectives.shape_score import best_shape, bound_shape, value_shape
from origami_lab.objectives.shelf import ShelfObjective
from origami_lab.objectives.table import TableObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from origami_lab.search.evolution import EvolutionarySearch
from origami_lab.search.mcts import MonteCarloTreeSearch
from origami_lab.search.problem import Outcome, Problem, Searcher
from origami_lab.search.random_search import RandomSearch
from origami_lab.targets.solids import bowl, cube, pyramid


class PlainEvaluator:
    """The same answers, from Python alone."""

    def __init__(self, inner: Any) -> None:
        self.inner = inner

    def __getattr__(self, name: str) -> Any:
        if name == "compiled_score":
            raise AttributeError(name)
        return getattr(self.inner, name)


class Plain:
    """An objective whose score is not offered to kernels."""

    def __init__(self, objective: Any) -> None:
        self.objective, self.report = objective, objective.report

    def bind(self, game: Game) -> Any:
        return PlainEvaluator(self.objective.bind(game))


SEARCHERS: dict[str, Callable[[], Searcher]] = {
    "rdm": RandomSearch,
    "dfts": lambda: DepthFirstSearch(restarts=4),
    "bfts": lambda: BreadthFirstSearch(restarts=4),
    "bfts-aspiring": lambda: BreadthFirstSearch(restarts=4, aspiration=1.0),
    "evo": lambda: EvolutionarySearch(population=40),
    "mcts": lambda: MonteCarloTreeSearch(simulations=20),
    "mcts-drawn": lambda: MonteCarloTreeSearch(simulations=30, greedy=False, unvisited=0.0),
}
TASKS: dict[str, tuple[Callable[[], Game], Callable[[], Any]]] = {
    "cube": (lambda: Game(9, "xy", Square(1), max_crease_length=2), lambda: ShapeObjective(cube())),
    "sampled": (lambda: Game(9, "xy", Square(1)), lambda: ShapeObjective(cube(), "sampled", samples=200)),
    # an episode that ends inside a move brings the penalty; some designs are refused
    "penalised": (
        lambda: Game(9, "none", Square(1), straight_sectors=False, stuck="penalise"),
        lambda: ShapeObjective(pyramid(), compactness=0.1),
    ),
    "fixed angle": (
        lambda: Game(13, "y", Crease("choose"), max_crease_length=2.9, driving_angle_fixed=60.0),
        lambda: ShapeObjective(bowl()),
    ),
    # scores 0 until there is one, and is bounded by its own kernel
    "shelf": (lambda: Game(13, "xy", Square(), source_action=False), ShelfObjective),
}


ABSTRACT = {each.__name__: each for each in (BucketObjective, ChairObjective, PackagingObjective, TableObjective)}


def outcome(task: str, name: str, seed: int, budget: int, wrap: Callable[[Any], Any] = lambda each: each) -> Outcome:
    make, objective = TASKS[task]
    problem = Problem(make(), wrap(objective()), budget)
    SEARCHERS[name]().search(problem, np.random.default_rng(seed))
    return problem.outcome()


@pytest.mark.parametrize("name", SEARCHERS)
@pytest.mark.parametrize("task", TASKS)
def test_kernels_judge_as_python_does(task: str, name: str) -> None:
    """The same designs by the same improvements, and as many episodes, wherever the budget ends the search."""
    for seed, budget in ((0, 5_000), (1, 2_311)):
        theirs = outcome(task, name, seed, budget, Plain)
        assert outcome(task, name, seed, budget) == theirs
        assert theirs.episodes > 10


@pytest.mark.parametrize("name", ABSTRACT)
def test_so_do_the_kernels_of_each_abstract_objective(name: str) -> None:
    found = []
    for wrap in (lambda each: each, Plain):
        problem = Problem(Game(13, "xy", Square("choose")), wrap(ABSTRACT[name]()), 4_000)
        RandomSearch().search(problem, np.random.default_rng(0))
        found.append(problem.outcome())
    assert found[0] == found[1]
    assert found[0].improvements


def test_the_episodes_that_python_hears_of_are_improvements_or_refused() -> None:
    problem = Problem(TASKS["cube"][0](), ShapeObjective(cube()), 20_000)
    scored = []
    finish = problem.finish
    problem.finish = lambda *line, **options: scored.append(finish(*line, **options))  # type: ignore[method-assign]
    RandomSearch().search(problem, np.random.default_rng(0))
    assert len(scored) == len(problem.improvements) + problem.rejected
    assert problem.episodes > 20 * len(scored)


class Doubled(ShapeEvaluator):
    """A user's own score, on top of ours."""

    def score(self, *line: Any) -> Score:
        score = super().score(*line[:3], -np.inf)
        return Score(2.0 * score.value, score.angle)


class DoubledObjective(ShapeObjective):
    def bind(self, game: Game) -> Doubled:
        return Doubled(self, game)


@pytest.mark.parametrize("name", ["rdm", "dfts", "evo", "mcts"])
def test_what_overrides_a_score_is_asked(name: str) -> None:
    game = TASKS["cube"][0]
    problem = Problem(game(), DoubledObjective(cube()), 3_000)
    assert problem.compiled_score is None
    SEARCHERS[name]().search(problem, np.random.default_rng(0))
    found = problem.outcome()
    single = ShapeObjective(cube()).report(game(), found.actions, found.angle)
    assert found.value == pytest.approx(2.0 * single["return_vertex"])
    evaluator = ShapeObjective(cube()).bind(game())
    assert evaluator.compiled_score is not None
    evaluator.score = Doubled(ShapeObjective(cube()), game()).score  # type: ignore[method-assign]
    assert evaluator.compiled_score is None


@pytest.mark.parametrize("distance", ["surface", "mean"])
def test_what_python_measures_has_no_compiled_score(distance: Any) -> None:
    assert ShapeObjective(cube(), distance).bind(TASKS["cube"][0]()).compiled_score is None


def test_only_the_packages_classes_have_compiled_scores() -> None:
    class Own(NamedTuple):
        number: float

    with pytest.raises(ValueError, match="only classes of the package"):
        answered_by(bound_shape, best_shape, value_shape)(Own)
