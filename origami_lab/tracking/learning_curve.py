"""The learning curve of a run: the mean of its trials' best returns so far, at steps that all share."""

from __future__ import annotations

import csv
import io
import math
from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path

from origami_lab.files import regular_bytes

STEPS_A_DECADE = 12
LARGEST_CURVE = 16 * 2**20
"""Bytes of a trial's curve that is read."""


def mean_curve(files: Sequence[Path]) -> list[tuple[int, float]]:
    """Interactions and mean best return, from where every trial has a design to where the longest one ends.

    Parameters
    ----------
    files
        The ``curve.csv`` of each trial. One that cannot be read makes the mean of the others another one than that of
        the run: there is no curve then.
    """
    curves = [_read(file) for file in files]
    if not curves or not all(curves):
        return []
    first, last = max(curve[0][0] for curve in curves), max(curve[-1][0] for curve in curves)
    first = max(first, 1)
    decades = math.log10(max(last, first) / first)
    count = max(math.ceil(STEPS_A_DECADE * decades), 1)
    steps = sorted({round(first * (last / first) ** (k / count)) for k in range(count + 1)} | {first, last})
    return [(step, sum(_at(curve, step) for curve in curves) / len(curves)) for step in steps if first <= step <= last]


def _at(curve: Sequence[tuple[int, float]], step: int) -> float:
    place = bisect_right(curve, step, key=lambda point: point[0]) - 1
    return curve[max(place, 0)][1]


def _read(file: Path) -> list[tuple[int, float]]:
    try:
        with io.StringIO(regular_bytes(file, LARGEST_CURVE).decode("utf-8"), newline="") as text:
            points = [(int(row["interactions"]), float(row["return"])) for row in csv.DictReader(text)]
    except (OSError, ValueError, KeyError, TypeError, csv.Error):
        return []
    return sorted(point for point in points if math.isfinite(point[1]))
