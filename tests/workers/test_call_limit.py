"""The time limit for calls of a user's objective, and the counting of interrupts: both on a clock of the test's."""

from __future__ import annotations

import math
import multiprocessing
import signal
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.objective import Objective, Score, bind
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.targets.solids import pyramid
from origami_lab.workers.call_limit import CallLimit, Calls
from origami_lab.workers.guarded_objective import watched
from origami_lab.workers.interrupts import Interrupts
from tests.experiment.fakes import Height


class Clock:
    """A clock that the test moves."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.now = 1000.0
        patch.setattr(time, "monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def look(limit: CallLimit, clock: Clock, seconds: float, step: float = 0.1) -> bool:
    """Look several times a second; whether the limit was ever exceeded."""
    found = False
    for _ in range(round(seconds / step)):
        clock.now += step
        found = limit.exceeded() or found
    return found


def test_one_call_may_last_so_long_and_many_calls_for_ever(clock: Clock) -> None:
    limit = CallLimit(multiprocessing.get_context("spawn"), 2.0)
    assert not look(limit, clock, 10.0)
    for call in range(1, 50):
        limit.number.value = call
        assert not look(limit, clock, 1.5)
    limit.number.value = 0
    assert not look(limit, clock, 10.0)
    limit.number.value = 50
    assert not look(limit, clock, 1.9)
    assert look(limit, clock, 0.5)


def test_no_limit_and_time_in_which_nothing_ran(clock: Clock) -> None:
    context = multiprocessing.get_context("spawn")
    never, limit = CallLimit(context, None), CallLimit(context, 2.5)
    never.number.value = limit.number.value = 1
    assert not look(never, clock, 1000.0)
    limit.exceeded()
    clock.now += 3600.0  # the machine slept: one second of it counts
    assert not limit.exceeded()
    assert not look(limit, clock, 1.4)
    assert look(limit, clock, 0.3)


class Plain(Height):
    """Looks at its own call's number."""

    def __init__(self, shared: Any) -> None:
        self.shared, self.seen = shared, []

    def score(self, sheet: object) -> float:
        self.seen.append(self.shared.value)
        if sheet is None:
            raise RuntimeError
        return 1.0


class Own(Plain):
    """Brings its own evaluator."""

    result: Any = Score(1.0, 0)

    def bind(self, game: object) -> Any:
        self.seen.append(self.shared.value)
        return SimpleNamespace(
            new_memos=np.zeros,
            clear=lambda memos, i: None,
            score=lambda states, memos, i, above: self.result,
            bound=lambda states, memos, i, above: math.nan,
        )

    def report(self, game: object, actions: object, angle: int) -> dict[str, float]:
        self.seen.append(self.shared.value)
        return {}


def test_calls_are_numbered_while_they_last() -> None:
    shared = SimpleNamespace(value=0)
    objective = watched(Plain(shared), Calls(shared))
    assert objective.score(1) == 1.0
    with pytest.raises(RuntimeError):
        objective.score(None)
    assert objective.score(1) == 1.0
    assert objective.seen == [1, 2, 3]
    assert shared.value == 0


def test_a_watched_objective_has_the_methods_that_it_had() -> None:
    shared = SimpleNamespace(value=0)
    game = Game(9, "xy", Square(1))
    plain, own = (watched(kind(shared), Calls(shared)) for kind in (Plain, Own))
    assert not any(hasattr(plain, name) for name in ("bound", "report", "bind"))
    assert not isinstance(plain, Objective)
    assert isinstance(own, Objective)
    assert type(plain).__name__ == "Plain"
    assert own.report(game, (), 0) == {}
    evaluator = bind(own, game)
    assert own.seen == [1, 2]
    assert evaluator.score(game.new_states(1), evaluator.new_memos(1), 0) == Score(1.0, 0)
    ours = ShapeObjective(pyramid())
    assert watched(ours, Calls(shared)) is ours


@pytest.mark.parametrize("result", [None, 1.0, Score(math.nan, 0), Score(math.inf, 0), Score(1.0, 99), Score(1.0, -2)])
def test_what_an_evaluator_of_ones_own_returns_is_checked(result: object) -> None:
    shared = SimpleNamespace(value=0)
    game = Game(9, "xy", Square(1))
    own = Own(shared)
    own.result = result
    evaluator = bind(watched(own, Calls(shared)), game)
    with pytest.raises(InputError, match="objective=Own: score returned"):
        evaluator.score(game.new_states(1), evaluator.new_memos(1), 0)
    with pytest.raises(InputError, match="objective=Own: bound returned NaN"):
        evaluator.bound(game.new_states(1), evaluator.new_memos(1), 0)


def test_the_second_interrupt_raises_unless_it_comes_with_the_first(clock: Clock) -> None:
    with Interrupts() as interrupts:
        interrupts.limit = 2
        signal.raise_signal(signal.SIGTERM)
        clock.now += 0.01
        signal.raise_signal(signal.SIGTERM)  # as `timeout` does
        assert interrupts.count == 1
        clock.now += 1.0
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        clock.now += 1.0
        interrupts.limit = None
        signal.raise_signal(signal.SIGINT)
        assert interrupts.count == 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_nohup_ignores_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Interrupts() as interrupts:
            signal.raise_signal(signal.SIGHUP)
        assert interrupts.count == 0
    finally:
        signal.signal(signal.SIGHUP, before)
