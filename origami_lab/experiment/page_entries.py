"""The trials of a run as its page shows them: figures, learning curve, a small drawing where there is no picture."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from origami_lab.file_names import BEST, CURVE, DESCRIBED, FOLDED_PNG, trial_folder
from origami_lab.files import is_regular, read_json, regular_bytes
from origami_lab.runs.trial_row import NO_DESIGN, TrialRow

CURVE_POINTS = 60
"""Improvements of a trial that its curve on the page shows, at most."""
LARGEST_CURVE = 16 * 2**20
MOST_EDGES = 1500
"""Edges of a pattern that is drawn on the page."""
SHOWN = {
    "return": "return",
    "return_percent": "% of its size",
    "return_mm": "mm",
    "return_vertex": "vertex",
    "return_surface": "surface",
    "return_sampled": "sampled",
    "chamfer": "mean distance",
    "likeness": "likeness",
    "driving_angle": "angle °",
    "interactions_to_best": "best at",
    "interactions": "interactions",
    "vertices": "vertices",
    "panels": "panels",
    "polished_return": "polished",
    "seconds": "seconds",
}
"""Columns of a trial's row that the page has, and what it calls them."""


def entry_of(run: Path, row: TrialRow, draws: bool) -> dict[str, Any]:
    """A trial that has ended, for the page of its run.

    Parameters
    ----------
    draws
        Whether a pattern without a picture is drawn from its file.
    """
    folder = trial_folder(run, row.seed)
    designed = row.outcome != NO_DESIGN and not row.has_failed
    there = [name for name in DESCRIBED if is_regular(folder / name)] if designed else []
    found: dict[str, Any] = {
        "seed": row.seed,
        "status": row.outcome,
        "reason": row.reason,
        "certificate": row.certificate,
        "cells": {name: row[name] for name in SHOWN if row[name] is not None},
        "files": there,
        "curve": [] if row.has_failed else curve_of(folder / CURVE),
    }
    if not designed:
        found["cells"].pop("return", None)  # the penalty
    if draws and BEST in there and FOLDED_PNG not in there:
        found["pattern"] = pattern_of(folder / BEST)
    return found


def thinned(points: Sequence[Sequence[float]], most: int = CURVE_POINTS) -> list[list[float]]:
    """A learning curve of at most so many points, the first and the last among them."""
    if len(points) <= most:
        return [list(point) for point in points]
    step = (len(points) - 1) / (most - 1)
    return [list(points[round(k * step)]) for k in range(most)]


class MeanCurve:
    """The mean over trials of the best return so far, at fixed numbers of interactions up to a budget."""

    def __init__(self, budget: int) -> None:
        self.at = sorted({round(budget ** (k / CURVE_POINTS)) for k in range(CURVE_POINTS + 1)})
        self._sums = [0.0] * len(self.at)
        self._count = 0
        self._first = 0
        """The first of the numbers at which every trial has a return."""

    def add(self, curve: Sequence[Sequence[float]]) -> None:
        """Take in a trial's improvements; one that has none is left out."""
        if not curve:
            return
        self._count += 1
        ahead = 0
        for k, at in enumerate(self.at):
            while ahead < len(curve) and curve[ahead][0] <= at:
                ahead += 1
            if ahead:
                self._sums[k] += curve[ahead - 1][1]
            else:
                self._first = max(self._first, k + 1)

    def points(self) -> list[list[float]]:
        """Interactions and mean returns, from where every trial has one."""
        pairs = list(zip(self.at, self._sums, strict=True))[self._first :]
        return [[at, total / self._count] for at, total in pairs] if self._count else []


def curve_of(file: Path) -> list[list[float]]:
    """Interactions and best return of a trial's improvements; empty if they cannot be read."""
    try:
        with io.StringIO(regular_bytes(file, LARGEST_CURVE).decode("utf-8"), newline="") as text:
            points = [(int(row["interactions"]), float(row["return"])) for row in csv.DictReader(text)]
    except (OSError, ValueError, KeyError, TypeError, csv.Error):
        return []
    return thinned([point for point in points if math.isfinite(point[1])])


def pattern_of(file: Path) -> dict[str, Any] | None:
    """The crease pattern in a FOLD file as lines to draw; None if it cannot be read, or has too many."""
    try:
        document: Mapping[str, Any] = read_json(file)
        points = [[round(float(x), 3), round(float(y), 3)] for x, y, *_ in document["vertices_coords"]]
        edges = [[int(u), int(v)] for u, v in document["edges_vertices"]]
        letters = [str(letter)[:1] for letter in document["edges_assignment"]]
        flat = all(math.isfinite(value) for point in points for value in point)
        inside = all(0 <= end < len(points) for edge in edges for end in edge)
    except (OSError, ValueError, KeyError, TypeError, OverflowError, AttributeError):
        return None
    if not flat or not inside or len(edges) > MOST_EDGES or len(letters) != len(edges):
        return None
    return {"points": points, "edges": edges, "letters": "".join(letters)}
