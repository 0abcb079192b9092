"""The common part of the paper's abstract objectives (section 3.6.2): no target, one compiled kernel, compactness.

Each is a class that hands its kernel and its numbers to :class:`CompiledObjective`. The kernel scores a state at every
usable driving angle that it reaches, or bounds what its continuations can score there, and returns the best.

Bounds rest on what is certain when a sheet grows: its vertices never move at any driving angle, others are added, no
two on one point of the board, and the reachable angles become fewer, from the end.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.state import Record, States, board_points, code_x, code_y
from origami_lab.jit import inlined, kernel
from origami_lab.objectives.compiled_score import CompiledScore, answered_by, scores_itself
from origami_lab.objectives.objective import NO_SCORE, Memos, Score, checked_number
from origami_lab.objectives.shape_kernels import distance_from_centre

Array = NDArray[np.float64]

Best = Callable[[States, int, States, Array, bool, float], tuple[float, int]]
"""``best(states, i, rules, numbers, bound, above)``: the best value above ``above`` over the usable driving angles of
state i, and that angle's index, −1 if there is none. With ``bound`` the values bound those of all continuations.
``numbers`` are the compactness weight, then the objective's own."""

TIE = 1e-9
"""Lengths in board cells that differ by less are equal: rounding shall not decide."""


C = TypeVar("C", bound=type)


def scored_by(best: Best) -> Callable[[C], C]:
    """Decorator of a named tuple with the one field ``numbers``: the compiled score of an objective's kernel."""

    def bound_numbers(
        states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore, above: float
    ) -> float:
        return best(states, i, rules, score.numbers, True, above)[0]

    def best_numbers(
        states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore, above: float
    ) -> tuple[float, int]:
        if states[i].n_triangles == 0:
            return -np.inf, -1
        value, angle = best(states, i, rules, score.numbers, False, above)
        return (value, angle) if angle >= 0 else (-np.inf, -1)

    def value_numbers(states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore) -> float:
        if states[i].n_triangles == 0:
            return -np.inf
        value, angle = best(states, i, rules, score.numbers, False, -np.inf)
        return value if angle >= 0 else -np.inf

    return answered_by(bound_numbers, best_numbers, value_numbers)


class CompiledObjective(ABC):
    """An objective whose score is a kernel.

    Parameters
    ----------
    best
        The kernel, see :data:`Best`.
    compactness
        Weight of the penalty on the vertex that is furthest from the board's centre: what is lost for each board cell
        of its distance in space (paper, section 3.6.2). It can only get worse, so it is part of the bound.
    score_class
        A class decorated with :func:`scored_by` that kernel, so that compiled searches can ask it themselves; None if
        they shall ask the evaluator.

    Raises
    ------
    InputError
        If the weight is not a number from 0.
    """

    def __init__(
        self, best: Best, compactness: float, score_class: Callable[[Array], CompiledScore] | None = None
    ) -> None:
        self._best, self._score_class = best, score_class
        self.compactness = checked_number("compactness", compactness, 0)

    @abstractmethod
    def numbers(self, game: Game) -> tuple[float, ...]:
        """Numbers for the kernel besides the compactness weight."""

    def bind(self, game: Game) -> CompiledEvaluator:
        """The evaluator of this objective in a game."""
        numbers = np.array([self.compactness, *self.numbers(game)])
        score = None if self._score_class is None else self._score_class(numbers)
        return CompiledEvaluator(self._best, numbers, game, score)

    def report(self, game: Game, actions: tuple[int, ...], angle: int) -> dict[str, float]:
        """No figures besides the return."""
        return {}


class CompiledEvaluator:
    """A compiled objective in one game. It takes no notes: a score costs microseconds."""

    def __init__(self, best: Best, numbers: Array, game: Game, score: CompiledScore | None = None) -> None:
        self._best, self._numbers, self._rules, self._compiled = best, numbers, game.rules.record, score

    @property
    def compiled_score(self) -> CompiledScore | None:
        """What compiled searches ask, see :mod:`~.compiled_score`; None for the methods below."""
        return self._compiled if scores_itself(self) else None

    def new_memos(self, count: int) -> Memos:
        return np.zeros(count, dtype=np.int8)

    def clear(self, memos: Memos, i: int) -> None:
        pass

    def score(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> Score:
        """Best value and its angle; a sheet without area has none."""
        if not states["n_triangles"][i]:
            return NO_SCORE
        value, angle = self._best(states, i, self._rules, self._numbers, False, above)
        return Score(value, angle) if angle >= 0 else NO_SCORE

    def bound(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> float:
        return self._best(states, i, self._rules, self._numbers, True, above)[0]


@inlined
def orbit_size(s: Record, r: Record, v: int) -> int:
    """How many vertices of the sheet a representative stands for."""
    if s.axis[v] == 0:
        return int(r.order)
    return int(r.order) // 2 if s.axis[v] > 0 else 1


@kernel
def count_vertices(s: Record, r: Record) -> int:
    """Vertices of the sheet, images included."""
    count = 0
    for v in range(s.n_vertices):
        count += orbit_size(s, r, v)
    return count


@inlined
def board_points_beside(r: Record, count: int) -> int:
    """Points of the board besides ``count`` of them: at least as many as further vertices can be placed."""
    return int(board_points(r)) - count


@kernel
def sticks_out(s: Record, k: int, weight: float) -> float:
    """The compactness penalty at driving angle k."""
    if weight == 0.0:
        return 0.0
    farthest = 0.0
    for v in range(s.n_vertices):
        farthest = max(farthest, distance_from_centre(s, v, k))
    return weight * farthest


@kernel
def panel_area(s: Record, r: Record, t: int) -> float:
    """Area of triangle t, folded or flat, exactly."""
    a, b, c = s.corners[t, 0], s.corners[t, 1], s.corners[t, 2]
    x, y = code_x(s, r, a), code_y(s, r, a)
    ux, uy = code_x(s, r, b) - x, code_y(s, r, b) - y
    vx, vy = code_x(s, r, c) - x, code_y(s, r, c) - y
    return 0.5 * float(abs(ux * vy - uy * vx))
