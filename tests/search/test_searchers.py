"""The contract that every searcher keeps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.moves import Lay
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start
from origami_lab.objectives.bucket import BucketObjective
from origami_lab.objectives.objective import Score, bind
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch, TreeSearch
from origami_lab.search.dense_check import certified_reach
from origami_lab.search.evolution import EvolutionarySearch
from origami_lab.search.mcts import MonteCarloTreeSearch
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.ppo import ProximalPolicyOptimization
from origami_lab.search.problem import Problem, SearchEnded, Searcher
from origami_lab.search.random_search import RandomSearch
from origami_lab.targets.solids import bowl, cube

SEARCHERS: dict[str, Callable[[], Searcher]] = {
    "rdm": RandomSearch,
    "dfts": lambda: DepthFirstSearch(restarts=4),
    "bfts": lambda: BreadthFirstSearch(restarts=4),
    "evo": lambda: EvolutionarySearch(population=16),
    "mcts": lambda: MonteCarloTreeSearch(simulations=20),
    "lns": NeighbourhoodSearch,
    "ppo": lambda: ProximalPolicyOptimization(batch=500, games=5, layers=[32], epochs=2),
}


@pytest.fixture(params=SEARCHERS)
def searcher(request: pytest.FixtureRequest) -> Searcher:
    if request.param == "ppo":
        pytest.importorskip("sb3_contrib", reason="needs the extra ppo")
    return SEARCHERS[request.param]()


def search(searcher: Searcher, problem: Problem, seed: int) -> None:
    """As a run does it: a searcher may play until it is told that the search has ended."""
    with suppress(SearchEnded):
        searcher.search(problem, np.random.default_rng(seed))


def cube_problem(budget: int, **options: object) -> Problem:
    return Problem(Game(9, "xy", Square(1), max_crease_length=2), ShapeObjective(cube()), budget, **options)


def test_same_seed_same_bits(searcher: Searcher) -> None:
    outcomes = []
    for _ in range(2):
        problem = cube_problem(3000)
        search(searcher, problem, 5)
        outcomes.append(problem.outcome())
    assert outcomes[0] == outcomes[1]
    other = cube_problem(3000)
    search(searcher, other, 6)
    assert other.outcome() != outcomes[0]


@pytest.mark.parametrize("budget", [1, 7, 1001])
def test_the_budget_is_spent_exactly(searcher: Searcher, budget: int) -> None:
    problem = cube_problem(budget)
    search(searcher, problem, 0)
    assert problem.outcome().interactions == budget


def test_a_smaller_budget_finds_what_a_larger_one_finds_first(searcher: Searcher) -> None:
    """Except where the budget is shared out: shorter restarts are other searches."""
    budgets = (2000, 4000)
    found = []
    for budget in budgets:
        problem = cube_problem(budget)
        if isinstance(searcher, TreeSearch):
            searcher = type(searcher)(restarts=budget // 1000)
        if isinstance(searcher, NeighbourhoodSearch):
            searcher = NeighbourhoodSearch(run=100 / budget)
        search(searcher, problem, 4)
        found.append(problem.outcome())
    early = [improvement for improvement in found[1].improvements if improvement.interaction <= budgets[0]]
    assert list(found[0].improvements) == early
    assert early


def test_a_goal_ends_the_search_where_it_is_reached(searcher: Searcher) -> None:
    whole = cube_problem(3000)
    search(searcher, whole, 5)
    for goal in (whole.improvements[0].value, whole.improvements[len(whole.improvements) // 2].value):
        problem = cube_problem(3000, goal=goal)
        with suppress(SearchEnded):
            search(searcher, problem, 5)
        reached = next(number for number, step in enumerate(whole.improvements) if step.value >= goal)
        assert problem.done
        assert problem.improvements[: reached + 1] == whole.improvements[: reached + 1]
        assert problem.interactions == whole.improvements[reached].interaction


def test_a_design_that_is_refused_at_the_goal_does_not_end_the_search(searcher: Searcher) -> None:
    whole = cube_problem(3000)
    search(searcher, whole, 5)
    asked: list[tuple[int, ...]] = []

    def vets(actions: Sequence[int], angle: int) -> bool:
        asked.append(tuple(actions))
        return len(asked) > 2

    problem = cube_problem(3000, goal=whole.improvements[len(whole.improvements) // 2].value, vets=vets)
    with suppress(SearchEnded):
        search(searcher, problem, 5)
    assert asked
    assert problem.rejected >= min(len(asked), 2)
    assert len(asked) <= 3
    reached = [step.actions for step in problem.improvements if step.value >= problem.goal]
    assert reached == asked[2:]
    assert problem.done


def test_a_search_that_goes_on_counts_and_exceeds_what_was_there(searcher: Searcher) -> None:
    before = cube_problem(2000)
    search(searcher, before, 5)
    begun = before.outcome()
    problem = cube_problem(3500, begun=begun)
    search(searcher, problem, 6)
    after = problem.outcome()
    assert after.interactions == 3500
    assert after.improvements[: len(begun.improvements)] == begun.improvements
    assert all(step.interaction > 2000 for step in after.improvements[len(begun.improvements) :])
    values = [step.value for step in after.improvements]
    assert values == sorted(set(values))
    assert after.episodes > begun.episodes


def test_only_legal_actions_are_played(searcher: Searcher) -> None:
    """Every design that is scored replays through the game's own check, not only the best ones."""
    scored: list[tuple[int, ...]] = []

    class Recording:
        def score(self, sheet: FoldedSheet) -> float:
            state = sheet.states[sheet.index]
            scored.append(tuple(state["actions"][: state["n_actions"]].tolist()))
            problem.game.replay(scored[-1])  # raises on an illegal action
            return -float(len(sheet.flat))

    problem = Problem(Game(9, "xy", Square("choose"), max_crease_length=2.9), Recording(), 1500)
    search(searcher, problem, 0)
    assert len(set(scored)) > 20


@pytest.mark.parametrize("bounded", [True, False])
def test_abstract_objectives_are_searched_with_a_bound_and_without(searcher: Searcher, bounded: bool) -> None:
    """Rewards above zero, a bound that may be infinite; and a plain object that has none."""
    game = Game(13, "xyd", Square("choose"), max_crease_length=2.9)
    objective = BucketObjective()
    evaluator = objective.bind(game)

    class Plain:
        def score(self, sheet: FoldedSheet) -> Score:
            return evaluator.score(sheet.states, evaluator.new_memos(1), sheet.index)

    problem = Problem(game, objective if bounded else Plain(), 4000)
    search(searcher, problem, 1)
    outcome = problem.outcome()
    assert outcome.interactions == 4000
    assert outcome.value > 0
    states = game.replay(outcome.actions)
    states["reach"] = certified_reach(game, outcome.actions, int(states["reach"][0]))
    assert evaluator.score(states, evaluator.new_memos(1), 0) == Score(outcome.value, outcome.angle)


@pytest.mark.parametrize(("width", "height"), [(13, 7), (7, 13)])
def test_boards_need_not_be_square(searcher: Searcher, width: int, height: int) -> None:
    game = Game(symmetry="xy", start=Square("choose"), board_width=width, board_height=height, max_crease_length=4)
    problem = Problem(game, ShapeObjective(cube()), 2500)
    search(searcher, problem, 0)
    outcome = problem.outcome()
    assert outcome.succeeded
    x, y = np.abs(game.design(outcome.actions, outcome.angle).vertices).max(axis=0)
    assert x <= width // 2
    assert y <= height // 2


ANYWHERE: dict[str, tuple[str, Start]] = {
    "rectangle": ("y", Rectangle()),
    "crease": ("none", Crease(ends="choose", stays="lower")),
    "panel": ("xy", Panel(((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1)), (1, 1, 0, 1, 1, 0))),
    "square": ("x", Square("choose", "choose")),
}


@pytest.mark.parametrize("name", ANYWHERE)
def test_start_patterns_and_sources_may_be_placed_anywhere(searcher: Searcher, name: str) -> None:
    symmetry, start = ANYWHERE[name]
    game = Game(
        symmetry=symmetry, start=start, board_width=9, board_height=11, max_crease_length=4, source_action="boundary"
    )
    problem = Problem(game, ShapeObjective(cube()), 1500)
    search(searcher, problem, 0)
    outcome = problem.outcome()
    assert problem.interactions == 1500
    assert outcome.succeeded
    states = game.replay(outcome.actions)
    assert problem.evaluator.score(states, problem.evaluator.new_memos(1), 0).value >= outcome.value
    assert isinstance(game.moves(outcome.actions)[0], Lay)


def test_an_exhausted_tree_starts_anew(searcher: Searcher) -> None:
    """On 5×5 with a unit square and crease length 1 there is hardly anything to search."""
    problem = Problem(Game(5, "xyd", Square(1), max_crease_length=1), ShapeObjective(cube()), 2000)
    search(searcher, problem, 0)
    assert problem.interactions == 2000


def test_the_best_replays_to_its_return(searcher: Searcher) -> None:
    problem = cube_problem(4000)
    search(searcher, problem, 1)
    outcome = problem.outcome()
    assert outcome.succeeded
    states = problem.game.replay(outcome.actions)  # raises on an illegal action
    evaluator = bind(problem.objective, problem.game)
    reach = certified_reach(problem.game, outcome.actions, int(states["reach"][0]))
    states["reach"] = reach
    score = evaluator.score(states, evaluator.new_memos(1), 0)
    assert (score.value, score.angle) == (outcome.value, outcome.angle)


def test_improvements_are_reported_as_they_come(searcher: Searcher) -> None:
    problem = cube_problem(4000)
    search(searcher, problem, 2)
    outcome = problem.outcome()
    values = [improvement.value for improvement in outcome.improvements]
    times = [improvement.interaction for improvement in outcome.improvements]
    assert values == sorted(set(values))
    assert times == sorted(times)
    assert (values[-1], times[-1]) == (outcome.value, outcome.interactions_to_best)


def test_stops_when_asked_with_the_best_so_far(searcher: Searcher) -> None:
    looks = []

    def stop() -> bool:
        looks.append(1)
        return len(looks) > 3

    problem = cube_problem(10_000_000, should_stop=stop)
    search(searcher, problem, 0)
    assert 0 < problem.interactions < 10_000_000
    problem.outcome()


def test_watching_changes_nothing(searcher: Searcher) -> None:
    seen: list[int] = []
    outcomes = []
    for watch in (None, lambda problem: seen.append(problem.interactions)):
        problem = cube_problem(3000, on_progress=watch)
        search(searcher, problem, 3)
        outcomes.append(problem.outcome())
    assert outcomes[0] == outcomes[1]
    assert seen


def test_a_run_without_success_returns_the_start_pattern(searcher: Searcher) -> None:
    class Never:
        def score(self, sheet: object) -> float:
            return -math.inf

    problem = Problem(Game(9, "xy", Square(1)), Never(), 300)
    search(searcher, problem, 0)
    outcome = problem.outcome()
    assert not outcome.succeeded
    assert outcome.angle == -1
    design = problem.game.design(outcome.actions)
    assert len(design.panels) == 1


def test_incumbents_are_free_of_collisions_between_the_angles(searcher: Searcher) -> None:
    """By the dense check, replayed from the actions alone."""
    game = Game(13, "xyd", Square("choose"), max_crease_length=2.9)
    problem = Problem(game, ShapeObjective(bowl()), 6000)
    search(searcher, problem, 0)
    for improvement in problem.improvements:
        assert certified_reach(game, improvement.actions, improvement.angle + 1, sub_steps=10) == improvement.angle + 1


def test_bad_numbers_are_refused() -> None:
    with pytest.raises(InputError, match=r"search\.children"):
        BreadthFirstSearch(children=0)
    with pytest.raises(InputError, match=r"search\.restarts"):
        DepthFirstSearch(restarts=0)
