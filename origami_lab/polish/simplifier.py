"""Taking out of a design what it does not need: extensions that hardly matter, and creases that never fold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.state import States
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_table import ACTIONS, PLACE, lay_rest, table_of
from origami_lab.game.start_laying import empty_board
from origami_lab.geometry.bvh import build_bvh, distances
from origami_lab.objectives.objective import NO_SCORE, Score, bind
from origami_lab.objectives.shape import ShapeEvaluator, ShapeObjective
from origami_lab.polish.finer_board import ANGLES, STRICT, FineBoard
from origami_lab.polish.flat_creases import without_flat_creases
from origami_lab.polish.laid_design import folded_design
from origami_lab.polish.lay_kernel import lay_design
from origami_lab.polish.measured import own_return, return_at
from origami_lab.polish.pattern_measures import PatternFigures, pattern_figures
from origami_lab.search.dense_check import certified_reach
from origami_lab.verification.certificate import CERTIFIED, Certificate
from origami_lab.verification.verify_design import verify

TOLERANCE = 0.005
"""What a simplified design may lose, in the objective's unit: board cells for shapes, at each point of the target."""
EQUAL = 1e-9
"""Losses that differ by no more are equal."""

Flags = NDArray[np.int8]
Points3D = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Thinned:
    """A design with some of its moves."""

    value: float
    """Its return."""
    goes: Flags
    """(M,) 1 for the moves that went, those included that hung on others."""
    design: CreasePattern
    board: FineBoard | None = None
    """Where a polished design is laid; None for one of the game."""


class Thinnable(Protocol):
    """A design whose moves can be left out."""

    samples: Points3D
    """(n, 3) points of the target that must stay as near to the sheet as they are; none without a target."""

    @property
    def moves(self) -> int:
        """How many it has."""
        ...

    @property
    def removable(self) -> Sequence[int]:
        """The moves that may be asked to go."""
        ...

    def without(self, goes: Flags) -> Thinned | None:
        """The design without some moves and all that hangs on them; None if it does not fold."""
        ...


@dataclass(frozen=True, eq=False)
class Simplified:
    """A simplified design, and what it was before."""

    design: CreasePattern
    value: float
    value_before: float
    figures: PatternFigures
    figures_before: PatternFigures
    removed: int
    """Extensions and sources that went."""
    certificate: Certificate
    board: FineBoard | None = None
    """Where a polished design is laid; None for one of the game."""


def simplify_design(whole: Thinnable, tolerance: float = TOLERANCE, thickness: float = 0.0) -> Simplified:
    """Take out extensions as long as a tolerance in all is kept, then creases that stay flat.

    The return may fall by the tolerance, and no point of a target may get further from the sheet by more: the return of
    a shape is one distance, the largest, and says nothing of all that is nearer. A source without anything on it goes,
    too. The move whose loss costs least goes first; of equal ones the one that leaves the widest narrow panel. The
    certificate is one for panels of a thickness, in board cells.

    Raises
    ------
    InputError
        If the tolerance is no such number, or not even the whole design is certified.
    """
    if isinstance(tolerance, bool) or not 0.0 <= tolerance < math.inf:
        raise InputError("tolerance", tolerance, "must be a number from 0")
    start = whole.without(np.zeros(whole.moves, dtype=np.int8))
    if start is None:
        raise InputError("design", "whole", "must fold without collisions before it can be simplified")
    near = distances_to(start.design, whole.samples)
    found = [start]
    while True:
        here = found[-1]
        candidates = []
        for m in whole.removable:
            if here.goes[m]:
                continue
            goes = here.goes.copy()
            goes[m] = 1
            left = whole.without(goes)
            cost = math.inf if left is None else start.value - left.value
            if left is not None and cost <= tolerance:
                cost = max(cost, float((distances_to(left.design, whole.samples) - near).max(initial=0.0)))
                candidates.append((cost, left))
        least = min((cost for cost, _ in candidates), default=math.inf)
        if least > tolerance:
            break
        equal = [left for cost, left in candidates if cost <= min(least + EQUAL, tolerance)]
        found.append(max(equal, key=lambda left: (pattern_figures(left.design).smallest_width, left.goes.sum())))
    for left in reversed(found):
        for design in (without_flat_creases(left.design), left.design):
            certificate = verify(design, thickness)
            if certificate.verdict == CERTIFIED:
                return Simplified(
                    design=design,
                    value=left.value,
                    value_before=start.value,
                    figures=pattern_figures(design),
                    figures_before=pattern_figures(start.design),
                    removed=int(left.goes.sum()),
                    certificate=certificate,
                    board=left.board,
                )
    raise InputError(
        "design", "whole", f"must be certified before it can be simplified, and is not: {certificate.reason}"
    )


def distances_to(design: CreasePattern, samples: Points3D) -> NDArray[np.float64]:
    """(n,) how far points are from the sheet as it is folded at the design's best driving angle, in cells."""
    triangles = np.ascontiguousarray(design.folded[design.best][design.triangles])
    return np.asarray(distances(build_bvh(triangles), samples))


def samples_of(objective: Any) -> Points3D:
    """(n, 3) the points of an objective's target that a sheet is to cover; none where there is no target."""
    if not isinstance(objective, ShapeObjective):
        return np.zeros((0, 3))
    return np.ascontiguousarray(objective.cover.triangles[:, 0])


class GameDesign:
    """A design of the game: what is left of it is one, too, with actions of its own.

    Under a shape its driving angle stays: what is left of the sheet is where it was.
    """

    def __init__(
        self,
        game: Game,
        objective: Any,
        actions: Sequence[int],
        metadata: Mapping[str, object] | None = None,
    ) -> None:
        self._game, self._evaluator, self._facts = game, bind(objective, game), dict(metadata or {})
        self.samples, self._objective, self._angle = samples_of(objective), objective, None
        states = game.replay(actions)
        if type(objective) is ShapeObjective:
            angle = self._score(states).angle
            self._angle = angle if angle >= 0 else None
        self._origin = game.new_states(1) if game.start_moves else empty_board(game.rules)
        self._moves, self._points = table_of(states, game.rules.record, self._origin)
        self._states = game.new_states(1)
        self._notes = np.zeros(ACTIONS, dtype=note_dtype(len(game.angles)))

    @property
    def moves(self) -> int:
        """How many there are."""
        return len(self._moves)

    @property
    def removable(self) -> Sequence[int]:
        return [int(m) for m in np.flatnonzero(self._moves["kind"] != PLACE)]

    def without(self, goes: Flags) -> Thinned | None:
        game, states = self._game, self._states
        copy_to(states, 0, self._origin, 0)
        kept = np.zeros(len(self._moves), dtype=np.int8)
        lay_rest(states, 0, game.rules.record, self._moves, self._points, goes, self._notes, kept)
        if int(states["n_extensions"][0]) == 0:
            return None
        score = self._score(states)
        if score.angle < 0:
            return None
        actions = game.finished_actions(states)
        if certified_reach(game, actions, score.angle + 1) <= score.angle:
            return None
        facts = self._facts | {"return": score.value, "driving_angle": math.degrees(game.angles[score.angle])}
        # frames beyond the angle that it is used at are of no use, and were not checked
        motion = game.motion(actions, game.angles[: score.angle + 1], facts)
        return Thinned(score.value, 1 - kept, replace(motion, actions=actions))

    def _score(self, states: States) -> Score:
        """The score of a finished position; of a shape at the design's own driving angle."""
        if self._angle is not None and isinstance(self._evaluator, ShapeEvaluator):
            if int(states["reach"][0]) <= self._angle:
                return NO_SCORE
            return Score(return_at(states, self._angle, self._objective, self._evaluator), self._angle)
        return self._evaluator.score(states, self._evaluator.new_memos(1), 0)


class PolishedDesign:
    """A polished design: its driving angle stays."""

    def __init__(
        self,
        board: FineBoard,
        angle: float,
        objective: ShapeObjective,
        metadata: Mapping[str, object] | None = None,
    ) -> None:
        self._board, self._angle, self._objective = board, angle, objective
        self._facts, self.samples = dict(metadata or {}), samples_of(objective)
        self._evaluator = objective.bind(board.game)
        self._first = max(1, board.layout.exempt)

    @property
    def moves(self) -> int:
        """How many there are."""
        return len(self._board.layout.moves)

    @property
    def removable(self) -> Sequence[int]:
        return range(self._first, self.moves)

    def without(self, goes: Flags) -> Thinned | None:
        board, first = self._board, self._first
        layout = board.layout
        states, rules, notes = board.new_states(), board.rules.copy(), board.new_notes()
        steps = self._angle * np.arange(1, ANGLES + 1) / ANGLES
        begin = layout._replace(moves=layout.moves[:first], counts=layout.counts[:first])
        if not lay_design(states, rules, True, begin, board.points, notes, steps):
            return None
        kept = np.zeros(len(layout.moves), dtype=np.int8)
        kept[:first] = 1
        lay_rest(states, 0, rules[STRICT:], layout.moves[first:], board.points, goes[first:], notes, kept[first:])
        left = board.renumbered(kept, states)
        if left is None:
            return None
        value = own_return(left, self._angle, self._objective, self._evaluator)
        facts = MappingProxyType(self._facts | {"return": value})
        return Thinned(value, 1 - kept, folded_design(left, self._angle, facts), left)
