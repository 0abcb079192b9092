"""Amounts as people write them: a return in cells, millimetres, units of a file or percent of the target's size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from origami_lab.checks import REFUSED, Kind
from origami_lab.errors import InputError
from origami_lab.lengths import MILLIMETRES, millimetres, split_amount

CELLS, UNITS, MM, PERCENT = "cells", "units", "mm", "%"


@dataclass(frozen=True)
class Amount:
    """A number with its unit."""

    number: float
    unit: str
    """CELLS, UNITS (of the target's file), MM or PERCENT (of the target's size)."""
    said: float | str
    """As it was written."""


class Reach(Kind):
    """A return that is good enough: a number, or a distance in a unit."""

    expected = "must be a return, as in -0.4, or a distance to the target in cells, percent or a unit: 0.4, 3%, 2mm"

    def take(self, value: Any) -> Any:
        found = split_amount(value)
        if found is None:
            return REFUSED
        number, word = found
        if word in ("", "cell", "cells"):
            return Amount(number, CELLS, value)
        if word in ("unit", "units"):
            return Amount(number, UNITS, value)
        if word in MILLIMETRES:
            return Amount(number * MILLIMETRES[word], MM, value)
        return Amount(number, PERCENT, value) if word == PERCENT else REFUSED


class Millimetres(Kind):
    """A length above 0, at most 10 metres: a number of millimetres, or one with its unit."""

    expected = "must be a length above 0, like 5mm, 0.5cm or 0.2in"

    def take(self, value: Any) -> Any:
        length = millimetres(value)
        return REFUSED if length is None else length


class Paper(Kind):
    """The size of a sheet: a name, or width and height."""

    expected = "must be A0 to A6, letter, legal, tabloid, or WIDTHxHEIGHT in millimetres, like 300x200mm"

    def take(self, value: Any) -> Any:
        from origami_lab.export.cut_sheet import parse_sheet

        try:
            return parse_sheet(value) if isinstance(value, str) else REFUSED
        except InputError:
            return REFUSED
