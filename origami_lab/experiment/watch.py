"""A time limit for single calls of a user's objective.

The worker only numbers the calls, in memory that it shares with the parent; the parent measures how long it sees the
same number. So the limit holds inside C code, too, and time in which the machine slept or the run was suspended does
not count.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from ctypes import c_uint64
from multiprocessing.context import SpawnContext
from typing import Any

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.state import States
from origami_lab.objectives.base import Evaluator, Memos, Score, checked, number

LONGEST_STEP = 1.0
"""Seconds between two looks that count: if there are more, the parent itself did not run."""


class CallLimit:
    """The parent's side: how long a worker has been in one call.

    Parameters
    ----------
    seconds
        Longest that a call may take; None for no limit.
    """

    def __init__(self, context: SpawnContext, seconds: float | None) -> None:
        self.number: Any = context.RawValue(c_uint64, 0)
        """What the worker is given: the number of the call it is in, 0 if it is in none."""
        self.seconds = seconds
        self._seen, self._lasted, self._looked = 0, 0.0, time.monotonic()

    def exceeded(self) -> bool:
        """Whether the worker's present call has lasted too long. To be asked several times a second."""
        now = time.monotonic()
        step, self._looked = min(now - self._looked, LONGEST_STEP), now
        call = int(self.number.value)
        self._lasted = self._lasted + step if call and call == self._seen else 0.0
        self._seen = call
        return self.seconds is not None and self._lasted > self.seconds


class Calls:
    """The worker's side: numbers the calls of the functions that are wrapped by it."""

    def __init__(self, shared: Any) -> None:
        self._shared, self._count = shared, 0

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        shared = self._shared

        def numbered(*arguments: Any, **named: Any) -> Any:
            self._count += 1
            shared.value = self._count
            try:
                return function(*arguments, **named)
            finally:
                shared.value = 0

        return numbered


def watched(objective: Any, calls: Calls) -> Any:
    """The same objective with numbered calls. Ours are left as they are: their first call may compile for a minute."""
    if type(objective).__module__.partition(".")[0] == "origami_lab":
        return objective
    # messages name the class
    return type(type(objective).__name__, (_Watched,), {})(objective, calls)


class _Watched:
    """An objective of the user's; has the methods that this one has, and no others."""

    def __init__(self, objective: Any, calls: Calls) -> None:
        self._objective = objective
        for name in ("score", "bound", "report"):
            if callable(method := getattr(objective, name, None)):
                setattr(self, name, calls(method))
        if callable(bind := getattr(objective, "bind", None)):
            name, numbered = type(objective).__name__, calls(bind)
            self.bind = lambda game: _WatchedEvaluator(numbered(game), game, name, calls)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._objective, name)


class _WatchedEvaluator:
    """An evaluator of the user's own; what it returns is checked, as is what a plain ``score(sheet)`` returns."""

    def __init__(self, evaluator: Evaluator, game: Game, name: str, calls: Calls) -> None:
        for method in ("new_memos", "clear", "score", "bound"):
            if not callable(getattr(evaluator, method, None)):
                raise InputError("objective", name, f"bind(game) must return an evaluator, it has no method {method}")
        self._evaluator, self.new_memos, self.clear = evaluator, evaluator.new_memos, evaluator.clear
        self._first = game.first_angle
        self._score, self._bound = calls(evaluator.score), calls(evaluator.bound)
        self._name = name

    def score(self, states: States, memos: Memos, i: int, above: float = float("-inf")) -> Score:
        score = self._score(states, memos, i, above)
        if not isinstance(score, Score):
            raise InputError("objective", self._name, f"score returned a {type(score).__name__}; it must be a Score")
        return checked(score, self._first, int(states["reach"][i]), self._name)

    def bound(self, states: States, memos: Memos, i: int, above: float = float("-inf")) -> float:
        return number(self._bound(states, memos, i, above), self._name, "bound")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._evaluator, name)
