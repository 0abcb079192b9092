"""The whole search: any kind of objective and game, and the same bits whatever the size of the blocks of draws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import States
from origami_lab.game.moves import Place
from origami_lab.game.start_from_moves import FromMoves
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.objectives.chair import ChairObjective
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search import random_stream as draws
from origami_lab.search.dense_check import certified_reach
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.problem import Outcome, Problem
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target
from tests.known_designs import game_moves as known
from tests.search.neighbourhood.test_growth import tilted


def bowl_game(**settings: Any) -> Game:
    return Game(25, "xyd", Square("choose"), max_crease_length=2.9, **settings)


def plate() -> Target:
    """A square plate at the start pattern's height: a start square alone covers it, and larger ones stray."""
    corners = np.array([[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]])
    return Target("plate", corners, np.array([[0, 1, 2], [0, 2, 3]]), closed=False)


def found(game: Game, objective: Any, budget: int, seed: int = 0, **settings: Any) -> Outcome:
    options = {name: settings.pop(name) for name in ("certify", "should_stop") if name in settings}
    problem = Problem(game, objective, budget, **options)
    NeighbourhoodSearch(**settings).search(problem, np.random.default_rng(seed))
    outcome = problem.outcome()
    assert outcome.interactions == budget or "should_stop" in options
    for improvement in outcome.improvements:
        game.replay(improvement.actions)  # raises on an illegal action
    return outcome


class Constant:
    def score(self, sheet: FoldedSheet) -> float:
        return 1.5


class Never:
    def score(self, sheet: FoldedSheet) -> float:
        return -math.inf


class Sometimes:
    """Worthless for half of the designs."""

    def score(self, sheet: FoldedSheet) -> float:
        return float(len(sheet.flat)) if len(sheet.flat) // 4 % 2 else -math.inf


class Hopeless:
    """Its bound says at once that nothing can come of it, wrongly or not."""

    def score(self, sheet: FoldedSheet) -> float:
        return float(len(sheet.flat))

    def bound(self, sheet: FoldedSheet) -> float:
        return -math.inf


@pytest.mark.parametrize("block", [1, 37, 5000])
@pytest.mark.parametrize("task", ["bowl", "chair"])
def test_the_size_of_blocks_of_draws_changes_nothing(task: str, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def outcome() -> Outcome:
        if task == "bowl":
            return found(bowl_game(), ShapeObjective(bowl()), 6000, 3, run=0.02, first_run=30)
        return found(Game(13, "y", Square("choose"), max_crease_length=2.9), ChairObjective(), 3000, 3)

    expected = outcome()
    monkeypatch.setattr(draws, "BLOCK", block)
    assert outcome() == expected
    assert len(expected.improvements) > 3


@pytest.mark.parametrize("objective", [Constant, Never, Sometimes, Hopeless])
def test_any_number_will_do_as_an_objective(objective: type) -> None:
    outcome = found(Game(9, "xy", Square(1)), objective(), 2000)
    assert outcome.succeeded == (objective is not Never)
    assert outcome.episodes > (1 if objective is Hopeless else 100)


def test_a_perfect_fit_is_no_end() -> None:
    """Nothing is better than distance 0, and no threshold below it can be reached: the budget is spent all the same."""
    outcome = found(Game(9, "xyd", Square("choose")), ShapeObjective(plate()), 3000)
    assert outcome.value == pytest.approx(0, abs=1e-9)


def test_a_start_that_covers_everything_is_a_design_like_others() -> None:
    """The threshold is lowered until it does not; the search goes on from there to what is better."""
    outcome = found(Game(9, "xyd", Square("choose")), ShapeObjective(pyramid()), 3000)
    assert outcome.value > -2


@pytest.mark.parametrize("look", [False, True])
@pytest.mark.parametrize("objective", [lambda: ShapeObjective(cube()), Constant])
def test_where_no_move_can_be_completed_every_attempt_costs_an_interaction(look: bool, objective: Any) -> None:
    """Also with a start pattern of moves, which is laid for nothing."""
    game = Game(5, "xyd", FromMoves((Place(1, 1),)), max_crease_length=1)
    assert len(found(game, objective(), 300, look=look).actions) == len(game.start_actions)


@pytest.mark.parametrize("settings", [{"distance": "surface"}, {"distance": "sampled"}, {"compactness": 0.05}])
def test_every_shape_objective_is_led_by_its_threshold(settings: dict[str, Any]) -> None:
    """What is found is worth what the objective says, and is better than the first designs."""
    game, objective = bowl_game(), ShapeObjective(bowl(), **settings)
    outcome = found(game, objective, 12_000, 1, run=0.02)
    evaluator, states = objective.bind(game), game.replay(outcome.actions)
    states["reach"] = certified_reach(game, outcome.actions, int(states["reach"][0]))
    score = evaluator.score(states, evaluator.new_memos(1), 0)
    # runs look at driving angles up to their own, so larger ones may be better still
    assert score.value >= outcome.value
    assert outcome.value > -1.2 - 12 * objective.compactness
    assert len(outcome.improvements) > 5


def test_a_target_without_the_symmetry_of_the_board() -> None:
    """All images of vertices must stay near, and all of the target counts, not only its part over the playable area."""
    game, objective = Game(13, "y", Square("choose"), max_crease_length=2.9), ShapeObjective(tilted())
    outcome = found(game, objective, 12_000, 0)
    assert outcome.value > -1.5
    assert objective.bind(game).measure(game.replay(outcome.actions), 0, outcome.angle, "vertex") == pytest.approx(
        -outcome.value, abs=1e-12
    )


def test_one_driving_angle_only() -> None:
    game = bowl_game(driving_angle_fixed=40)
    outcome = found(game, ShapeObjective(bowl()), 12_000, 0)
    assert outcome.angle == len(game.angles) - 1
    assert outcome.value > -1.2


def test_no_episode_ends_inside_an_extension() -> None:
    """So penalising those that do changes nothing."""
    plain = found(bowl_game(), ShapeObjective(bowl()), 5000, 2)
    assert found(bowl_game(stuck="penalise"), ShapeObjective(bowl()), 5000, 2) == plain


def test_without_dense_checks_nothing_is_refused() -> None:
    game, refused = Game(9, "none", Square(1)), 0
    for seed in (4, 17):
        checked = found(game, ShapeObjective(pyramid()), 6000, seed)
        assert found(game, ShapeObjective(pyramid()), 6000, seed, certify=False).rejected == 0
        refused += checked.rejected
        for improvement in checked.improvements:
            assert certified_reach(game, improvement.actions, improvement.angle + 1) == improvement.angle + 1
    assert refused > 0


def test_a_start_that_reaches_few_angles_has_runs_at_those_only() -> None:
    _, moves = known.cube()
    game = Game(13, "xy", FromMoves(tuple(moves)), max_crease_length=2.9)
    reach = int(game.new_states(1)["reach"][0])
    assert 0 < reach < len(game.angles)
    assert found(game, ShapeObjective(cube()), 2000).angle < reach


@pytest.mark.parametrize("guided", [False, True])
def test_driven_creases_are_laid_later_too(guided: bool) -> None:
    """By growth under a threshold and by random growth, where the game allows it."""
    game = Game(13, "xy", Square(1), max_crease_length=2.9)
    laid: list[bool] = []

    class Watching(ShapeObjective):
        """Looks at every design that is scored."""

        def bind(self, game: Game) -> Any:
            evaluator = super().bind(game)
            score = evaluator.exact_value

            def watched(states: States, memos: Any, i: int) -> float:
                log = states["actions"][i][: int(states["n_actions"][i])]
                laid.append(bool(((log > 3 * game.rules.points) & (log < 3 * game.rules.points + 5)).any()))
                return score(states, memos, i)

            evaluator.exact_value = watched  # type: ignore[method-assign]
            if not guided:
                evaluator.compiled_cover = None  # type: ignore[assignment]
            return evaluator

    problem = Problem(game, Watching(cube()), 8000)
    NeighbourhoodSearch(source=0.3).search(problem, np.random.default_rng(0))
    assert any(laid)
    assert not all(laid)


@pytest.mark.parametrize("seed", range(5))
def test_the_pyramid_is_found(seed: int) -> None:
    """The known optimum, on a board without a maximum crease length, where one exact place counts."""
    best = -3 * math.sin(math.acos(-1 / 3) - 1.884)
    problem = Problem(
        Game(9, "xy", Square(1)),
        ShapeObjective(pyramid()),
        500_000,
        should_stop=lambda: problem.best_value > best - 1e-9,
    )
    NeighbourhoodSearch().search(problem, np.random.default_rng(seed))
    assert problem.best_value == pytest.approx(best, abs=1e-9)
    assert problem.interactions < 100_000


def test_a_crease_to_begin_with() -> None:
    """Its two vertices lie on the board in one line, and the flaps have no area."""
    outcome = found(Game(13, "y", Crease(0), max_crease_length=2.9), ShapeObjective(bowl()), 4000)
    assert outcome.succeeded
