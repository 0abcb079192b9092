"""Start patterns as a person declares them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from origami_lab.errors import InputError
from origami_lab.game.kernels.state import CREASE, SQUARE
from origami_lab.game.moves import Move, Point

CHOOSE = "choose"


class Start(Protocol):
    """A start pattern, as a game sees it."""

    @property
    def kind(self) -> int:
        """SQUARE or CREASE: what is placed first."""
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

    def placements(self, half: tuple[int, int]) -> range:
        """The half-widths or heights that may be placed on a board from −half to half; raises InputError."""
        ...

    def check_symmetry(self, symmetry: str) -> None:
        """Raises InputError where the pattern does not have the symmetry."""
        ...


class _Placed:
    """A start pattern that the game's first action lays."""

    moves: tuple[Move, ...] = ()
    remove: tuple[Point, ...] = ()

    @property
    def label(self) -> tuple[str, object]:
        return "start", self


@dataclass(frozen=True)
class Square(_Placed):
    """A square panel about the centre with a driven crease on each side.

    Parameters
    ----------
    size
        Half-width in board cells, or ``"choose"``: then it is the player's first decision.
    """

    size: int | str = CHOOSE
    kind = SQUARE

    def placements(self, half: tuple[int, int]) -> range:
        """The half-widths that may be chosen on a board from −half to half; raises InputError."""
        edge = min(half)
        if self.size == CHOOSE:
            return range(1, edge)
        if isinstance(self.size, bool) or not isinstance(self.size, int) or not 1 <= self.size < edge:
            raise InputError(
                "start.size",
                self.size,
                f"must be a half-width from 1 to {edge - 1} on this board (its edge is at {edge}), or 'choose'",
            )
        return range(self.size, self.size + 1)

    def check_symmetry(self, symmetry: str) -> None:
        """A square is symmetric under every group."""


@dataclass(frozen=True)
class Crease(_Placed):
    """A single driven crease from (−1, y) to (1, y); the panel above it stays in the plane z = 0.

    Parameters
    ----------
    position
        The crease's y, or ``"choose"``: then it is the player's first decision.
    """

    position: int | str = CHOOSE
    kind = CREASE

    def placements(self, half: tuple[int, int]) -> range:
        """The heights that may be chosen; raises InputError."""
        edge = half[1]
        if self.position == CHOOSE:
            return range(1 - edge, edge)
        if isinstance(self.position, bool) or not isinstance(self.position, int) or abs(self.position) >= edge:
            raise InputError(
                "start.position",
                self.position,
                f"must be a height from {1 - edge} to {edge - 1} on this board, or 'choose'",
            )
        return range(self.position, self.position + 1)

    def check_symmetry(self, symmetry: str) -> None:
        """Its two panels fold differently, so no mirror may swap them; raises InputError."""
        if symmetry not in ("none", "y"):
            raise InputError(
                "symmetry",
                symmetry,
                "must be none or y with start=crease, whose crease lies along the x axis: add symmetry=y"
                " (without it, the target's own is taken)",
            )
