"""Start patterns made of moves: a seeding pattern, or a saved design, whole or with vertices cut off.

The moves are played before the game begins: they are no interactions, every episode goes on from them, and a design's
log of actions begins with theirs.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.moves import Lay, Move, Place, Point, move_to_dict
from origami_lab.game.start_file import (
    CREASE_FIRST,
    SQUARE_FIRST,
    SavedPattern,
    checked_moves,
    checked_points,
    read_pattern,
)
from origami_lab.game.start_patterns import CHOOSE, LOWER, UPPER, Crease, Panel, Square, Start
from origami_lab.geometry.groups import GROUPS, SymmetryGroup


@dataclass(frozen=True)
class FromMoves:
    """A start pattern made of moves.

    Parameters
    ----------
    moves
        Placement first, as :class:`~origami_lab.game.moves.Move` objects or as plain data; a terminating move at the
        end is left out.
    first
        What placement lays: ``"square"`` or ``"crease"``.
    symmetry
        The group that the moves were made for; None if any will do.
    remove
        Board points (any image will do) of vertices that lose their extensions. With them goes what grew from them:
        every extension of a vertex that loses a crease into it, and what is not legal without what went.

    Raises
    ------
    InputError
        If the arguments are not such things. Whether the moves are legal is for the game to say.
    """

    moves: tuple[Move, ...]
    first: str = SQUARE_FIRST
    symmetry: str | None = None
    remove: tuple[Point, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "moves", checked_moves(self.moves))
        object.__setattr__(self, "remove", checked_points("start.remove", self.remove))
        if self.first not in (SQUARE_FIRST, CREASE_FIRST):
            raise InputError("start.first", self.first, f"must be {SQUARE_FIRST} or {CREASE_FIRST}")
        if self.symmetry is not None and self.symmetry not in GROUPS:
            raise InputError("start.symmetry", self.symmetry, f"must be one of {', '.join(GROUPS)}, or null")

    @property
    def label(self) -> tuple[str, object]:
        return "start.moves", f"{len(self.moves)} moves"

    @cached_property
    def _placed(self) -> Start:
        placement = self.moves[0]
        if isinstance(placement, Lay):
            return laid_start(placement)
        assert isinstance(placement, Place)
        return Square(placement.value) if self.first == SQUARE_FIRST else Crease(placement.value)

    @property
    def kind(self) -> int:
        return self._placed.kind

    def placements(self, half: tuple[int, int]) -> range:
        try:
            return self._placed.placements(half)
        except InputError as error:
            field, value = self.label
            what = "pattern" if isinstance(self.moves[0], Lay) else self.first
            raise InputError(
                field, value, f"the {what} at {error.value} that it begins with {error.expected}"
            ) from None

    def fields(self, half: tuple[int, int], group: SymmetryGroup) -> Mapping[str, Any]:
        return self._placed.fields(half, group)

    def check_symmetry(self, symmetry: str) -> None:
        if self.symmetry is not None and symmetry != self.symmetry:
            field, value = self.label
            expected = f"must be {self.symmetry} for the start pattern of {field}={value}: add symmetry={self.symmetry}"
            raise InputError("symmetry", symmetry, expected)
        self._placed.check_symmetry(symmetry)


@dataclass(frozen=True, init=False)
class FromFile(FromMoves):
    """A start pattern from a file: a trial's design, or one of the package's own patterns.

    Parameters
    ----------
    path
        A trial's actions.json, its folder or its best.fold; a file with ``game.symmetry``, ``game.start`` and ``moves``
        (or ``actions`` and ``game.board_size``); or the name of one of the package's own: ``chair``.
    remove
        As for :class:`FromMoves`.

    Raises
    ------
    InputError
        If there is no such file, or it is not one of ours.
    """

    path: str = ""

    def __init__(self, path: str | os.PathLike[str], remove: Sequence[Point] = ()) -> None:
        saved = read_pattern(path)
        moves = saved.moves or _moves_of_actions(path, saved)
        object.__setattr__(self, "path", str(path))
        for name, value in (("moves", moves), ("first", saved.first), ("symmetry", saved.symmetry), ("remove", remove)):
            object.__setattr__(self, name, value)
        self.__post_init__()

    @property
    def label(self) -> tuple[str, object]:
        return "start.path", self.path


def laid_start(move: Lay) -> Start:
    """The start pattern that is laid by a move and by no other."""
    if len(move.corners) > 2:
        return Panel(move.corners, move.signs)
    # the panel on the left of the way from the first end to the second stays
    return Crease(ends=(move.corners[0], move.corners[1]), stays=UPPER if move.corners[0] < move.corners[1] else LOWER)


def saved_start(settings: Mapping[str, Any], game: Game) -> dict[str, Any]:
    """The setting ``start`` as it goes into a trial's actions.json, which is to be whole without any other file."""
    if not game.start_moves:
        return dict(settings)
    return {
        "_target_": f"origami_lab.game.{FromMoves.__name__}",
        "first": getattr(game.start, "first", SQUARE_FIRST),
        "symmetry": game.symmetry.name,
        "moves": [move_to_dict(move) for move in game.start_moves],
    }


def _moves_of_actions(path: str | os.PathLike[str], saved: SavedPattern) -> list[Move]:
    """The moves behind the actions of a file, played in the game that they were made in."""
    placed = saved.game["start"].get("size" if saved.first == SQUARE_FIRST else "position", CHOOSE)
    try:
        start = Square(placed) if saved.first == SQUARE_FIRST else Crease(placed)
        if saved.game["start"].get("moves"):
            raise ValueError("it has a start pattern of moves, so it must have moves")
        width, height = (saved.game.get(name) for name in ("board_width", "board_height"))
        game = Game(saved.game["board_size"], saved.symmetry, start, board_width=width, board_height=height)
        return game.moves(saved.actions)
    except KeyError as error:
        raise InputError("start.path", path, f"has actions, so it must have {error} in game, too") from None
    except (ValueError, TypeError) as error:
        raise InputError("start.path", path, f"has actions that cannot be played: {error}") from None
