"""Values of others to be printed beside ours: the paper's tables, or any CSV file of the same columns."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from origami_lab.errors import InputError
from origami_lab.files import LARGEST_TABLE, regular_bytes
from origami_lab.runs.trial_row import Spread

PAPER = Path(__file__).with_name("paper.csv")
COLUMNS = ("task", "method", "table", "mean", "std", "source")
CONDITIONS = ("budget", "trials")
"""Columns that a file may have, too: the values stand only beside cells of that budget and so many trials."""
TABLES = ("returns", "interactions")


@dataclass(frozen=True)
class Known:
    """A value that someone else found."""

    mean: float
    std: float | None
    source: str
    digits: int
    """Decimals that it is printed with."""
    budget: int | None = None
    """Interactions a trial that it was found with; None for any."""
    trials: int | None = None
    """Trials that it is the mean of; None for any number."""

    def is_comparable(self, budget: int, trials: int) -> bool:
        """Whether a cell of this budget and so many trials may stand beside it."""
        return self.budget in (None, budget) and self.trials in (None, trials)

    def differs(self, ours: Spread) -> bool:
        """Whether the means are further apart than the larger one of the two standard deviations."""
        spreads = [std for std in (self.std, ours.std) if std is not None]
        return bool(spreads) and abs(ours.mean - self.mean) > max(spreads)


KnownValues = Mapping[tuple[str, str, str], Known]
"""By table, method and task."""


def read_beside(name: str) -> dict[tuple[str, str, str], Known]:
    """Read a file of known values; ``paper`` names that of the paper's two result tables.

    Its columns are task, method, table (returns or interactions, these in thousands), mean, std (may be empty), source
    and, if it says them, budget and trials.

    Raises
    ------
    InputError
        If it cannot be read or is not such a file.
    """
    path = PAPER if name == "paper" else Path(name)
    try:
        with io.StringIO(regular_bytes(path, LARGEST_TABLE).decode("utf-8-sig"), newline="") as file:
            reader = csv.DictReader(file)
            lacking = [column for column in COLUMNS if column not in (reader.fieldnames or ())]
            if lacking:
                expected = f"must have the columns {', '.join(COLUMNS)}; there is no {', '.join(lacking)}"
                raise InputError("--beside", name, expected)
            allowed = [*COLUMNS, *(column for column in CONDITIONS if column in (reader.fieldnames or ()))]
            if sorted(reader.fieldnames or ()) != sorted(allowed):
                raise InputError("--beside", name, f"line 1: must have the columns {', '.join(COLUMNS)} and no others")
            found: dict[tuple[str, str, str], Known] = {}
            lines: dict[tuple[str, str, str], int] = {}
            for row in reader:
                key, known = _entry(row, reader.line_num, name, allowed)
                if key in found:
                    expected = f"line {reader.line_num}: must not say again what line {lines[key]} says"
                    raise InputError("--beside", name, f"{expected} ({', '.join(key)})")
                found[key], lines[key] = known, reader.line_num
            return found
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        expected = f"must be paper or a CSV file ({getattr(error, 'strerror', None) or error})"
        raise InputError("--beside", name, expected) from error


def _entry(
    row: Mapping[str, str | None], line: int, name: str, columns: Sequence[str]
) -> tuple[tuple[str, str, str], Known]:
    if len(row) > len(columns) or None in row.values():
        raise InputError("--beside", name, f"line {line}: must have {len(columns)} cells, as its first line")
    cells = {column: (row.get(column) or "").strip() for column in (*COLUMNS, *CONDITIONS)}
    for column in CONDITIONS:
        if cells[column] and not (cells[column].isascii() and cells[column].isdigit() and len(cells[column]) < 16):
            raise InputError("--beside", name, f"line {line}: {column} must be a whole number, or empty")
    if cells["table"] not in TABLES:
        raise InputError("--beside", name, f"line {line}: table must be returns or interactions")
    try:
        mean, std = float(cells["mean"]), float(cells["std"]) if cells["std"] else None
        if not math.isfinite(mean) or not math.isfinite(std or 0.0):
            raise ValueError
    except ValueError:
        raise InputError("--beside", name, f"line {line}: mean and std must be numbers (std may be empty)") from None
    if (std or 0.0) < 0.0:
        raise InputError("--beside", name, f"line {line}: std must be 0 or more, or empty")
    digits = min(len(cells["mean"].partition(".")[2]), 4)
    budget, trials = (int(cells[column]) if cells[column] else None for column in CONDITIONS)
    known = Known(mean, std, cells["source"] or name, digits, budget, trials)
    return (cells["table"], cells["method"], cells["task"]), known
