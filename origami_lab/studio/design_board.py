"""One design on its board: the game, what was played, what was taken back, and what may be played next.

A step is a whole move, an edit, or a design that a partner has made; the actions of an extension that is not complete
are on the state beside it. Every step is kept as the log of actions that leads to it: a log is replayed to the same
state, bit for bit, so any number of steps costs next to nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.edits import with_vertex_moved, without_vertices
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import branch
from origami_lab.game.kernels.state import (
    FIRST,
    NOT_FOLDABLE,
    PLACEMENT,
    RUNNING,
    SECOND,
    SELECTION,
    TERMINATED,
    THIRD,
    States,
)
from origami_lab.game.legality import Reason, reaches, why_no_further, why_not_leaf, why_not_place
from origami_lab.game.moves import Move, Point, Terminate
from origami_lab.objectives.objective import Score
from origami_lab.studio.design_scores import DesignScores
from origami_lab.studio.legal_starts import Segment, free_segments, point_of, start_outlines

MOST_TRIED = 150
"""Places that are tried for whether another crease finds a place."""
PHASES = ("start", "leaf", "first", "second", "third")
"""What is decided next, by the numbers of :mod:`origami_lab.game.kernels.state`."""


class Refused(Exception):  # noqa: N818 - an answer, not an error
    """What was asked for is not possible; the message says why."""


@dataclass(frozen=True)
class Step:
    """Where the design stood: the log that leads there, and what led there, in a word or two."""

    actions: tuple[int, ...]
    what: str


class DesignBoard:
    """A game with its timeline.

    Parameters
    ----------
    game, objective
        What is played, and what designs are worth.
    actions
        Where to begin; by default where episodes do.
    """

    def __init__(self, game: Game, objective: Any, actions: Sequence[int] | None = None) -> None:
        self.game, self.objective = game, objective
        self.scores = DesignScores(objective, game)
        self.steps = [Step(game.start_actions, "start")]
        self.at = 0
        self.states = game.new_states(1)
        if actions is not None and tuple(actions) != game.start_actions:
            self.adopt(tuple(int(a) for a in actions), "opened")

    # --- where it stands ---------------------------------------------------------------------------------------------

    @property
    def actions(self) -> tuple[int, ...]:
        """The log of the design, without an extension that is not complete."""
        return self.steps[self.at].actions

    @property
    def moves(self) -> tuple[Move, ...]:
        """The moves of the design, without the end of the game."""
        return tuple(move for move in self.game.moves(self.actions) if not isinstance(move, Terminate))

    @property
    def phase(self) -> int:
        return int(self.states["phase"][0])

    @property
    def is_placed(self) -> bool:
        """Whether there is a sheet on the board."""
        return int(self.states["n_vertices"][0]) > 0

    @property
    def has_design(self) -> bool:
        """Whether a leaf has been extended."""
        return int(self._settled()["n_extensions"][0]) > 0

    @property
    def has_ended(self) -> bool:
        """Whether the game was ended by whoever plays."""
        return int(self.states["status"][0]) == TERMINATED

    def _settled(self) -> States:
        """The state of the last step, without what is not complete."""
        return self.states if self.phase == SELECTION else self.game.replay(self.actions)

    @property
    def is_scored(self) -> bool:
        """Whether :meth:`score` knows the return of the design: a user's objective takes its time."""
        return self.scores.knows(self.actions)

    def score(self) -> Score | None:
        """The return of the design as it stands, and the index of its driving angle; None where it has none."""
        return self.scores.of(self.actions, self._settled())

    def playable(self, point: Point) -> Point:
        """The image of a board point that lies in the playable area."""
        images = self.game.symmetry.matrices @ np.array(point, dtype=np.int64)
        x, y = (int(t) for t in images[self.game.symmetry.playable(images)][0])
        return x, y

    def images(self, point: Point) -> list[Point]:
        """All mirror images of a point, itself first."""
        found = self.game.symmetry.matrices @ np.array(point, dtype=np.int64)
        return list(dict.fromkeys((int(x), int(y)) for x, y in found))

    @property
    def selected_point(self) -> Point:
        """The leaf that is being extended."""
        x, y = (int(t) for t in self.states["xy"][0][int(self.states["selected"][0])])
        return x, y

    @property
    def chosen_points(self) -> list[Point]:
        """The children that are placed already; of a leaf on a mirror axis both outer ones at once."""
        state = self.states[0]
        chosen = ((state["first_x"], state["first_y"]), (state["second_x"], state["second_y"]))
        return [(int(x), int(y)) for x, y in chosen[: max(self.phase - FIRST, 0)]]

    # --- what may be played ------------------------------------------------------------------------------------------

    def leaves(self) -> list[tuple[Point, Reason | None]]:
        """The leaves in the playable area, each with the reason why it cannot be extended."""
        if not self.is_placed:
            return []
        state = self.states[0]
        found, w = [], int(state["head"])
        while True:
            x, y = (int(t) for t in state["xy"][w])
            found.append(((x, y), why_not_leaf(self.game, self.states, (x, y))))
            code = int(state["next"][w])
            if code & 7 or code >> 3 == int(state["head"]):
                return found
            w = code >> 3

    def places(self) -> list[tuple[Point, int]]:
        """Where the next child, or the next corner of the start pattern, may lie.

        With each the number of driving angles that the motion reaches then; of all but a middle child as many as now.
        Those of middle children with which the sheet does not fold as far as the game asks are not among them, nor are
        those that leave no place for the next crease, unless there are too many to try.
        """
        legal, n = self.game.legal(self.states), self.game.rules.points
        at_points = legal[(legal >= 2 * n) & (legal < 3 * n)]
        reach = np.full(len(at_points), int(self.states["reach"][0]))
        if self.phase == THIRD:
            reach = reaches(self.game, self.states, at_points)
        elif self.phase in (FIRST, SECOND) and len(at_points) <= MOST_TRIED:
            reach[[not self._goes_on(int(action)) for action in at_points]] = 0
        found = [(point_of(self.game, a - 2 * n), int(k)) for a, k in zip(at_points, reach, strict=True)]
        return [(point, k) for point, k in found if k > self.game.first_angle]

    def first_places(self, leaf: Point) -> list[Point]:
        """Where the first child of a leaf may lie, before it is selected; none if it cannot be."""
        if self.phase != SELECTION or why_not_leaf(self.game, self.states, leaf) is not None:
            return []
        trial, n = self.states.copy(), self.game.rules.points
        if int(trial["status"][0]) != RUNNING:
            return []
        legal = self.game.play(trial, self._index(leaf))
        return [point_of(self.game, int(a) - 2 * n) for a in legal]

    def placements(self) -> list[list[Point]]:
        """The outlines of the start patterns that may be laid now, by option; none while corners are to be chosen."""
        return [] if self.is_placed else start_outlines(self.game, self.states)

    def sources(self) -> list[Segment]:
        """The boundary segments on which a driven crease may be laid now."""
        return free_segments(self.game, self.states) if self.phase == SELECTION and self.is_placed else []

    def why_not(self, point: Point) -> str | None:
        """Why the point cannot be chosen now, in a sentence; None if it can."""
        if int(self.states["status"][0]) != RUNNING:
            return "the game has ended here: undo to go on"
        if self.phase == SELECTION:
            reason = why_not_leaf(self.game, self.states, point)
            return None if reason is None else reason.says
        if self.phase == PLACEMENT:
            places = [place for place, _ in self.places()]
            return None if point in places or not places else "no corner of the start pattern may lie here"
        reason = why_not_place(self.game, self.states, point)
        if reason is not None:
            return self._said(reason)
        action = self.location(point)
        if self.phase == THIRD:
            reason, reach = why_no_further(self.game, self.states, action)
            if reach > self.game.first_angle:
                return None
            assert reason is not None
            return f"{reason.says} at {self.degrees(reach)}, the first driving angle that a design here needs"
        return None if self._goes_on(action) else "leaves no place for the next crease"

    def _goes_on(self, action: int) -> bool:
        """Whether there is a place for the next crease after a legal outer child."""
        both = np.concatenate([self.states, self.states])
        room = np.empty(self.game.rules.max_legal, dtype=np.int32)
        count, _ = branch(both, 0, 1, self.game.rules.record, action, room)
        return bool(count > 0)

    def warning(self, point: Point) -> str | None:
        """What a middle child at a legal place costs of the motion, in a sentence; None for nothing."""
        if self.phase != THIRD:
            return None
        reason, reach = why_no_further(self.game, self.states, self.location(point))
        return (
            None if reason is None else f"{reason.says} at {self.degrees(reach)}: it folds to {self.degrees(reach - 1)}"
        )

    def degrees(self, index: int) -> str:
        """A driving angle of the game as text."""
        return f"{math.degrees(self.game.angles[index]):.0f}°" if index >= 0 else "0°"

    def _said(self, reason: Reason) -> str:
        limits = {Reason.TOO_LONG: "max_length_sq", Reason.TOO_SHORT: "min_length_sq"}
        if reason not in limits:
            return reason.says
        limit = float(self.game.rules.record[limits[reason]][0]) ** 0.5
        return f"{reason.says} = {limit:.4g} cells"

    # --- playing -----------------------------------------------------------------------------------------------------

    def select(self, leaf: Point, mode: int) -> None:
        """Begin to extend a leaf; raises :class:`Refused`."""
        self._require(self.phase == SELECTION and self.is_placed, "first complete or leave what has begun")
        if why := self.why_not(leaf):
            raise Refused(why)
        self._play(self._index(leaf) + (self.game.rules.points if mode > 0 else 0))

    def place(self, point: Point) -> None:
        """Place the next child of the selected leaf, or the next corner of the start pattern; raises Refused."""
        self._require(self.phase != SELECTION, "choose a leaf first")
        if self.phase == PLACEMENT:
            self._require(point in [place for place, _ in self.places()], "no corner of the start pattern may lie here")
        elif why := self.why_not(point):
            raise Refused(why)
        self._play(self.location(point))

    def place_start(self, option: int, sign: int) -> None:
        """Lay a start pattern; raises Refused."""
        self._require(0 <= option < len(self.placements()), "this start pattern may not be laid here")
        self._play(3 * self.game.rules.points + 5 + 2 * option + (sign > 0), "start pattern")

    def lay_source(self, number: int, sign: int) -> None:
        """Lay a driven crease on one of :meth:`sources`; raises Refused."""
        sources = self.sources()
        self._require(0 <= number < len(sources), "no driven crease may be laid here")
        for action in sources[number].actions[1 if sign > 0 else -1]:
            self._play(action, "source")

    def terminate(self) -> None:
        """End the game; raises Refused."""
        self._require(3 * self.game.rules.points in self.game.legal(self.states), "extend a leaf first")
        self._play(3 * self.game.rules.points, "end")

    def play_move(self, move: Move) -> None:
        """Play a whole move; raises Refused if it is not legal here."""
        self.back_to_step()
        trial = self.states.copy()
        try:
            for action in self.game.encode(move, trial):
                self.game.play(trial, action)
        except ValueError as error:
            raise Refused("this move is no longer legal here") from error
        self._require(int(trial["status"][0]) != NOT_FOLDABLE, "the sheet would not fold")
        self.adopt(self.game.finished_actions(trial), move.kind)

    def _play(self, action: int, what: str = "extension") -> None:
        try:
            self.game.play(self.states, action)
        except ValueError as error:
            raise Refused("this is not legal here") from error
        if self.phase == SELECTION:
            self._push(Step(self.game.finished_actions(self.states), what))

    def _push(self, step: Step) -> None:
        self.steps[self.at + 1 :] = [step]
        self.at += 1

    # --- the timeline ------------------------------------------------------------------------------------------------

    def adopt(self, actions: tuple[int, ...], what: str) -> None:
        """Take a whole design as the next step, each of its actions checked; raises Refused."""
        try:
            states = self.game.replay(actions)
        except ValueError as error:
            raise Refused(f"this design cannot be played here: {error}") from error
        self.states = states
        if actions != self.actions:
            self._push(Step(actions, what))
        self.game.legal(self.states)

    def back(self) -> None:
        """Take back the last action of what is not complete; without any, undo."""
        played = self._unfinished()
        if not played:
            self.undo()
            return
        self.back_to_step()
        for action in played[:-1]:
            self.game.play(self.states, action)

    def back_to_step(self) -> None:
        """Leave what is not complete."""
        if self._unfinished():
            self._go_to(self.at)

    def _unfinished(self) -> list[int]:
        count = int(self.states["n_actions"][0])
        return [int(a) for a in self.states["actions"][0][len(self.actions) : count]]

    def undo(self) -> None:
        """Go back one step, or leave what is not complete; raises Refused at the start."""
        if self._unfinished():
            self._go_to(self.at)
            return
        self._require(self.at > 0, "there is nothing to undo")
        self._go_to(self.at - 1)

    def redo(self) -> None:
        """Go forward again; raises Refused where nothing was undone."""
        self._require(self.at + 1 < len(self.steps), "there is nothing to redo")
        self._go_to(self.at + 1)

    def _go_to(self, step: int) -> None:
        self.at = step
        self.states = self.game.replay(self.actions)
        self.game.legal(self.states)

    # --- edits -------------------------------------------------------------------------------------------------------

    def cut(self, points: Sequence[Point]) -> int:
        """Take vertices' extensions away with all that grew from them; returns how many moves went."""
        return self._edit(lambda: without_vertices(self.game, self.actions, points), "cut")

    def shift(self, vertex: Point, to: Point) -> int:
        """Move a vertex, its images with it; returns how many moves did not survive it."""
        return self._edit(lambda: with_vertex_moved(self.game, self.actions, vertex, to), "moved vertex")

    def _edit(self, edit: Any, what: str) -> int:
        self.back_to_step()
        before = len(self.moves)
        try:
            actions = edit()
        except InputError as error:
            raise Refused(error.expected) from error
        self._require(actions != self.actions, "nothing would change")
        self.adopt(actions, what)
        return before - len(self.moves)

    # --- points ------------------------------------------------------------------------------------------------------

    def _require(self, holds: object, otherwise: str) -> None:
        if not holds:
            raise Refused(otherwise)

    def location(self, point: Point) -> int:
        """The action that chooses a place."""
        return 2 * self.game.rules.points + self._index(point)

    def _index(self, point: Point) -> int:
        (x, y), (half_x, half_y) = point, self.game.rules.half
        self._require(abs(x) <= half_x and abs(y) <= half_y, Reason.OFF_THE_BOARD.says)
        return (y + half_y) * self.game.board[0] + x + half_x
