"""Searches that go on from a start pattern made of moves: legal designs, and no interactions for the start."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.moves import Extend
from origami_lab.game.start_from_moves import FromFile, FromMoves
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch, TreeSearch
from origami_lab.search.dense_check import certified_reach
from origami_lab.search.problem import Problem, Searcher
from origami_lab.targets.solids import cube
from tests.known_designs import game_moves as known
from tests.search.test_searchers import SEARCHERS


@pytest.fixture(params=SEARCHERS)
def searcher(request: pytest.FixtureRequest) -> Searcher:
    return SEARCHERS[request.param]()


class Highest:
    """Rewards height, and so further extensions."""

    def score(self, sheet: object) -> float:
        return float(sheet.points[-1, :, 2].max()) + 0.01 * len(sheet.flat)  # type: ignore[attr-defined]


def test_designs_begin_with_the_start_and_replay(searcher: Searcher) -> None:
    game = Game(13, "y", FromFile("chair"), source_action=False, driving_angle_fixed="start")
    problem = Problem(game, Highest(), 1500)
    searcher.search(problem, np.random.default_rng(2))
    outcome = problem.outcome()
    assert outcome.interactions == 1500
    assert outcome.episodes > 5
    assert len(game.moves(outcome.actions)) > len(game.start_moves)
    for step in outcome.improvements:
        assert step.actions[: len(game.start_actions)] == game.start_actions
        assert 0 < step.interaction <= 1500
        game.replay(step.actions)  # every action is legal
        assert certified_reach(game, step.actions, step.angle + 1) == step.angle + 1
    # what a trial saves needs no file, and gives the same design
    again = Game(
        13,
        "y",
        FromMoves(game.start_moves, symmetry="y"),
        source_action=False,
        driving_angle_fixed=game.driving_angle_fixed,
    )
    saved, found = again.design(outcome.actions, outcome.angle), game.design(outcome.actions, outcome.angle)
    assert np.array_equal(saved.folded, found.folded)
    assert saved.edges.tolist() == found.edges.tolist()
    assert len(game.motion(outcome.actions, game.angles[:5]).driving_angles) == 5


def test_the_missing_half_of_the_cube_is_found_again(searcher: Searcher) -> None:
    """The start is the cube without its lid; no episode can score below it, and the lid is four interactions away."""
    _, moves = known.cube()
    game = Game(9, "xy", FromMoves(tuple(moves), remove=((-3, 1),)), max_crease_length=2)
    whole = Game(9, "xy", FromMoves(tuple(moves)), max_crease_length=2)
    objective = ShapeObjective(cube())
    problem = Problem(game, objective, 4000)
    searcher.search(problem, np.random.default_rng(0))
    outcome = problem.outcome()
    assert outcome.value >= -np.sqrt(8) * np.cos(1.57) - 1e-5  # the known design's
    assert sum(isinstance(move, Extend) for move in game.moves(outcome.actions)) >= 2
    done = Problem(whole, objective, 5)
    searcher.search(done, np.random.default_rng(0))
    assert done.outcome().interactions == 5


def test_a_start_alone_is_what_is_left_when_nothing_succeeds() -> None:
    game = Game(13, "y", FromFile("chair"), source_action=False)
    problem = Problem(game, Highest(), 1)
    assert problem.outcome().actions == game.start_actions == game.bare_start()
    assert not problem.outcome().succeeded


@pytest.mark.parametrize("method", [BreadthFirstSearch, DepthFirstSearch])
def test_refused_designs_are_cut_on_the_way_to_them(method: type[TreeSearch], monkeypatch: pytest.MonkeyPatch) -> None:
    """Trimming goes back and forth along the search's actions, which come after the start pattern's in the log."""
    three = 3
    monkeypatch.setattr(
        "origami_lab.search.problem.certified_reach", lambda game, actions, reach, scratch: min(reach, three)
    )
    game = Game(13, "y", FromFile("chair"), max_crease_length=4, straight_sectors=False)
    problem = Problem(game, Highest(), 3000)
    method(restarts=2).search(problem, np.random.default_rng(0))
    outcome = problem.outcome()
    assert problem.rejected >= 1
    assert outcome.angle == three - 1
    assert len(outcome.improvements) > 1
    for step in outcome.improvements:
        game.replay(step.actions)
