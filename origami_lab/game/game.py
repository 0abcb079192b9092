"""The origami game (paper, section 3.3): board, rules and play. It knows no target and no search."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game import play
from origami_lab.game.design import finished_design
from origami_lab.game.folded import FoldedSheet
from origami_lab.game.masks import NEXT, near_side, tail
from origami_lab.game.moves import Extend, Move, Place, Source, Terminate
from origami_lab.game.pattern import CreasePattern
from origami_lab.game.starts import Square, Start
from origami_lab.game.state import (
    DEFAULT_VERTICES,
    NOT_FOLDABLE,
    PLACEMENT,
    SELECTION,
    STUCK,
    States,
    rules_dtype,
    state_dtype,
)
from origami_lab.geometry.groups import GROUPS

Actions = NDArray[np.int32]

DEFAULT_MAX_ANGLE = math.degrees(3.14)
"""The paper's maximum driving angle; exactly 180° is degenerate."""
LARGEST_BOARD = 201


class Game:
    """A board with its rules.

    States live in arrays (:meth:`new_states`); every method that takes ``states, i`` works on one element.

    Parameters
    ----------
    board_size
        Odd N: the board has N×N points from −(N−1)/2 to (N−1)/2.
    symmetry
        ``none``, ``x``, ``y``, ``xy`` or ``xyd`` (also the diagonals).
    start
        Start pattern.
    max_crease_length
        In board cells; None for no limit. Start patterns are exempt.
    source_action
        Whether driven creases may be laid during the game.
    driving_angle_max, driving_angle_count
        Largest driving angle in degrees and how many equally spaced angles up to it decide.
    driving_angle_fixed
        One driving angle in degrees instead; the motion up to it is still checked.
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
        max_crease_length: float | None = None,
        source_action: bool = True,
        driving_angle_max: float = DEFAULT_MAX_ANGLE,
        driving_angle_count: int = 10,
        driving_angle_fixed: float | None = None,
        stuck: Literal["score", "penalise"] = "score",
        capacity: int | None = None,
        collisions: bool = True,
    ) -> None:
        if isinstance(board_size, bool) or not isinstance(board_size, int) or board_size % 2 == 0 or board_size < 5:
            raise InputError("board.size", board_size, "must be an odd whole number of at least 5, such as 9 or 25")
        if board_size > LARGEST_BOARD:
            raise InputError("board.size", board_size, f"must be at most {LARGEST_BOARD}")
        if symmetry not in GROUPS:
            raise InputError("symmetry", symmetry, f"must be one of {', '.join(GROUPS)}")
        if max_crease_length is not None and not 1 <= max_crease_length < math.inf:
            raise InputError("max_crease_length", max_crease_length, "must be at least 1 (a board cell), or null")
        for name, angle in (("max", driving_angle_max), ("fixed", driving_angle_fixed)):
            if angle is not None and not 0 < angle < 180:
                raise InputError(f"driving_angle.{name}", angle, "must lie between 0 and 180 degrees, both excluded")
        if not 1 <= driving_angle_count <= 100:
            raise InputError("driving_angle.count", driving_angle_count, "must be a whole number from 1 to 100")
        if stuck not in ("score", "penalise"):
            raise InputError("stuck", stuck, "must be score or penalise")
        if capacity is not None and not 8 <= capacity <= 100_000:
            raise InputError("capacity", capacity, "must be from 8 to 100000 vertices, or null for the default")
        self.board_size = board_size
        self.half = (board_size - 1) // 2
        self.symmetry = GROUPS[symmetry]
        self.start = start if start is not None else Square("choose")
        self.stuck_is_penalised = stuck == "penalise"
        self.fixed = driving_angle_fixed is not None
        self.capacity = capacity if capacity is not None else DEFAULT_VERTICES
        self.start.check_symmetry(symmetry)
        placements = self.start.placements(self.half)
        largest = math.radians(driving_angle_fixed if driving_angle_fixed is not None else driving_angle_max)
        self.angles = largest * np.arange(1, driving_angle_count + 1) / driving_angle_count
        self.angles.flags.writeable = False
        self.dtype = state_dtype(self.capacity, driving_angle_count)
        self.rules = np.zeros(1, dtype=rules_dtype(driving_angle_count))
        rules = self.rules[0]
        group = self.symmetry
        rules["half"], rules["order"] = self.half, group.order
        rules["matrices"][: group.order] = group.matrices.reshape(-1, 4)
        rules["products"][: group.order, : group.order] = group.products
        rules["inverses"][: group.order] = group.inverses
        rules["n_axes"] = len(group.normals)
        rules["normals"][: len(group.normals)] = group.normals
        rules["mirrors"][: len(group.mirrors)] = group.mirrors
        rules["start_mirror"], rules["end_mirror"] = group.start_mirror, group.end_mirror
        rules["max_length_sq"] = math.inf if max_crease_length is None else max_crease_length**2 + 1e-9
        rules["sources"], rules["collisions"] = source_action, collisions
        rules["min_reach"] = driving_angle_count if self.fixed else 1
        rules["start"], rules["first_placement"], rules["n_placements"] = (
            self.start.kind,
            placements.start,
            len(placements),
        )
        rules["angles"] = self.angles
        self.points = board_size**2
        self.n_actions = 3 * self.points + 5 + 2 * len(placements)
        """Actions are integers below this."""
        self.max_legal = max(2 * self.points + 5, 2 * len(placements))

    # --- states ------------------------------------------------------------------------------------------------------

    @property
    def penalty(self) -> float:
        """r_min, the return of an episode that ends in a non-foldable state."""
        return -float(self.board_size - 1)

    @property
    def first_angle(self) -> int:
        """Index of the first driving angle at which a design may be used (the last one if it is fixed)."""
        return len(self.angles) - 1 if self.fixed else 0

    def new_states(self, count: int = 1) -> States:
        """An array of states with empty boards."""
        states = np.empty(count, dtype=self.dtype)  # rows are written before they are read
        play.clear_all(states)
        return states

    def clear(self, states: States, i: int = 0) -> None:
        """Empty the board."""
        play.clear_state(states, i)

    def legal(self, states: States, i: int = 0) -> Actions:
        """The legal actions; an episode in progress that has none is marked as ended (stuck)."""
        out = np.empty(self.max_legal, dtype=np.int32)
        return out[: play.legal_of(states, i, self.rules, out)]

    def play(self, states: States, action: int, i: int = 0) -> Actions:
        """Play an action and return the actions legal afterwards.

        Raises
        ------
        ValueError
            If the action is not legal; the state is unchanged.
        """
        if action not in self.legal(states, i):
            raise ValueError(f"action {action} is not legal in this state")
        out = np.empty(self.max_legal, dtype=np.int32)
        return out[: play.step(states, i, self.rules, action, out)]

    def sheet(self, states: States, i: int = 0) -> FoldedSheet:
        """The whole sheet, images included, flat and folded."""
        return FoldedSheet(states, i, self.rules)

    def is_penalised(self, states: States, i: int = 0) -> bool:
        """Whether the episode's end brings the penalty instead of a score."""
        status = int(states["status"][i])
        if status == NOT_FOLDABLE:
            return True
        inside = int(states["phase"][i]) not in (SELECTION, PLACEMENT)
        return self.stuck_is_penalised and status == STUCK and inside

    def finished_actions(self, states: States, i: int = 0) -> tuple[int, ...]:
        """The actions played so far, without those of an extension that was not completed."""
        count = int(states["n_actions"][i]) - int(states["unfinished"][i])
        return tuple(int(a) for a in states["actions"][i][:count])

    # --- replay ------------------------------------------------------------------------------------------------------

    def replay(self, actions: Iterable[int]) -> States:
        """One state after the given actions, each checked. Raises ValueError on an illegal one."""
        states = self.new_states(1)
        for number, action in enumerate(actions):
            try:
                self.play(states, int(action))
            except ValueError as error:
                raise ValueError(f"action {number}: {error}") from None
        return states

    def replay_moves(self, moves: Iterable[Move]) -> States:
        """One state after the given moves, each checked. Raises ValueError on an illegal one."""
        states = self.new_states(1)
        for move in moves:
            for action in self.encode(move, states):
                try:
                    self.play(states, action)
                except ValueError:
                    raise ValueError(f"{move} is not legal in this state") from None
        return states

    def encode(self, move: Move, states: States, i: int = 0) -> list[int]:
        """The actions that make up a move in a state."""
        points = self.points
        if isinstance(move, Terminate):
            return [3 * points]
        if isinstance(move, Place):
            option = move.value - int(self.rules["first_placement"][0])
            return [3 * points + 5 + 2 * option + (move.sign > 0)]
        if isinstance(move, Source):
            return [3 * points + 1 + 2 * (move.end == "end") + (move.sign > 0)]
        leaf = self._leaf(states, i, move.leaf)
        select = self._point(move.leaf) + (points if move.mode > 0 else 0)
        if int(states["axis"][i][leaf]) > 0:
            near = move.b if near_side(states[i], self.rules[0], leaf) == NEXT else move.a
            return [select, 2 * points + self._point(near), 2 * points + self._point(move.c)]
        return [select, *(2 * points + self._point(p) for p in (move.a, move.b, move.c))]

    def moves(self, actions: Sequence[int]) -> list[Move]:
        """The moves that legal actions make up; an incomplete extension at the end is left out."""
        states = self.new_states(1)
        out: list[Move] = []
        for action in actions:
            phase = int(states["phase"][0])
            head_tail = self._ends(states) if phase == SELECTION else None
            before = states.copy() if phase > SELECTION else states
            n_before = int(states["n_extensions"][0])
            self.play(states, int(action))
            if phase == PLACEMENT:
                option = int(action) - 3 * self.points - 5
                out.append(Place(option // 2 + int(self.rules["first_placement"][0]), 1 if option % 2 else -1))
            elif phase == SELECTION and action == 3 * self.points:
                out.append(Terminate())
            elif phase == SELECTION and action > 3 * self.points and head_tail is not None:
                option = int(action) - 3 * self.points - 1
                out.append(Source(head_tail[option // 2], ("start", "end")[option // 2], 1 if option % 2 else -1))
            elif phase > SELECTION and (
                int(states["n_extensions"][0]) > n_before or int(states["status"][0]) == NOT_FOLDABLE
            ):
                s = before[0]
                x, y = (int(t) for t in s["xy"][s["selected"]])
                out.append(
                    Extend(
                        (x, y),
                        int(s["mode"]),
                        (int(s["first_x"]), int(s["first_y"])),
                        (int(s["second_x"]), int(s["second_y"])),
                        self._at(int(action) - 2 * self.points),
                    )
                )
        return out

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
        rules, states = self.rules.copy(), self.new_states(1)
        rules["min_reach"], rules["collisions"] = 1, 0
        count, log = len(self.angles), np.array(actions, dtype=np.int32)
        parts = []
        for start in range(0, len(driving_angles), count):
            chunk = driving_angles[start : start + count]
            rules["angles"][0] = np.concatenate([chunk, np.full(count - len(chunk), chunk[-1])])
            if play.replay_unchecked(states, 0, rules, log) < len(chunk):
                raise ValueError(f"the design does not reach a driving angle of {np.degrees(chunk[-1]):.4g} degrees")
            parts.append(FoldedSheet(states, 0, rules).points[: len(chunk)])
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

    def _point(self, point: tuple[int, int]) -> int:
        x, y = point
        if max(abs(x), abs(y)) > self.half:
            raise ValueError(f"point {point} is not on the board")
        return (y + self.half) * self.board_size + x + self.half

    def _at(self, index: int) -> tuple[int, int]:
        return index % self.board_size - self.half, index // self.board_size - self.half

    def _leaf(self, states: States, i: int, point: tuple[int, int]) -> int:
        leaf = play.leaf_at(states[i], *point) if int(states["head"][i]) >= 0 else -1
        if leaf < 0:
            raise ValueError(f"{point} is not a leaf in the playable area")
        return int(leaf)

    def _ends(self, states: States) -> tuple[tuple[int, int], tuple[int, int]]:
        s = states[0]
        x, y = s["xy"][s["head"]]
        u, v = s["xy"][tail(s)]
        return (int(x), int(y)), (int(u), int(v))
