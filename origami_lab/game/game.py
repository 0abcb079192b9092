"""The origami game (paper, section 3.3): board, rules and play. It knows no target and no search."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.freeze_design import finished_design
from origami_lab.game.kernels import play
from origami_lab.game.kernels.state import NOT_FOLDABLE, PLACEMENT, SELECTION, STUCK, States
from origami_lab.game.move_codec import decode, encode
from origami_lab.game.moves import Extend, Move
from origami_lab.game.rule_settings import DEFAULT_MAX_ANGLE, checked_rules
from origami_lab.game.rules import Actions, Rules
from origami_lab.game.start_laying import cut_off, empty_board, largest_angle, lay, play_move
from origami_lab.game.start_patterns import Square, Start


class Game:
    """A board with its rules.

    States live in arrays (:meth:`new_states`); every method that takes ``states, i`` works on one element.

    Parameters
    ----------
    board_size
        Odd N: the board has N×N points from −(N−1)/2 to (N−1)/2.
    board_width, board_height
        Odd numbers of points along x and along y instead; None for N.
    symmetry
        ``none``, ``x``, ``y``, ``xy`` or ``xyd`` (also the diagonals).
    start
        Start pattern: a square, a crease, or moves (:mod:`origami_lab.game.start_from_moves`).
    max_crease_length
        In board cells; None for no limit. Start patterns are exempt.
    min_crease_length
        In board cells; None for no limit. It holds for sources that are laid later, too.
    min_sector_angle
        Degrees between neighbouring creases of a vertex, at least; None for no limit.
    min_panel_width
        In board cells: the smallest height of each triangle that panels are laid in is at least this, and so is the
        width of each panel. None for no limit. Start patterns are exempt from all of these.
    source_action
        Where driven creases may be laid during the game: False for nowhere, ``"axis"`` or True for the segments between
        a leaf and its mirror image, ``"boundary"`` for any boundary segment that has no crease.
    straight_sectors
        Whether a vertex may have a sector of exactly π, where it folds: a leaf with such a sector between its creases,
        and an outer child straight on from one of them. All creases there but the two beside the sector stay flat.
    driving_angle_max, driving_angle_count
        Largest driving angle in degrees and how many equally spaced angles up to it decide.
    driving_angle_fixed
        One driving angle in degrees instead; the motion up to it is still checked. ``"start"``: the largest one, in
        tenths of a degree, that a start pattern made of moves admits.
    stuck
        ``score`` or ``penalise``: what an extension without a legal location left brings.
    capacity
        Representative vertices that a state has room for; an episode that fills it ends cleanly.
    collisions
        Whether panels may not pass through each other (off only to reproduce kinematics).
    """

    def __init__(
        self,
        board_size: int = 25,
        symmetry: str = "xyd",
        start: Start | None = None,
        *,
        board_width: int | None = None,
        board_height: int | None = None,
        max_crease_length: float | None = None,
        min_crease_length: float | None = None,
        min_sector_angle: float | None = None,
        min_panel_width: float | None = None,
        source_action: bool | str = True,
        straight_sectors: bool = True,
        driving_angle_max: float = DEFAULT_MAX_ANGLE,
        driving_angle_count: int = 10,
        driving_angle_fixed: float | Literal["start"] | None = None,
        stuck: Literal["score", "penalise"] = "score",
        capacity: int | None = None,
        collisions: bool = True,
    ) -> None:
        settings = checked_rules(
            {
                "board_size": board_size,
                "board_width": board_width,
                "board_height": board_height,
                "symmetry": symmetry,
                "max_crease_length": max_crease_length,
                "min_crease_length": min_crease_length,
                "min_sector_angle": min_sector_angle,
                "min_panel_width": min_panel_width,
                "source_action": source_action,
                "straight_sectors": straight_sectors,
                "driving_angle_max": driving_angle_max,
                "driving_angle_count": driving_angle_count,
                "driving_angle_fixed": driving_angle_fixed,
                "stuck": stuck,
                "capacity": capacity,
            }
        )
        rules = Rules(settings, start if start is not None else Square("choose"), collisions)
        self.start = rules.start
        self.start_moves: tuple[Move, ...] = tuple(self.start.moves)
        """The moves that lay the start pattern, before the first interaction; none where placing it is an action."""
        if self.start.remove:
            self.start_moves = cut_off(rules, self.start_moves, self.start.remove)
        fixed = settings.driving_angle_fixed
        if fixed == "start":
            fixed = _angle_of_start(rules, self.start_moves)
            rules = rules.with_largest_angle(fixed)
        self.driving_angle_fixed: float | None = fixed
        """Degrees, also where ``"start"`` was asked for."""
        self.rules = rules
        self.board, self.symmetry, self.angles = rules.board, rules.symmetry, rules.angles
        self._origin = lay(rules, self.start_moves) if self.start_moves else empty_board(rules)

    # --- states ------------------------------------------------------------------------------------------------------

    @property
    def penalty(self) -> float:
        """r_min, the return of an episode that ends in a non-foldable state: minus the board's longer side."""
        return -float(self.board_size - 1)

    @cached_property
    def corners(self) -> int:
        """Representative vertices of the start pattern as it is placed, without what moves add to it."""
        states = empty_board(self.rules)
        while not int(states["n_vertices"][0]):
            self.rules.play(states, int(self.rules.legal(states)[-1]))
        return int(states["n_vertices"][0])

    @property
    def board_size(self) -> int:
        """Points along the longer side of the board: N of N×N."""
        return max(self.board)

    @property
    def board_fact(self) -> int | list[int]:
        """The board as a design's metadata has it: N of N×N points, or their numbers along x and along y."""
        return self.board_size if self.board[0] == self.board[1] else list(self.board)

    @property
    def first_angle(self) -> int:
        """Index of the first driving angle at which a design may be used (the last one if it is fixed)."""
        return len(self.angles) - 1 if self.rules.fixed else 0

    @property
    def start_actions(self) -> tuple[int, ...]:
        """The actions that lay :attr:`start_moves`. Every log begins with them; they are no interactions."""
        return self.finished_actions(self._origin)

    def new_states(self, count: int = 1) -> States:
        """An array of states where episodes begin: with the start pattern of moves, else with empty boards."""
        states = np.empty(count, dtype=self.rules.dtype)  # rows are written before they are read
        play.copy_to_all(states, self._origin)
        return states

    def clear(self, states: States, i: int = 0) -> None:
        """Go back to where episodes begin."""
        play.copy_to(states, i, self._origin, 0)

    def bare_start(self) -> tuple[int, ...]:
        """Actions that lead to a start pattern alone."""
        if self.start_actions:
            return self.start_actions
        states = self.new_states(1)
        while int(states["phase"][0]) == PLACEMENT:
            self.play(states, int(self.legal(states)[-1]))
        return self.finished_actions(states)

    def legal(self, states: States, i: int = 0) -> Actions:
        """The legal actions; an episode in progress that has none is marked as ended (stuck)."""
        return self.rules.legal(states, i)

    def play(self, states: States, action: int, i: int = 0) -> Actions:
        """Play an action and return the actions legal afterwards.

        Raises
        ------
        ValueError
            If the action is not legal; the state is unchanged.
        """
        return self.rules.play(states, action, i)

    def sheet(self, states: States, i: int = 0) -> FoldedSheet:
        """The whole sheet, images included, flat and folded."""
        return FoldedSheet(states, i, self.rules.record)

    def is_penalised(self, states: States, i: int = 0) -> bool:
        """Whether the episode's end brings the penalty instead of a score."""
        status = int(states["status"][i])
        if status == NOT_FOLDABLE:
            return True
        inside = int(states["phase"][i]) not in (SELECTION, PLACEMENT)
        return self.rules.stuck_is_penalised and status == STUCK and inside

    def finished_actions(self, states: States, i: int = 0) -> tuple[int, ...]:
        """The actions played so far, without those of an extension that was not completed."""
        count = int(states["n_actions"][i]) - int(states["unfinished"][i])
        return tuple(int(a) for a in states["actions"][i][:count])

    # --- replay ------------------------------------------------------------------------------------------------------

    def replay(self, actions: Iterable[int]) -> States:
        """One state after the given actions, each checked. Raises ValueError on an illegal one."""
        states = self.new_states(1)
        for number, action in enumerate(self._after_start(tuple(actions)), len(self.start_actions)):
            try:
                self.play(states, int(action))
            except ValueError as error:
                raise ValueError(f"action {number}: {error}") from None
        return states

    def replay_moves(self, moves: Iterable[Move]) -> States:
        """One state after the given moves, each checked. Raises ValueError on an illegal one."""
        states, moves = self.new_states(1), tuple(moves)
        before = self.start_moves
        if moves[: len(before)] != before:
            raise ValueError("the moves do not begin with the game's start pattern")
        for move in moves[len(before) :]:
            play_move(self.rules, move, states)
        return states

    def encode(self, move: Move, states: States, i: int = 0) -> list[int]:
        """The actions that make up a move in a state; raises ValueError where they cannot be told."""
        return encode(self.rules, move, states, i)

    def moves(self, actions: Sequence[int]) -> list[Move]:
        """The moves that legal actions make up; an incomplete extension at the end is left out."""
        rest = self._after_start(tuple(actions))
        return [*self.start_moves, *decode(self.rules, rest, self.new_states(1))]

    def _after_start(self, actions: tuple[int, ...]) -> tuple[int, ...]:
        before = self.start_actions
        if actions[: len(before)] != before:
            raise ValueError("the actions do not begin with the game's start pattern")
        return actions[len(before) :]

    def design(
        self, actions: Sequence[int], best_angle: int | None = None, metadata: Mapping[str, object] | None = None
    ) -> CreasePattern:
        """The finished design that legal actions lead to.

        Parameters
        ----------
        actions
            As logged by a state or returned by :meth:`finished_actions`.
        best_angle
            Index of the design's best driving angle; by default the largest reachable one.
        metadata
            Facts to keep with the design, plain JSON values.
        """
        states = self.replay(actions)
        reach = int(states["reach"][0])
        best = reach - 1 if best_angle is None else best_angle
        sheet = self.sheet(states)
        return self._freeze(sheet, sheet.points, self.angles[:reach], best, actions, metadata)

    def motion(
        self, actions: Sequence[int], driving_angles: NDArray[np.float64], metadata: Mapping[str, object] | None = None
    ) -> CreasePattern:
        """The finished design with its motion at any driving angles, the last of them best.

        Parameters
        ----------
        driving_angles
            (n,) increasing angles in radians, positive, within what the design reaches.

        Raises
        ------
        ValueError
            If the design does not reach one of them.
        """
        record, states = self.rules.replaced(min_reach=1, collisions=0).record, self.new_states(1)
        count, log = len(self.angles), np.array(actions, dtype=np.int32)
        parts = []
        for start in range(0, len(driving_angles), count):
            chunk = driving_angles[start : start + count]
            record["angles"][0] = np.concatenate([chunk, np.full(count - len(chunk), chunk[-1])])
            if play.replay_unchecked(states, 0, record, log) < len(chunk):
                raise ValueError(f"the design does not reach a driving angle of {np.degrees(chunk[-1]):.4g} degrees")
            parts.append(FoldedSheet(states, 0, record).points[: len(chunk)])
        sheet = self.sheet(states)
        return self._freeze(sheet, np.concatenate(parts), driving_angles, len(driving_angles) - 1, actions, metadata)

    def _freeze(
        self,
        sheet: FoldedSheet,
        points: NDArray[np.float64],
        angles: NDArray[np.float64],
        best: int,
        actions: Sequence[int],
        metadata: Mapping[str, object] | None,
    ) -> CreasePattern:
        log = tuple(int(a) for a in actions)
        return finished_design(sheet, points, angles, best, log, MappingProxyType(dict(metadata or {})))


def _angle_of_start(rules: Rules, moves: Sequence[Move]) -> float:
    """The largest driving angle in degrees that a start pattern made of moves admits; raises InputError."""
    if not any(isinstance(move, Extend) for move in moves):
        file = "start=chair or start=file start.path=DIR"
        expected = f"needs a start pattern with vertices that fold, {file}; null is for all driving angles"
        raise InputError("driving_angle.fixed", "start", expected)
    angle = largest_angle(rules, lay(rules, moves, shortest_motion=True))
    if angle == 0.0:
        raise InputError("driving_angle.fixed", "start", "the start pattern does not fold by a tenth of a degree")
    return angle
