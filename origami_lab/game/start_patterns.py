"""Start patterns as a person declares them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.kernels.state import CREASE, LARGEST_PANEL, PANEL, RECTANGLE, SEGMENT, SQUARE
from origami_lab.game.moves import Move, Point
from origami_lab.game.start_outlines import (
    Half,
    board_point,
    flips_of,
    has_room,
    is_list,
    is_whole,
    maps_to_itself,
    outline_fields,
    picked_box,
    turn_at,
    winds_once,
)
from origami_lab.geometry.groups import GROUPS, SymmetryGroup

CHOOSE = "choose"
UPPER, LOWER = "upper", "lower"
_POINT = "a board point, such as [0,-3]"


class Start(Protocol):
    """A start pattern, as a game sees it."""

    @property
    def kind(self) -> int:
        """What is placed first, one of the kinds of :mod:`origami_lab.game.kernels.state`."""
        ...

    @property
    def moves(self) -> tuple[Move, ...]:
        """Moves played before the game begins, placement first; none if placement is an action of the game."""
        ...

    @property
    def remove(self) -> tuple[Point, ...]:
        """Vertices whose extensions are taken away again, with all that grew from them."""
        ...

    @property
    def label(self) -> tuple[str, object]:
        """The setting that it comes from, and its value, for messages."""
        ...

    def placements(self, half: Half) -> range:
        """The half-widths or heights that may be placed on a board from −half to half; raises InputError.

        Any one number where there are no such options.
        """
        ...

    def fields(self, half: Half, group: SymmetryGroup) -> Mapping[str, Any]:
        """What the rules' record holds about it besides kind and placements; raises InputError."""
        ...

    def check_symmetry(self, symmetry: str) -> None:
        """Raises InputError where the pattern does not have the symmetry."""
        ...


class _Placed:
    """A start pattern that the game's first actions lay."""

    moves: tuple[Move, ...] = ()
    remove: tuple[Point, ...] = ()

    @property
    def label(self) -> tuple[str, object]:
        return "start", self


@dataclass(frozen=True)
class Square(_Placed):
    """A square panel with a driven crease on each side.

    Parameters
    ----------
    size
        Half-width in board cells, or ``"choose"``: then it is the player's first decision.
    position
        Its centre, a board point, None for that of the board; or ``"choose"``: then the player chooses its corners,
        and with a size to be chosen, too, any square of the grid.
    """

    size: int | str = CHOOSE
    position: Point | str | None = None

    @property
    def kind(self) -> int:
        return RECTANGLE if self.position == CHOOSE else SQUARE

    def placements(self, half: Half) -> range:
        """The half-widths that may be chosen on a board from −half to half; raises InputError."""
        edge = min(half)
        if self.position not in (None, CHOOSE):
            x, y = board_point("start.position", self.position, half, f"{_POINT}, null for the centre, or 'choose'")
            edge = min(half[0] - abs(x), half[1] - abs(y))
            if edge < 2:
                expected = "is too near to the board's edge: a square must have a cell around its centre and one beyond"
                raise InputError("start.position", [x, y], expected)
        if self.size != CHOOSE and not (is_whole(self.size) and 1 <= int(self.size) < edge):
            raise InputError(
                "start.size",
                self.size,
                f"must be a half-width from 1 to {edge - 1} on this board (its edge is at {edge}), or 'choose'",
            )
        if self.position == CHOOSE:
            return range(1)
        return range(1, edge) if self.size == CHOOSE else range(int(self.size), int(self.size) + 1)

    def fields(self, half: Half, group: SymmetryGroup) -> Mapping[str, Any]:
        if self.position == CHOOSE:
            sides = (1, 2 * max(half)) if self.size == CHOOSE else (2 * int(self.size),) * 2
            return picked_box(group, sides, sides, is_square=1)
        x, y = (0, 0) if self.position is None else board_point("start.position", self.position, half, _POINT)
        if any((matrix @ (x, y) != (x, y)).any() for matrix in group.matrices):
            expected = f"must be mapped to itself by symmetry={group.name}, as the square is"
            raise InputError("start.position", [x, y], expected)
        return {"centre": (x, y), "n_driven": 4}

    def check_symmetry(self, symmetry: str) -> None:
        """A square about the centre is symmetric under every group."""


@dataclass(frozen=True)
class Rectangle(_Placed):
    """A rectangular panel, its sides along those of the board, with a driven crease on each side.

    Parameters
    ----------
    width, height
        In board cells, or ``"choose"``.
    corner
        Its lower left corner, or ``"choose"``. What is to be chosen the player decides first, corner by corner.
    """

    width: int | str = CHOOSE
    height: int | str = CHOOSE
    corner: Point | str = CHOOSE
    kind = RECTANGLE

    def placements(self, half: Half) -> range:
        """None to choose from but its corners; raises InputError."""
        for name, value, most in (("width", self.width, half[0]), ("height", self.height, half[1])):
            if value != CHOOSE and not (is_whole(value) and 1 <= int(value) <= 2 * (most - 1)):
                expected = f"must be a number of cells from 1 to {2 * (most - 1)} on this board, or 'choose'"
                raise InputError(f"start.{name}", value, expected)
        if self.corner != CHOOSE:
            board_point("start.corner", self.corner, half, f"{_POINT}, or 'choose'")
        return range(1)

    def fields(self, half: Half, group: SymmetryGroup) -> Mapping[str, Any]:
        wide, high = (
            (1, 2 * most) if value == CHOOSE else (int(value),) * 2
            for value, most in ((self.width, half[0]), (self.height, half[1]))
        )
        fields = picked_box(group, wide, high)
        if isinstance(self.corner, str):
            if not has_room(fields, half):
                expected = f"no rectangle of this size is mapped to itself by symmetry={group.name} within this board"
                raise InputError("start.width", self.width, f"{expected}: choose another, or choose")
            return fields
        images = group.matrices @ np.array(self.corner)
        pin = images[group.playable(images)][0]
        fields |= {"is_pinned": 1, "pin": pin}
        if not has_room(fields, half, self.corner):
            expected = f"is no lower left corner of such a rectangle with symmetry={group.name} within this board"
            raise InputError("start.corner", list(self.corner), expected)
        return fields

    def check_symmetry(self, symmetry: str) -> None:
        """Which rectangles have the symmetry depends on the board."""


@dataclass(frozen=True)
class Crease(_Placed):
    """A single driven crease; one of its two panels stays in the plane z = 0.

    Parameters
    ----------
    position
        The crease's y, from (−1, y) to (1, y), or ``"choose"``: then it is the player's first decision.
    ends
        Two board points instead, in any direction; or ``"choose"``: then the player chooses them.
    stays
        Which panel stays in the plane: ``"upper"`` or ``"lower"``. Of an upright crease the left one counts as upper.
    """

    position: int | str = CHOOSE
    ends: tuple[Point, Point] | str | None = None
    stays: str = UPPER

    @property
    def kind(self) -> int:
        return CREASE if self.ends is None else SEGMENT if self.ends == CHOOSE else PANEL

    def placements(self, half: Half) -> range:
        """The heights that may be chosen; raises InputError."""
        if self.stays not in (UPPER, LOWER):
            raise InputError("start.stays", self.stays, f"must be {UPPER} or {LOWER}")
        if self.ends is not None:
            self._given_ends(half)
            return range(1)
        edge = half[1]
        if self.position == CHOOSE:
            return range(1 - edge, edge)
        if not is_whole(self.position) or abs(int(self.position)) >= edge:
            raise InputError(
                "start.position",
                self.position,
                f"must be a height from {1 - edge} to {edge - 1} on this board, or 'choose'",
            )
        return range(int(self.position), int(self.position) + 1)

    def _given_ends(self, half: Half | None = None) -> list[Point]:
        """The ends, the left or lower one first; none where they are to be chosen."""
        if self.ends == CHOOSE:
            return []
        expected = "two different board points, such as [[-2,0],[2,1]], null, or 'choose'"
        if self.ends is None or isinstance(self.ends, str) or not is_list(self.ends) or len(self.ends) != 2:
            raise InputError("start.ends", self.ends, f"must be {expected}")
        first, second = (board_point("start.ends", end, half, expected) for end in self.ends)
        if first == second:
            raise InputError("start.ends", [list(end) for end in self.ends], f"must be {expected}")
        return sorted([first, second])

    def fields(self, half: Half, group: SymmetryGroup) -> Mapping[str, Any]:
        below = int(self.stays == LOWER)
        if self.ends is None:
            return {"stays_below": below, "n_driven": 1}
        ends = self._given_ends(half)
        if not ends:
            return {"stays_below": below, "n_driven": 1, "picks": 2 if group.order == 1 else 1, **flips_of(group)}
        return outline_fields(ends[::-1] if below else ends, (1, 0))

    def check_symmetry(self, symmetry: str) -> None:
        """Its two panels fold differently, so no mirror may swap them; raises InputError."""
        group = GROUPS[symmetry]
        if self.ends is None:
            if symmetry not in ("none", "y"):
                raise InputError(
                    "symmetry",
                    symmetry,
                    "must be none or y with start=crease, whose crease lies along the x axis: add symmetry=y"
                    " (without it, the target's own is taken)",
                )
        elif self.ends == CHOOSE:
            if group.order > 2:
                expected = (
                    "must be none, x or y with a single crease: with more mirrors it would lie on one of them,"
                    " which would swap its two panels, and they fold differently"
                )
                raise InputError("symmetry", symmetry, expected)
        elif not maps_to_itself(self._given_ends(), (1, 0), group):
            ends = self._given_ends()
            on_axis = any((matrix @ end == end).all() for matrix in group.matrices[1:] for end in np.array(ends))
            swaps = "lies on a mirror axis, which would swap its two panels, and they fold differently"
            expected = swaps if on_axis else "must be mapped to itself by it, and neither of its panels to the other"
            raise InputError("start.ends", [list(end) for end in ends], f"with symmetry={symmetry}, {expected}")


@dataclass(frozen=True)
class Panel(_Placed):
    """A strictly convex panel with driven creases on its sides, or on some of them.

    Parameters
    ----------
    corners
        Three board points or more, counter-clockwise or clockwise, none on the board's edge.
    signs
        For each side, from each corner to the next: 1 or −1 where it is driven, as against the sign that the player
        chooses, 0 where it is not. None: all are driven, with one sign. A corner between two sides that are not driven
        has no crease: it cannot be extended before one leads to it.
    """

    corners: tuple[Point, ...]
    signs: tuple[int, ...] | None = None
    kind = PANEL

    def placements(self, half: Half) -> range:
        """None to choose from; raises InputError."""
        self._outline(half)
        return range(1)

    def fields(self, half: Half, group: SymmetryGroup) -> Mapping[str, Any]:
        return outline_fields(*self._outline(half))

    def check_symmetry(self, symmetry: str) -> None:
        """It must be mapped to itself, and the signs of its sides; raises InputError."""
        corners, signs = self._outline()
        if not maps_to_itself(corners, signs, GROUPS[symmetry]):
            expected = f"must be mapped to itself by symmetry={symmetry}, its signs, too"
            raise InputError("start.corners", [list(corner) for corner in corners], expected)

    def _outline(self, half: Half | None = None) -> tuple[list[Point], tuple[int, ...]]:
        """Its corners counter-clockwise, with the sign of the side after each."""
        expected = f"three to {LARGEST_PANEL} board points, such as [[0,2],[-2,0],[0,-2],[2,0]]"
        if not is_list(self.corners) or not 3 <= len(self.corners) <= LARGEST_PANEL:
            raise InputError("start.corners", self.corners, f"must be {expected}")
        corners = [board_point("start.corners", corner, half, expected) for corner in self.corners]
        signs = (1,) * len(corners) if self.signs is None else self.signs
        if not is_list(signs) or len(signs) != len(corners) or not all(is_whole(s) and abs(s) <= 1 for s in signs):
            raise InputError("start.signs", self.signs, "must be null, or a 1, -1 or 0 for each side")
        if not any(signs):
            raise InputError("start.signs", list(signs), "must have a side that is driven, 1 or -1")
        turns = np.sign([turn_at(corners, i) for i in range(len(corners))])
        if abs(turns.sum()) != len(corners) or not winds_once(corners):
            shown = [list(corner) for corner in corners]
            raise InputError("start.corners", shown, "must be the corners of a strictly convex polygon, in order")
        if turns[0] < 0:  # clockwise: the side before a corner comes after it
            corners, signs = corners[::-1], (*tuple(signs)[-2::-1], signs[-1])
        return corners, tuple(signs)
