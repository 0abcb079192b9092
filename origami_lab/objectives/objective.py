"""Objectives: a score for a folded sheet, and a bound on the scores of all its continuations.

The simplest objective is any object with a method ``score(sheet)``; it gets a read-only
:class:`~origami_lab.game.folded_sheet.FoldedSheet` and returns a number or a :class:`Score`. It may also have
``bound(sheet)``. An objective that wants speed implements :class:`Objective` itself and works on the state arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import States

Memos = NDArray[Any]
"""Array of an evaluator's notes, one for each state: cleared with the state, copied with it."""


@dataclass(frozen=True)
class Score:
    """A value to be maximised and the index of the driving angle that reaches it (−1: none does)."""

    value: float
    angle: int


NO_SCORE = Score(-math.inf, -1)


class Evaluator(Protocol):
    """An objective bound to a game.

    ``above`` is what the caller has already: a method may return any value not above it as soon as it knows that
    the true value is not above it either.

    An attribute ``compiled_score``, if there is one and it is not None, is what compiled searches ask instead of
    :meth:`score` and :meth:`bound` (:mod:`~.compiled_score`): Python then hears of those episodes only that may be the
    best. An attribute ``compiled_bound``, if there is one and it is a :class:`~.shape_kernels.Surface`, lets
    compiled searches bound positions themselves; :meth:`bound` must then give the same. With it may go an attribute
    ``compiled_cover``, the samples of the target that the sheet is to cover: a tree
    (:class:`~origami_lab.geometry.bvh.Bvh`) over triangles without area. It guides searches that grow designs; another,
    ``panels_bound``, says whether points inside panels stray as vertices do. A method
    ``exact_value(states, memos, i)``, if there is one, gives the value of :meth:`score` with no ``above``, sooner as
    no angle is asked for, and leaves the memos as they are.
    """

    def new_memos(self, count: int) -> Memos:
        """Notes for ``count`` states."""
        ...

    def clear(self, memos: Memos, i: int) -> None:
        """Forget what was noted of a state."""
        ...

    def score(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> Score:
        """Best value over the driving angles that the state reaches and that may be used."""
        ...

    def bound(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> float:
        """A value that no continuation of the state can exceed; +inf if none is known."""
        ...


@runtime_checkable
class Objective(Protocol):
    """An objective that makes its own evaluator."""

    def bind(self, game: Game) -> Evaluator:
        """The evaluator of this objective in a game."""
        ...

    def report(self, game: Game, actions: tuple[int, ...], angle: int) -> dict[str, float]:
        """Further figures of a finished design at one driving angle, for the table of trials."""
        ...


class SheetEvaluator:
    """Adapts an object with ``score(sheet)`` (and perhaps ``bound(sheet)``)."""

    def __init__(self, objective: Any, game: Game) -> None:
        self._objective, self._rules = objective, game.rules.record
        self._has_bound = callable(getattr(objective, "bound", None))

    def new_memos(self, count: int) -> Memos:
        return np.zeros(count, dtype=np.int8)

    def clear(self, memos: Memos, i: int) -> None:
        pass

    def score(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> Score:
        sheet = FoldedSheet(states, i, self._rules)
        result = self._objective.score(sheet)
        score = result if isinstance(result, Score) else Score(result, sheet.reach - 1)
        return checked(score, sheet.first, sheet.reach, type(self._objective).__name__)

    def bound(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> float:
        if not self._has_bound:
            return math.inf
        result = self._objective.bound(FoldedSheet(states, i, self._rules))
        return number(result, type(self._objective).__name__, "bound")


def checked(score: Score, first: int, reach: int, name: str) -> Score:
    """A score that can be compared with others; raises InputError if it is none.

    −inf is one: the worst. +inf is not, nothing could improve on it.
    """
    value = number(score.value, name, "score")
    if value == math.inf:
        raise InputError("objective", name, "score returned inf; it must return a finite number")
    if (
        isinstance(score.angle, bool)
        or not hasattr(score.angle, "__index__")
        or not (score.angle == -1 or first <= score.angle < reach)
    ):
        indices = "an index from sheet.first to sheet.reach - 1, or -1"
        expected = f"score returned the angle {score.angle!r:.60}; it must be {indices}"
        raise InputError("objective", name, expected)
    return Score(value, int(score.angle))


def number(value: Any, name: str, method: str) -> float:
    """The answer of an objective's method as a float; raises InputError if it is no number, or NaN."""
    dimensions = getattr(value, "ndim", 0)
    try:  # float() would take texts, and arrays of one number
        found = math.nan if isinstance(value, str | bytes) or dimensions else float(value)
    except (TypeError, ValueError, ArithmeticError):
        found = math.nan
    if math.isnan(found):
        shown = "NaN" if isinstance(value, float) else f"{value!r:.60} ({type(value).__name__})"
        raise InputError("objective", name, f"{method} returned {shown}; it must return a number")
    return found


def bind(objective: Any, game: Game) -> Evaluator:
    """The evaluator of any objective; raises InputError for an object that is none."""
    if isinstance(objective, Objective):
        return objective.bind(game)
    if callable(getattr(objective, "score", None)):
        return SheetEvaluator(objective, game)
    raise InputError("objective", type(objective).__name__, "must have a method score(sheet) that returns a number")


def checked_number(name: str, value: Any, low: float) -> float:
    """A finite argument of an objective, not below ``low``; raises InputError for ``objective.<name>``."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value < math.inf:
        raise InputError(f"objective.{name}", value, f"must be a number, at least {low:g}")
    return float(value)


def report(objective: Any, game: Game, actions: tuple[int, ...], angle: int) -> dict[str, float]:
    """Further figures of a finished design; none from an objective that reports nothing."""
    if not callable(getattr(objective, "report", None)) or angle < 0:
        return {}
    return {key: float(value) for key, value in objective.report(game, actions, angle).items()}


def pose(objective: Any, design: CreasePattern) -> dict[str, list[float]]:
    """The directions that are ``up`` and in ``front`` when the folded design stands as it is used, if given.

    Raises
    ------
    InputError
        If a method of these names does not return three numbers, some of them not zero.
    """
    found = {}
    for name in ("up", "front"):
        if not callable(getattr(objective, name, None)):
            continue
        direction = getattr(objective, name)(design)
        if direction is None:
            continue
        where = type(objective).__name__
        if not isinstance(direction, Sequence) or len(direction) != 3 or not any(direction):
            raise InputError("objective", where, f"{name} returned {direction!r:.60}; must be x, y, z of a direction")
        found[name] = [number(value, where, name) for value in direction]
    return found
