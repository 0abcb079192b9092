"""Shaped rewards: they sum to what the objective says of the sheet, and fall with its bound."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.observation import CompactView
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.bucket import BucketObjective
from origami_lab.objectives.objective import bind
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.table import TableObjective
from origami_lab.search.problem import Problem, SearchEnded
from origami_lab.search.rl_episodes import Episodes
from origami_lab.targets.solids import cube


class Plain:
    """No bound."""

    def score(self, sheet: Any) -> float:
        return float(len(sheet.flat))


class Worthless:
    def score(self, sheet: Any) -> float:
        return -math.inf

    def bound(self, sheet: Any) -> float:
        return -math.inf if len(sheet.flat) > 8 else math.inf


OBJECTIVES: dict[str, Callable[[], Any]] = {
    "shape": lambda: ShapeObjective(cube()),
    "table": TableObjective,
    "bucket": BucketObjective,
    "plain": Plain,
    "worthless": Worthless,
}


def episodes_of(objective: Any, count: int = 1, budget: int = 10**9, **game: Any) -> Episodes:
    # with sectors of π legal, random play hardly ever meets a vertex that cannot fold
    board = Game(9, "xy", Square(1), **({"max_crease_length": 2, "straight_sectors": False} | game))
    return Episodes(Problem(board, objective, budget, certify=False), count, CompactView(board))


@pytest.mark.parametrize("name", OBJECTIVES)
@pytest.mark.parametrize("stuck", ["score", "penalise"])
def test_rewards_sum_to_the_return(name: str, stuck: str) -> None:
    episodes = episodes_of(OBJECTIVES[name](), stuck=stuck)
    problem, rng = episodes.problem, np.random.default_rng(1)
    game = problem.game
    evaluator = bind(problem.objective, game)
    returns, early, penalised = set(), 0, 0
    for _ in range(150):
        episodes.reset(0)
        rewards, ended = [], False
        while not ended:
            reward, ended = episodes.step(0, int(rng.choice(np.flatnonzero(episodes.masks[0]))))
            rewards.append(reward)
        states = episodes.positions.states
        if game.is_penalised(states):
            expected = game.penalty
            penalised += 1
        else:
            score = evaluator.score(game.replay(game.finished_actions(states)), evaluator.new_memos(1), 0).value
            expected = score if math.isfinite(score) else game.penalty
        assert episodes.returns[0] == expected
        assert math.fsum(rewards) == pytest.approx(expected, rel=0, abs=1e-12 * max(map(abs, rewards)))
        returns.add(expected)
        early += any(rewards[:-1])
        if name in ("shape", "table"):  # bounded from the first sheet on
            assert all(reward <= 0 for reward in rewards)
        if name == "plain":
            assert not any(rewards[:-1])
    assert penalised > 0
    assert len(returns) > {"worthless": 0, "bucket": 1}.get(name, 10)
    if name != "bucket":  # whose bound depends on luck
        assert (early > 0) == (name != "plain")


def test_an_illegal_action_ends_the_episode_with_the_penalty() -> None:
    episodes = episodes_of(ShapeObjective(cube()))
    episodes.reset(0)
    first, ended = episodes.step(0, int(np.flatnonzero(episodes.masks[0])[0]))
    assert not ended
    last, ended = episodes.step(0, int(np.flatnonzero(~episodes.masks[0])[0]))
    assert ended
    assert first + last == episodes.problem.game.penalty == episodes.returns[0]
    assert not episodes.masks.any()
    assert episodes.problem.interactions == 2
    assert not episodes.problem.improvements


@pytest.mark.parametrize("beyond", ["-1", "-n", "n"])
def test_an_action_that_there_is_none_of_is_illegal(beyond: str) -> None:
    episodes = episodes_of(ShapeObjective(cube()))
    n = episodes.problem.game.rules.n_actions
    episodes.reset(0)
    assert episodes.masks[0, -1]  # to NumPy −1 is the last action, which is legal here: it places the square
    assert episodes.step(0, {"-1": -1, "-n": -n, "n": n}[beyond]) == (episodes.problem.game.penalty, True)
    assert not episodes.masks.any()
    assert episodes.problem.interactions == 1


def test_episodes_side_by_side_do_not_touch_each_other() -> None:
    together, alone = episodes_of(ShapeObjective(cube()), 3), [episodes_of(ShapeObjective(cube())) for _ in range(3)]
    rng, ends = np.random.default_rng(0), 0
    for i in range(3):
        together.reset(i)
        alone[i].reset(0)
    for _ in range(400):
        i = int(rng.integers(3))
        action = int(rng.choice(np.flatnonzero(together.masks[i])))
        step = together.step(i, action)
        assert step == alone[i].step(0, action)
        if step[1]:
            ends += 1
            together.reset(i)
            alone[i].reset(0)
        for j in range(3):
            assert np.array_equal(together.observations[j], alone[j].observations[0])
            assert np.array_equal(together.masks[j], alone[j].masks[0])
    assert ends > 10


def test_the_budget_ends_them() -> None:
    episodes = episodes_of(ShapeObjective(cube()), budget=3)
    episodes.reset(0)
    for _ in range(3):
        assert not episodes.step(0, int(np.flatnonzero(episodes.masks[0])[0]))[1]
    with pytest.raises(SearchEnded):
        episodes.step(0, int(np.flatnonzero(episodes.masks[0])[0]))
    assert episodes.problem.interactions == 3
