"""The rules of a game: board, symmetry, angles and limits, fixed from its first action to its last."""

from __future__ import annotations

import copy
import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.kernels import play
from origami_lab.game.kernels.state import DEFAULT_VERTICES, States, rules_dtype, state_dtype
from origami_lab.game.start_patterns import Square, Start
from origami_lab.geometry.groups import GROUPS

Actions = NDArray[np.int32]

DEFAULT_MAX_ANGLE = math.degrees(3.14)
"""The paper's maximum driving angle; exactly 180° is degenerate."""
LARGEST_BOARD = 201
"""Widest board, in points: wider ones cost memory without a use (the paper plays on 9 to 25)."""
HALF_TURN = "must lie between 0 and 180 degrees, both excluded"


class Rules:
    """The rules of one game, checked, and their form for the kernels.

    The parameters are those of :class:`~origami_lab.game.Game`.

    Attributes
    ----------
    half
        Half-width of the board: coordinates run from −half to half.
    points
        Points of the board.
    angles
        (n,) driving angles in radians, increasing; read-only.
    fixed
        Whether only the largest of them may be used by a design.
    capacity
        Representative vertices that a state has room for.
    dtype
        Of the record of a state.
    record
        (1,) record of the rules, as kernels take them.
    n_actions
        Actions are integers below this.
    max_legal
        Most actions that can be legal in one state.

    Raises
    ------
    InputError
        For a wrong value, or a start pattern without the symmetry.
    """

    def __init__(
        self,
        board_size: int,
        symmetry: str,
        start: Start | None,
        *,
        max_crease_length: float | None,
        source_action: bool,
        driving_angle_max: float,
        driving_angle_count: int,
        driving_angle_fixed: float | Literal["start"] | None,
        stuck: Literal["score", "penalise"],
        capacity: int | None,
        collisions: bool,
    ) -> None:
        if isinstance(board_size, bool) or not isinstance(board_size, int) or board_size % 2 == 0 or board_size < 5:
            raise InputError("board.size", board_size, "must be an odd whole number of at least 5, such as 9 or 25")
        if board_size > LARGEST_BOARD:
            raise InputError("board.size", board_size, f"must be at most {LARGEST_BOARD}")
        if symmetry not in GROUPS:
            raise InputError("symmetry", symmetry, f"must be one of {', '.join(GROUPS)}")
        if max_crease_length is not None and not 1 <= max_crease_length < math.inf:
            raise InputError("max_crease_length", max_crease_length, "must be at least 1 (a board cell), or null")
        _check_angle("max", driving_angle_max, HALF_TURN)
        if driving_angle_fixed not in ("start", None):
            _check_angle("fixed", driving_angle_fixed, f"{HALF_TURN}, or be start")
        if not 1 <= driving_angle_count <= 100:
            raise InputError("driving_angle.count", driving_angle_count, "must be a whole number from 1 to 100")
        if stuck not in ("score", "penalise"):
            raise InputError("stuck", stuck, "must be score or penalise")
        if capacity is not None and not 8 <= capacity <= 100_000:
            raise InputError("capacity", capacity, "must be from 8 to 100000 vertices, or null for the default")
        self.board_size, self.half, self.points = board_size, (board_size - 1) // 2, board_size**2
        self.symmetry = GROUPS[symmetry]
        self.start = start if start is not None else Square("choose")
        self.stuck_is_penalised = stuck == "penalise"
        self.fixed = driving_angle_fixed is not None
        self.capacity = capacity if capacity is not None else DEFAULT_VERTICES
        self.start.check_symmetry(symmetry)
        placements = self.start.placements(self.half)
        self.n_actions = 3 * self.points + 5 + 2 * len(placements)
        self.max_legal = max(2 * self.points + 5, 2 * len(placements))
        self.dtype = state_dtype(self.capacity, driving_angle_count)
        self.record = self._record(driving_angle_count, placements, max_crease_length, source_action, collisions)
        largest = driving_angle_fixed if isinstance(driving_angle_fixed, int | float) else driving_angle_max
        self._set_angles(largest, driving_angle_count)

    def _record(
        self, angles: int, placements: range, max_crease_length: float | None, sources: bool, collisions: bool
    ) -> States:
        record = np.zeros(1, dtype=rules_dtype(angles))
        rules, group = record[0], self.symmetry
        rules["half"], rules["order"] = self.half, group.order
        rules["matrices"][: group.order] = group.matrices.reshape(-1, 4)
        rules["products"][: group.order, : group.order] = group.products
        rules["inverses"][: group.order] = group.inverses
        rules["n_axes"] = len(group.normals)
        rules["normals"][: len(group.normals)] = group.normals
        rules["mirrors"][: len(group.mirrors)] = group.mirrors
        rules["start_mirror"], rules["end_mirror"] = group.start_mirror, group.end_mirror
        rules["max_length_sq"] = math.inf if max_crease_length is None else max_crease_length**2 + 1e-9
        rules["sources"], rules["collisions"] = sources, collisions
        rules["start"], rules["first_placement"] = self.start.kind, placements.start
        rules["n_placements"] = len(placements)
        return record

    def _set_angles(self, largest: float, count: int) -> None:
        self.angles = math.radians(largest) * np.arange(1, count + 1) / count
        self.angles.flags.writeable = False
        self.record["angles"], self.record["min_reach"] = self.angles, count if self.fixed else 1

    def with_largest_angle(self, degrees: float) -> Rules:
        """The same rules for as many driving angles up to another largest one."""
        rules = self.replaced()
        rules._set_angles(degrees, len(self.angles))
        return rules

    def replaced(self, **fields: object) -> Rules:
        """A copy whose record has other values in some of its fields, e.g. ``min_reach=1``."""
        rules = copy.copy(self)
        rules.record = self.record.copy()
        for name, value in fields.items():
            rules.record[name] = value
        return rules

    def for_start_pattern(self, *, shortest_motion: bool = False) -> Rules:
        """The rules as they hold for start patterns: creases of any length, and sources.

        With ``shortest_motion`` one driving angle is enough.
        """
        rules = self.replaced(max_length_sq=math.inf, sources=1)
        return rules.replaced(min_reach=1) if shortest_motion else rules

    def legal(self, states: States, i: int = 0) -> Actions:
        """The legal actions of a state; an episode in progress that has none is marked as ended (stuck)."""
        out = np.empty(self.max_legal, dtype=np.int32)
        return out[: play.legal_of(states, i, self.record, out)]

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
        return out[: play.step(states, i, self.record, action, out)]


def _check_angle(name: str, angle: object, expected: str) -> None:
    if not isinstance(angle, int | float) or not 0 < angle < 180:
        raise InputError(f"driving_angle.{name}", angle, expected)
