"""Files that start patterns are read from: the actions.json of a trial, or the same with less in it.

Needed are ``game.symmetry``, ``game.start`` (which says whether a square or a crease is placed first) and ``moves``;
instead of moves there may be ``actions`` with ``game.board_size``. Nothing here needs the compiler, so that settings
can be read quickly.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from origami_lab.errors import InputError
from origami_lab.files import expanded, regular_bytes
from origami_lab.game.moves import Extend, Lay, Move, Place, Point, Source, Terminate, move_from_dict

PATTERNS = Path(__file__).parent / "patterns"
"""The package's own start patterns."""
SQUARE_FIRST, CREASE_FIRST = "square", "crease"
_FIRST = {"Square": SQUARE_FIRST, "Rectangle": SQUARE_FIRST, "Panel": SQUARE_FIRST, "Crease": CREASE_FIRST}
_LARGEST = 16 * 2**20
"""Bytes: a design of thousands of moves is a few hundred kB."""
_OWN = "must be the actions.json of a trial, its folder, or a start pattern's file"


@dataclass(frozen=True)
class SavedPattern:
    """The contents of a start pattern's file."""

    first: str
    """``"square"`` or ``"crease"``."""
    symmetry: str
    moves: tuple[Move, ...]
    """From placement on; empty if there are actions only."""
    actions: tuple[int, ...]
    game: Mapping[str, Any]
    """The settings of the game that it was played in, as far as they are there."""


def pattern_path(path: str | os.PathLike[str]) -> Path:
    """The file that ``start.path`` means.

    Parameters
    ----------
    path
        A file; the folder of a trial, or its best.fold, for its actions.json; or the name of one of the package's own
        patterns, such as ``chair``.

    Raises
    ------
    InputError
        If there is no such file.
    """
    if not isinstance(path, str | os.PathLike) or not str(path).strip() or "\0" in str(path):
        raise InputError("start.path", path, _OWN)
    if is_own_pattern(path):
        return PATTERNS / f"{path}.json"
    file = expanded(path)
    try:
        if file.is_dir():
            if not (file / "actions.json").is_file():
                seeds = sorted(found.parent.name for found in file.glob("seed=*/actions.json"))
                hint = f"; did you mean {file / seeds[0]}?" if seeds else ""
                raise InputError("start.path", path, f"there is no actions.json in this folder{hint}")
            return file / "actions.json"
        if file.suffix == ".fold":
            beside = file.with_name("actions.json")
            if not beside.is_file():
                expected = "a FOLD file does not say which game it is from: there must be an actions.json beside it"
                raise InputError("start.path", path, expected)
            return beside
        if not file.is_file():
            own = ", ".join(sorted(pattern.stem for pattern in PATTERNS.glob("*.json")))
            raise InputError("start.path", path, f"there is no such file; {_OWN}, or one of {own}")
    except OSError as error:
        raise InputError("start.path", path, f"cannot be read ({error.strerror})") from error
    return file


def is_own_pattern(path: object) -> bool:
    """Whether a path is the name of one of the package's own patterns."""
    name = str(path)
    return name.isidentifier() and (PATTERNS / f"{name}.json").is_file()


def read_pattern(path: str | os.PathLike[str]) -> SavedPattern:
    """Read a file for a start pattern.

    Raises
    ------
    InputError
        In one line, if there is no such file or it is not one of ours.
    """
    file = pattern_path(path)

    def refuse(what: str) -> NoReturn:
        raise InputError("start.path", path, f"{what}: {_OWN}") from None

    try:
        if file.stat().st_size > _LARGEST:
            refuse(f"is larger than {_LARGEST >> 20} MB")
        saved = json.loads(regular_bytes(file, _LARGEST))
    except OSError as error:
        refuse(f"cannot be read ({error.strerror})")
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        refuse("is not JSON")
    game = saved.get("game") if isinstance(saved, dict) else None
    start = game.get("start") if isinstance(game, dict) else None
    if not isinstance(game, dict) or not isinstance(start, dict) or not isinstance(game.get("symmetry"), str):
        refuse("does not say which game it is from (game.symmetry, game.start)")
    name = str(start.get("_target_", "")).rpartition(".")[2]
    first = {**_FIRST, "FromMoves": start.get("first")}.get(name)
    if first not in (SQUARE_FIRST, CREASE_FIRST):
        refuse(f"begins with a start pattern that is not ours, {start.get('_target_')}")
    moves, actions = saved.get("moves"), saved.get("actions")
    if moves is not None:
        try:
            return SavedPattern(first, game["symmetry"], checked_moves(moves), (), game)
        except InputError as error:
            refuse(f"has a wrong move ({error.expected})")
    if not isinstance(actions, list) or not all(type(action) is int for action in actions):
        refuse("has neither moves nor actions")
    return SavedPattern(first, game["symmetry"], (), tuple(actions), game)


def checked_moves(moves: object) -> tuple[Move, ...]:
    """Moves as objects, from objects or plain data; placement is the first, a last one that ends the game is left out.

    Raises
    ------
    InputError
        If they are not such moves.
    """
    if not isinstance(moves, Sequence) or isinstance(moves, str) or not moves:
        raise InputError("start.moves", moves, "must be a list of moves")
    found: list[Move] = []
    for number, move in enumerate(moves):
        made = move_from_dict(move) if isinstance(move, Mapping) else move
        if not _is_sound(made) or isinstance(made, Place | Lay) != (number == 0):
            raise InputError("start.moves", move, f"move {number} must be {_WANTED[number > 0]}")
        found.append(made)
    if isinstance(found[-1], Terminate):
        found.pop()
    if any(isinstance(move, Terminate) for move in found):
        raise InputError("start.moves", "terminate", "must be the last move")
    return tuple(found)


_WANTED = ("a placement: kind place, value, sign", "an extension (leaf, mode, a, b, c) or a source (leaf, end, sign)")


def checked_points(field: str, points: object) -> tuple[Point, ...]:
    """Board points from plain data; raises InputError."""
    if isinstance(points, Sequence) and not isinstance(points, str) and all(_is_point(point) for point in points):
        return tuple((point[0], point[1]) for point in points)
    raise InputError(field, points, "must be a list of board points, such as [[0,-3],[-2,1]]")


def _is_sound(move: object) -> bool:
    """Whether a move's fields are what they should be, whoever made it."""
    match move:
        case Place(value, sign):
            return type(value) is int and sign in (-1, 1)
        case Lay(corners, signs, sign):
            points = isinstance(corners, tuple) and len(corners) >= 2 and all(_is_point(point) for point in corners)
            whole = isinstance(signs, tuple) and all(type(side) is int and abs(side) <= 1 for side in signs)
            return points and whole and len(signs) == len(corners) and sign in (-1, 1)
        case Extend(leaf, mode, a, b, c):
            return mode in (-1, 1) and all(_is_point(point) for point in (leaf, a, b, c))
        case Source(leaf, end, sign):
            return _is_point(leaf) and end in ("start", "end", "next") and sign in (-1, 1)
    return isinstance(move, Terminate)


def _is_point(point: object) -> bool:
    return isinstance(point, Sequence) and len(point) == 2 and all(type(t) is int and abs(t) < 1000 for t in point)
