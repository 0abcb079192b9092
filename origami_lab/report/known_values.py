"""Values of others to be printed beside ours: the paper's tables, or any CSV file of the same columns."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from origami_lab.errors import InputError
from origami_lab.files import LARGEST_TABLE, regular_bytes
from origami_lab.runs.trial_row import Spread

PAPER = Path(__file__).with_name("paper.csv")
COLUMNS = ("task", "method", "table", "mean", "std", "source")
TABLES = ("returns", "interactions")


@dataclass(frozen=True)
class Known:
    """A value that someone else found."""

    mean: float
    std: float | None
    source: str
    digits: int
    """Decimals that it is printed with."""

    def differs(self, ours: Spread) -> bool:
        """Whether the means are further apart than the larger one of the two standard deviations."""
        spreads = [std for std in (self.std, ours.std) if std is not None]
        return bool(spreads) and abs(ours.mean - self.mean) > max(spreads)


KnownValues = Mapping[tuple[str, str, str], Known]
"""By table, method and task."""


def read_beside(name: str) -> dict[tuple[str, str, str], Known]:
    """Read a file of known values; ``paper`` names that of the paper's two result tables.

    Its columns are task, method, table (returns or interactions, these in thousands), mean, std (may be empty) and
    source.

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
            if len(reader.fieldnames or ()) > len(COLUMNS):
                raise InputError("--beside", name, f"line 1: must have the columns {', '.join(COLUMNS)} and no others")
            found: dict[tuple[str, str, str], Known] = {}
            lines: dict[tuple[str, str, str], int] = {}
            for row in reader:
                key, known = _entry(row, reader.line_num, name)
                if key in found:
                    expected = f"line {reader.line_num}: must not say again what line {lines[key]} says"
                    raise InputError("--beside", name, f"{expected} ({', '.join(key)})")
                found[key], lines[key] = known, reader.line_num
            return found
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        expected = f"must be paper or a CSV file ({getattr(error, 'strerror', None) or error})"
        raise InputError("--beside", name, expected) from error


def _entry(row: Mapping[str, str | None], line: int, name: str) -> tuple[tuple[str, str, str], Known]:
    if len(row) > len(COLUMNS) or None in row.values():
        raise InputError("--beside", name, f"line {line}: must have {len(COLUMNS)} cells, as its first line")
    cells = {column: (row.get(column) or "").strip() for column in COLUMNS}
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
    return (cells["table"], cells["method"], cells["task"]), Known(mean, std, cells["source"] or name, digits)
