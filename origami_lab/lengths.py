"""Lengths as people write them: a number with a unit behind it; and sheets of paper by their names."""

from __future__ import annotations

import math
import re
import sys
from typing import Any

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Units of length by what they are."""
LONGEST = 10_000.0
"""Millimetres."""

SHEETS = {
    "A0": (841.0, 1189.0),
    "A1": (594.0, 841.0),
    "A2": (420.0, 594.0),
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "A5": (148.0, 210.0),
    "A6": (105.0, 148.0),
    "LETTER": (215.9, 279.4),
    "LEGAL": (215.9, 355.6),
    "TABLOID": (279.4, 431.8),
}
"""Widths and heights of sheets of paper, millimetres."""
MARGIN = 10.0
"""Millimetres of the sheet that stay free at each side, unless said otherwise."""


def smallest_sheet(width: float, height: float) -> str | None:
    """The smallest A size that has room for so many millimetres, turned if need be; None if the largest has not."""
    sides = sorted((width, height))
    for size, name in sorted((size, name) for name, size in SHEETS.items() if name.startswith("A")):
        if all(side <= length - 2 * MARGIN for side, length in zip(sides, size, strict=True)):
            return name
    return None


_AMOUNT = re.compile(r"\s*([-+]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z%]*)\s*", re.ASCII)


def split_amount(value: Any) -> tuple[float, str] | None:
    """A finite number and the word behind it, empty for a plain number; None for anything else."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return (float(value), "") if -sys.float_info.max <= value <= sys.float_info.max else None
    found = _AMOUNT.fullmatch(value) if isinstance(value, str) and len(value) < 100 else None
    return (float(found[1]), found[2]) if found and math.isfinite(float(found[1])) else None


def millimetres(value: Any) -> float | None:
    """A length above 0, at most :data:`LONGEST`; a number without a unit is one of millimetres. None for the rest."""
    found = split_amount(value)
    if found is None or found[1] not in ("", *MILLIMETRES):
        return None
    length = found[0] * MILLIMETRES[found[1] or "mm"]
    return length if 0.0 < length <= LONGEST else None
