"""Moves: what a player decides, as values that can be compared, stored, replayed and edited.

An extension is one move but four interactions (three on a symmetry axis); :mod:`origami_lab.game.game`
translates between moves and actions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from origami_lab.errors import InputError

Point = tuple[int, int]


@dataclass(frozen=True)
class Place:
    """Lay down the start pattern: ``value`` is the square's half-width or the crease's height."""

    value: int
    sign: int
    """Sign of the driving angle: +1 valley."""
    kind: ClassVar[str] = "place"


@dataclass(frozen=True)
class Lay:
    """Lay down a start pattern that no single number says: its corners, counter-clockwise, and its sides.

    Of a single crease there are two corners; the panel on the left of the way from the first to the second stays.
    """

    corners: tuple[Point, ...]
    signs: tuple[int, ...]
    """Of the side after each corner: 1 or −1 if it is driven, 0 if not."""
    sign: int
    """Sign of the driving angle: +1 valley where the side's is 1."""
    kind: ClassVar[str] = "lay"


@dataclass(frozen=True)
class Extend:
    """Extend ``leaf`` in mode ``mode`` with children ``a`` (prev side), ``b`` (next side) and ``c`` (middle)."""

    leaf: Point
    mode: int
    a: Point
    b: Point
    c: Point
    kind: ClassVar[str] = "extend"


@dataclass(frozen=True)
class Source:
    """Lay a driven crease on the boundary.

    It lies between ``leaf`` and its mirror image across the domain's axis ``end``, ``"start"`` or ``"end"``; or between
    it and the next leaf, counter-clockwise: ``"next"``.
    """

    leaf: Point
    end: str
    sign: int
    kind: ClassVar[str] = "source"


@dataclass(frozen=True)
class Terminate:
    """End the episode."""

    kind: ClassVar[str] = "terminate"


Move = Place | Lay | Extend | Source | Terminate

_KINDS: dict[str, Callable[..., Move]] = {move.kind: move for move in (Place, Lay, Extend, Source, Terminate)}


def move_to_dict(move: Move) -> dict[str, Any]:
    """The move as plain JSON values."""
    return {"kind": move.kind, **asdict(move)}


def move_from_dict(data: Mapping[str, Any]) -> Move:
    """The inverse of :func:`move_to_dict`; raises InputError."""
    fields = {key: _frozen(value) for key, value in data.items() if key != "kind"}
    try:
        return _KINDS[data["kind"]](**fields)
    except (KeyError, TypeError) as error:
        raise InputError("move", dict(data), f"must be one of {', '.join(_KINDS)} with its fields") from error


def _frozen(value: Any) -> Any:
    """Lists, as JSON has them, as tuples."""
    return tuple(_frozen(item) for item in value) if isinstance(value, list | tuple) else value
