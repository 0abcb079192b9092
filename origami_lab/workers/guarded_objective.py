"""A user's objective whose calls are numbered, for :mod:`.watch`, and whose answers are checked."""

from __future__ import annotations

from typing import Any

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import States
from origami_lab.objectives.objective import Evaluator, Memos, Score, checked, number
from origami_lab.workers.call_limit import Calls


def is_ours(objective: Any) -> bool:
    """Whether an objective is one of this package, whose calls end."""
    return type(objective).__module__.partition(".")[0] == "origami_lab"


def watched(objective: Any, calls: Calls) -> Any:
    """The same objective with numbered calls. Ours are left as they are: their first call may compile for a minute."""
    if is_ours(objective):
        return objective
    # messages name the class, and it is still the user's
    return type(type(objective).__name__, (_Watched,), {"__module__": type(objective).__module__})(objective, calls)


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
