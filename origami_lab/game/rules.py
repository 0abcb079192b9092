"""The rules of a game: board, symmetry, angles and limits, fixed from its first action to its last."""

from __future__ import annotations

import copy
import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.kernels import play
from origami_lab.game.kernels.state import DEFAULT_VERTICES, ON_AXES, ON_BOUNDARY, States, rules_dtype, state_dtype
from origami_lab.game.rule_settings import RuleSettings
from origami_lab.game.start_patterns import Start
from origami_lab.geometry.groups import GROUPS

Actions = NDArray[np.int32]
NO_COSINE = 2.0
NO_LIMITS = {"max_length_sq": math.inf, "min_length_sq": 0.0, "min_width_sq": 0.0, "max_cosine": NO_COSINE}
"""Fields of the record that limit creases and panels, as they limit nothing."""


def _least_square(least: float | None) -> float:
    """The square of a least length, a little less where squares of whole numbers are compared with it."""
    return 0.0 if least is None else max(0.0, least**2 - 1e-9)


class Rules:
    """The rules of one game, checked, and their form for the kernels.

    Parameters
    ----------
    settings
        The checked settings.
    start
        The start pattern.
    collisions
        Whether panels may not pass through each other.

    Attributes
    ----------
    board
        Points of the board along x and along y.
    half
        Half of the board's sides: coordinates run from −half to half, x by the first and y by the second.
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
        For a start pattern without the symmetry, or too large for the board.
    """

    def __init__(self, settings: RuleSettings, start: Start, collisions: bool) -> None:
        width, height, count = settings.width, settings.height, settings.driving_angle_count
        self.board, self.half, self.points = (width, height), ((width - 1) // 2, (height - 1) // 2), width * height
        self.symmetry, self.start = GROUPS[settings.symmetry], start
        self.stuck_is_penalised = settings.stuck == "penalise"
        self.fixed = settings.driving_angle_fixed is not None
        self.capacity = settings.capacity if settings.capacity is not None else DEFAULT_VERTICES
        self.start.check_symmetry(settings.symmetry)
        placements = self.start.placements(self.half)
        on_boundary = settings.source_action == "boundary"
        self.n_actions = 3 * self.points + 5 + 2 * len(placements) + 2 * on_boundary
        self.max_legal = max(2 * self.points + 7, 2 * len(placements))
        self.dtype = state_dtype(self.capacity, count)
        self.record = self._record(settings, placements, collisions)
        fixed = settings.driving_angle_fixed
        self._set_angles(fixed if isinstance(fixed, float) else settings.driving_angle_max, count)

    def _record(self, settings: RuleSettings, placements: range, collisions: bool) -> States:
        record = np.zeros(1, dtype=rules_dtype(settings.driving_angle_count))
        rules, group = record[0], self.symmetry
        rules["half_x"], rules["half_y"] = self.half
        rules["order"] = group.order
        rules["matrices"][: group.order] = group.matrices.reshape(-1, 4)
        rules["products"][: group.order, : group.order] = group.products
        rules["inverses"][: group.order] = group.inverses
        rules["n_axes"] = len(group.normals)
        rules["normals"][: len(group.normals)] = group.normals
        rules["mirrors"][: len(group.mirrors)] = group.mirrors
        rules["start_mirror"], rules["end_mirror"] = group.start_mirror, group.end_mirror
        longest = settings.max_crease_length
        rules["max_length_sq"] = math.inf if longest is None else longest**2 + 1e-9
        rules["min_length_sq"] = _least_square(settings.min_crease_length)
        rules["min_width_sq"] = _least_square(settings.min_panel_width)
        sharpest = settings.min_sector_angle
        rules["max_cosine"] = NO_COSINE if sharpest is None else math.cos(math.radians(sharpest))
        sources = ON_BOUNDARY if settings.source_action == "boundary" else int(settings.source_action) * ON_AXES
        rules["sources"], rules["collisions"] = sources, collisions
        rules["straight_sectors"] = settings.straight_sectors
        rules["stuck_is_penalised"] = self.stuck_is_penalised
        rules["start"], rules["first_placement"] = self.start.kind, placements.start
        rules["n_placements"] = len(placements)
        for name, value in self.start.fields(self.half, group).items():
            rules[name] = value
        if (corners := int(rules["n_corners"])) + 3 > self.capacity:
            expected = f"must be larger: the start pattern has {corners} corners"
            raise InputError("capacity", self.capacity, expected)
        return record

    @cached_property
    def playable_points(self) -> NDArray[np.bool_]:
        """(points,) which points of the board are playable, row by row from the lower left."""
        x, y = np.meshgrid(*(np.arange(-half, half + 1) for half in self.half))
        return self.symmetry.playable(np.stack([x.ravel(), y.ravel()], axis=-1))

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
        """The rules as they hold for start patterns: creases and panels of any size, sources, and sectors of π.

        With ``shortest_motion`` one driving angle is enough.
        """
        rules = self.replaced(**NO_LIMITS, sources=ON_BOUNDARY, straight_sectors=1)
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
