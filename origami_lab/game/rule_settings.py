"""The settings of a game's rules: which there are, and which values they take."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from origami_lab.checks import Choice, Flag, Number, Odd, Whole, check

SYMMETRIES = ("none", "x", "y", "xy", "xyd")
LARGEST_BOARD = 201
"""Widest board, in points: wider ones cost memory without a use (the paper plays on 9 to 25)."""
DEFAULT_MAX_ANGLE = math.degrees(3.14)
"""The paper's maximum driving angle; exactly 180° is degenerate."""
_HALF_TURN = "must lie between 0 and 180 degrees, both excluded"

KEYS = {
    "board_size": "board.size",
    "symmetry": "symmetry",
    "max_crease_length": "max_crease_length",
    "source_action": "source_action",
    "driving_angle_max": "driving_angle.max",
    "driving_angle_count": "driving_angle.count",
    "driving_angle_fixed": "driving_angle.fixed",
    "stuck": "stuck",
    "capacity": "capacity",
}
"""The settings by their names in Python, as the user writes them."""


@dataclass(frozen=True)
class RuleSettings:
    """The settings of a game's rules; :class:`~origami_lab.game.Game` explains them."""

    board_size: Annotated[int, Odd(5, LARGEST_BOARD, f"must be an odd number of points from 5 to {LARGEST_BOARD}")]
    symmetry: Annotated[str, Choice(SYMMETRIES)]
    max_crease_length: Annotated[
        float | None, Number(1, 1e6, "must be at least 1 (a board cell), or null for no limit")
    ]
    source_action: Annotated[bool, Flag()]
    driving_angle_max: Annotated[float, Number(0, 180, _HALF_TURN, between=True)]
    driving_angle_count: Annotated[int, Whole(1, 100)]
    driving_angle_fixed: Annotated[
        float | Literal["start"] | None,
        Number(0, 180, f"{_HALF_TURN}, or be start or null", between=True, words=("start",)),
    ]
    stuck: Annotated[str, Choice(("score", "penalise"))]
    capacity: Annotated[int | None, Whole(8, 100_000)]


def checked_rules(values: Mapping[str, Any]) -> RuleSettings:
    """The settings of that name; raises InputError for the first that is missing or wrong."""
    return check(RuleSettings, values, KEYS)
