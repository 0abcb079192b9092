"""What every objective promises, whatever it rewards: its score, its bound, its documented range."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import SELECTION
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.objectives.bucket import BucketObjective
from origami_lab.objectives.chair import ChairObjective
from origami_lab.objectives.objective import NO_SCORE, bind, report
from origami_lab.objectives.packaging import PackagingObjective
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shelf import ShelfObjective
from origami_lab.objectives.table import TableObjective
from origami_lab.targets.solids import bowl
from tests.objectives.references import farthest
from tests.objectives.sheets import episodes

BOWL = bowl()
# the objective with a compactness weight (one that has none ignores it), its lowest and its highest value on a 9×9
# board, the ends included
OBJECTIVES = {
    "bucket": (lambda w: BucketObjective(compactness=w), 0.0, math.inf),
    "bucket by its rim": (lambda w: BucketObjective(compactness=w, norm_of="leaves"), 0.0, math.inf),
    "shelf": (lambda w: ShelfObjective(compactness=w), 0.0, 64 / 3),
    "table": (lambda w: TableObjective(compactness=w), -math.inf, 0.0),
    "chair": (lambda w: ChairObjective(compactness=w), -math.inf, 0.0),
    "packaging": (lambda w: PackagingObjective(compactness=w), 0.0, math.inf),
    "shape": (lambda w: ShapeObjective(BOWL, compactness=w), -math.inf, 0.0),
    "shape surface": (lambda w: ShapeObjective(BOWL, "surface", 0.2, compactness=w), -math.inf, 0.0),
}
COMPACT = [name for name, (make, _, _) in OBJECTIVES.items() if hasattr(make(0.0), "compactness")]
COMPILED = [name for name, (make, _, _) in OBJECTIVES.items() if hasattr(make(0.0), "bind")]
GAMES = {
    "xy": Game(9, "xy", Square("choose"), max_crease_length=4),
    "y fixed": Game(9, "y", Square(2), driving_angle_fixed=50),
    "crease": Game(9, "none", Crease("choose"), max_crease_length=4),
}
WEIGHTS = (0.0, 0.4)
SHEETS = 12


@pytest.fixture(params=OBJECTIVES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=GAMES)
def game(request: pytest.FixtureRequest) -> Game:
    return GAMES[request.param]


def test_it_is_an_objective_whose_figures_are_numbers(name: str) -> None:
    objective = OBJECTIVES[name][0](0.0)
    game = GAMES["xy"]
    bind(objective, game)
    states = next(episodes(game, 0, 1))
    figures = report(objective, game, game.finished_actions(states), 0)
    assert all(isinstance(figure, float) for figure in figures.values())


def test_scores_are_in_the_documented_range_at_an_angle_that_may_be_used(name: str, game: Game) -> None:
    make, low, high = OBJECTIVES[name]
    evaluator = bind(make(0.0), game)
    for states in episodes(game, 1, SHEETS):
        score = evaluator.score(states, evaluator.new_memos(1), 0)
        assert low <= score.value <= high
        assert game.first_angle <= score.angle < states["reach"][0]


def test_the_sheet_is_left_as_it_is_and_scores_the_same_again(name: str, game: Game) -> None:
    evaluator = bind(OBJECTIVES[name][0](0.4), game)
    memos = evaluator.new_memos(3)
    for states in episodes(game, 2, SHEETS):
        before = states.copy()
        evaluator.clear(memos, 1)
        first = evaluator.score(states.repeat(3), memos, 1)
        bound = evaluator.bound(states.repeat(3), memos, 1)
        memos[2] = memos[1]
        assert evaluator.score(states.repeat(3), memos, 1) == first
        assert evaluator.score(states.repeat(3), memos, 2) == first
        assert evaluator.bound(states.repeat(3), memos, 2) == bound
        assert states.tobytes() == before.tobytes()


def test_knowing_what_to_beat_changes_nothing_above_it(name: str, game: Game) -> None:
    for weight in WEIGHTS:
        evaluator = bind(OBJECTIVES[name][0](weight), game)
        for states in episodes(game, 3, SHEETS):
            full = evaluator.score(states, evaluator.new_memos(1), 0)
            for margin in (10, 1e-6):
                assert evaluator.score(states, evaluator.new_memos(1), 0, full.value - margin) == full
            for margin in (1e-6, 1, 10):
                above = full.value + margin
                assert evaluator.score(states, evaluator.new_memos(1), 0, above).value <= above
                assert evaluator.bound(states, evaluator.new_memos(1), 0, full.value - 1e-6) > full.value - 1e-6


@pytest.mark.parametrize("name", COMPACT)
def test_compactness_costs_what_the_furthest_vertex_is_away(name: str, game: Game) -> None:
    """At each angle by itself: there the weight cannot change which angle is best."""
    make = OBJECTIVES[name][0]
    plain, compact = bind(make(0.0), game), bind(make(0.4), game)
    for states in episodes(game, 4, SHEETS):
        alone = states.copy()
        k = game.first_angle
        alone["reach"] = k + 1
        expected = plain.score(alone, plain.new_memos(1), 0).value - 0.4 * farthest(game.sheet(alone), k)
        assert compact.score(alone, compact.new_memos(1), 0).value == pytest.approx(expected, abs=1e-9)
        # and over all angles no more than at the best of them
        assert compact.score(states, compact.new_memos(1), 0).value <= plain.score(states, plain.new_memos(1), 0).value


@pytest.mark.parametrize("weight", WEIGHTS)
def test_a_bound_never_rises_and_is_never_below_what_a_continuation_reaches(
    name: str, game: Game, weight: float
) -> None:
    evaluator = bind(OBJECTIVES[name][0](weight), game)
    rng = np.random.default_rng(5)
    scored = 0
    while scored < 8:
        states, memos, bounds = game.new_states(), evaluator.new_memos(1), []
        bounds.append(evaluator.bound(states, memos, 0))
        legal = game.legal(states)
        terminate = 3 * game.rules.points
        while len(legal):
            others = legal[legal != terminate]
            action = int(rng.choice(others if len(others) and rng.random() < 0.8 else legal))
            legal = game.play(states, action)
            if states["phase"][0] == SELECTION:
                bounds.append(evaluator.bound(states, memos, 0))
                # from scratch it is the same: the notes are notes
                assert evaluator.bound(states, evaluator.new_memos(1), 0) == bounds[-1]
        assert all(later <= earlier + 1e-9 for earlier, later in pairwise(bounds))
        if states["n_triangles"][0] and not game.is_penalised(states):
            assert evaluator.score(states, memos, 0).value <= bounds[-1] + 1e-9
            scored += 1


@pytest.mark.parametrize("name", COMPILED)
def test_a_sheet_without_area_has_no_score(name: str) -> None:
    game = GAMES["crease"]
    evaluator = bind(OBJECTIVES[name][0](0.0), game)
    states = game.new_states()
    game.play(states, int(game.legal(states)[0]))
    assert evaluator.score(states, evaluator.new_memos(1), 0) == NO_SCORE


@pytest.mark.parametrize("name", COMPACT)
@pytest.mark.parametrize("weight", [-0.1, math.nan, math.inf, "heavy", True, None])
def test_a_bad_weight_is_refused(name: str, weight: object) -> None:
    with pytest.raises(InputError, match=r"objective\.compactness"):
        OBJECTIVES[name][0](weight)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: BucketObjective(spread=0.9), "spread"),
        (lambda: BucketObjective(norm_of="corners"), "norm_of"),
        (lambda: ShelfObjective(levels=0), "levels"),
        (lambda: ShelfObjective(gap=0), "gap"),
        (lambda: TableObjective(height=-1), "height"),
        (lambda: ChairObjective(side="left"), "side"),  # type: ignore[arg-type]
    ],
)
def test_other_bad_numbers_are_refused(make: object, key: str) -> None:
    with pytest.raises(InputError, match=rf"objective\.{key}"):
        make()  # type: ignore[operator]
