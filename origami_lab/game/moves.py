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
    """Lay a driven crease between ``leaf`` and its mirror image across the domain's axis ``end`` ("start" or "end")."""

    leaf: Point
    end: str
    sign: int
    kind: ClassVar[str] = "source"


@dataclass(frozen=True)
class Terminate:
    """End the episode."""

    kind: ClassVar[str] = "terminate"


Move = Place | Extend | Source | Terminate

_KINDS: dict[str, Callable[..., Move]] = {move.kind: move for move in (Place, Extend, Source, Terminate)}


def move_to_dict(move: Move) -> dict[str, Any]:
    """The move as plain JSON values."""
    return {"kind": move.kind, **asdict(move)}


def move_from_dict(data: Mapping[str, Any]) -> Move:
    """The inverse of :func:`move_to_dict`; raises InputError."""
    fields = {key: tuple(value) if isinstance(value, list) else value for key, value in data.items() if key != "kind"}
    try:
        return _KINDS[data["kind"]](**fields)
    except (KeyError, TypeError) as error:
        raise InputError("move", dict(data), f"must be one of {', '.join(_KINDS)} with its fields") from error
