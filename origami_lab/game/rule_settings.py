"""The settings of a game's rules: which there are, and which values they take."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from origami_lab.checks import REFUSED, Choice, Flag, Kind, Number, Odd, Whole, check
from origami_lab.errors import InputError

SYMMETRIES = ("none", "x", "y", "xy", "xyd")
LARGEST_BOARD = 201
"""Longest side of a board, in points: longer ones cost memory without a use (the paper plays on 9 to 25)."""
_SIDE = f"must be an odd number of points from 5 to {LARGEST_BOARD}"
DEFAULT_MAX_ANGLE = math.degrees(3.14)
"""The paper's maximum driving angle; exactly 180° is degenerate."""
_HALF_TURN = "must lie between 0 and 180 degrees, both excluded"

KEYS = {
    "board_size": "board.size",
    "board_width": "board.width",
    "board_height": "board.height",
    "symmetry": "symmetry",
    "max_crease_length": "max_crease_length",
    "min_crease_length": "min_crease_length",
    "min_sector_angle": "min_sector_angle",
    "min_panel_width": "min_panel_width",
    "source_action": "source_action",
    "straight_sectors": "straight_sectors",
    "driving_angle_max": "driving_angle.max",
    "driving_angle_count": "driving_angle.count",
    "driving_angle_fixed": "driving_angle.fixed",
    "stuck": "stuck",
    "capacity": "capacity",
}
"""The settings by their names in Python, as the user writes them."""


class _Sources(Kind):
    """Where driven creases may be laid later: False, True for on axes, or boundary."""

    expected = "must be false, axis (or true) or boundary"

    def take(self, value: Any) -> Any:
        if value == "axis":
            return True
        return value if isinstance(value, bool) or value == "boundary" else REFUSED


@dataclass(frozen=True)
class RuleSettings:
    """The settings of a game's rules; :class:`~origami_lab.game.Game` explains them."""

    board_size: Annotated[int, Odd(5, LARGEST_BOARD, _SIDE)]
    board_width: Annotated[int | None, Odd(5, LARGEST_BOARD, _SIDE)]
    board_height: Annotated[int | None, Odd(5, LARGEST_BOARD, _SIDE)]
    symmetry: Annotated[str, Choice(SYMMETRIES)]
    max_crease_length: Annotated[
        float | None, Number(1, 1e6, "must be at least 1 (a board cell), or null for no limit")
    ]
    min_crease_length: Annotated[float | None, Number(0, 1e6, "must be board cells above 0, or null", between=True)]
    min_sector_angle: Annotated[
        float | None, Number(0, 90, "must be degrees above 0 and below 90, or null", between=True)
    ]
    min_panel_width: Annotated[float | None, Number(0, 1e6, "must be board cells above 0, or null", between=True)]
    source_action: Annotated[bool | Literal["boundary"], _Sources()]
    straight_sectors: Annotated[bool, Flag()]
    driving_angle_max: Annotated[float, Number(0, 180, _HALF_TURN, between=True)]
    driving_angle_count: Annotated[int, Whole(1, 100)]
    driving_angle_fixed: Annotated[
        float | Literal["start"] | None,
        Number(0, 180, f"{_HALF_TURN}, or be start or null", between=True, words=("start",)),
    ]
    stuck: Annotated[str, Choice(("score", "penalise"))]
    capacity: Annotated[int | None, Whole(8, 100_000)]

    @property
    def width(self) -> int:
        """Points of the board along x."""
        return self.board_size if self.board_width is None else self.board_width

    @property
    def height(self) -> int:
        """Points of the board along y."""
        return self.board_size if self.board_height is None else self.board_height


def checked_rules(values: Mapping[str, Any]) -> RuleSettings:
    """The settings of that name; raises InputError for the first that is missing or wrong."""
    settings = check(RuleSettings, values, KEYS)
    shortest, longest = settings.min_crease_length, settings.max_crease_length
    if shortest is not None and longest is not None and shortest > longest:
        raise InputError("min_crease_length", shortest, f"must be at most max_crease_length={longest:g}")
    if settings.symmetry == "xyd" and settings.width != settings.height:
        expected = (
            f"mirrors in the diagonals, too, which a board of {settings.width}×{settings.height} points does not have:"
            " must be none, x, y or xy, or the board as wide as high"
        )
        raise InputError("symmetry", settings.symmetry, expected)
    return settings
