"""The table of an experiment's trials: its columns, its file, its mean ± std, its look in a terminal."""

from __future__ import annotations

import csv
import io
import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    "seed",
    "return",
    "return_vertex",
    "return_surface",
    "return_sampled",
    "driving_angle",
    "interactions",
    "interactions_to_best",
    "seconds",
    "interactions_per_second",
    "vertices",
    "creases",
    "panels",
    "reach",
    "status",
    "episodes",
    "rejected",
    "certificate",
)
"""Columns of trials.csv; angles in degrees, empty where there is no value."""

TEXTS = frozenset(("status", "certificate"))

NARROW = 72
"""A terminal of fewer columns cannot show all that a trial has to tell."""

RETURNS = ("return", "return_vertex", "return_surface", "return_sampled")
TIMINGS = ("seconds", "interactions_per_second")
"""Columns that differ from run to run."""

VERDICTS = CERTIFIED, REFUTED, UNDECIDED = "certified", "refuted", "not certifiable"
"""What certificates say; those of :mod:`origami_lab.verification.certificate`."""
OK, NO_DESIGN, STOPPED, FAILED = "ok", "no design", "stopped", "failed"

INTEGERS = frozenset(
    (
        "seed",
        "interactions",
        "interactions_to_best",
        "vertices",
        "creases",
        "panels",
        "reach",
        "episodes",
        "rejected",
    )
)

Row = Mapping[str, Any]
"""One trial: column to int, float, str or None."""


@dataclass(frozen=True)
class Spread:
    """Mean and sample standard deviation (n − 1; None for fewer than two values) of n values."""

    mean: float
    std: float | None
    n: int

    def __str__(self) -> str:
        return f"{self.mean:.4f}" if self.std is None else f"{self.mean:.4f} ± {self.std:.4f}"


def spent_budget(row: Row) -> bool:
    """Whether the trial ran to its end, so that it is comparable with others."""
    return row.get("status") in (OK, NO_DESIGN)


def spreads(rows: Iterable[Row]) -> dict[str, Spread]:
    """Mean ± std of each return over the trials that ran to their end."""
    rows = [row for row in rows if spent_budget(row)]
    found = {}
    for column in RETURNS:
        spread = spread_of(float(row[column]) for row in rows if row.get(column) is not None)
        if spread is not None:
            found[column] = spread
    return found


def spread_of(values: Iterable[float]) -> Spread | None:
    """Mean ± std of numbers; None if there are none."""
    values = list(values)
    if not values:
        return None
    return Spread(statistics.fmean(values), statistics.stdev(values) if len(values) > 1 else None, len(values))


def best_row(rows: Iterable[Row]) -> Row | None:
    """The trial with the highest return; the lowest seed among equals."""
    scored = [row for row in rows if row.get("return") is not None]
    return max(scored, key=lambda row: (row["return"], -row["seed"]), default=None)


def format_trials(rows: Iterable[Row]) -> str:
    """The text of trials.csv: the rows in order of their seeds."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in sorted(rows, key=lambda row: int(row["seed"])):
        writer.writerow(["" if row.get(name) is None else row[name] for name in COLUMNS])
    return text.getvalue()


def read_trials(path: Path) -> list[dict[str, Any]]:
    """Read a trials.csv back: numbers as numbers, empty cells as None.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    with path.open(newline="", encoding="utf-8") as file:
        return [{name: _value(name, cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def _value(column: str, cell: str) -> int | float | str | None:
    if cell == "":
        return None
    if column in INTEGERS:
        return int(cell)
    try:
        return cell if column in TEXTS else float(cell)
    except ValueError:
        return cell


def summary_table(rows: Sequence[Row], title: str | None = None, width: int = 80) -> Table:
    """The trials and their mean ± std, for a terminal of 80 columns; a narrow one gets what matters most."""
    from rich import box
    from rich.table import Table

    rows = [row if row["status"] != NO_DESIGN else {**row, **dict.fromkeys(RETURNS)} for row in rows]
    measured = [name for name in RETURNS[1:] if any(row.get(name) is not None for row in rows)]
    # the distance that the search used is the return: said once
    same = [name for name in measured if not any(_differs(row.get(name), row.get("return")) for row in rows)]
    wide = width >= NARROW
    returns = ["return", *(name for name in measured if name not in same[:1] and wide)]
    several = len(rows) > 1
    table = Table(
        title=title,
        title_justify="left",
        show_footer=several,
        header_style="bold",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    found = spreads(rows)
    best = best_row(rows)
    table.add_column("seed", "mean\nstd", justify="right")
    for name in returns:
        footer = f"{_number(found[name].mean, '.4f')}\n{_number(found[name].std, '.4f')}" if name in found else ""
        table.add_column(name.removeprefix("return_"), footer, justify="right")
    for shown in ("angle °", "best at", "vertices") if wide else ("angle °",):
        table.add_column(shown, justify="right")
    shows_status = any(row["status"] != OK for row in rows)
    if shows_status:
        table.add_column("status")
    for row in sorted(rows, key=lambda row: int(row["seed"])):
        table.add_row(
            str(row["seed"]),
            *(_number(row.get(name), ".4f") for name in returns),
            _number(row.get("driving_angle"), ".1f"),
            *((_number(row.get("interactions_to_best"), ",d"), _number(row.get("vertices"), "d")) if wide else ()),
            *([str(row["status"]).partition(":")[0]] if shows_status else []),
            style="bold" if row is best and several else None,
        )
    return table


def hint(rows: Iterable[Row]) -> str | None:
    """One line on what usually helps where trials ended without a design; None if all have one."""
    empty = sum(row["status"] == NO_DESIGN for row in rows)
    if not empty:
        return None
    trials = "1 trial" if empty == 1 else f"{empty} trials"
    return (
        f"{trials} found no design that folds: what usually helps is a larger budget, "
        "start.size=1 or 2, a symmetry, or a larger max_crease_length"
    )


def certificates(rows: Iterable[Row]) -> dict[str, list[int]]:
    """Verdict → the seeds whose best design has it. Older trials, and those of ``files=designs``, have none."""
    found: dict[str, list[int]] = {}
    for row in sorted(rows, key=lambda row: int(row["seed"])):
        if row.get("certificate"):
            found.setdefault(str(row["certificate"]), []).append(int(row["seed"]))
    return found


def certificate_lines(rows: Iterable[Row]) -> list[str]:
    """What the certificates say, for below the table: a line, and a warning if one refutes its design."""
    found = certificates(rows)
    if not found:
        return []
    counts = ", ".join(f"{len(seeds)} {verdict}" for verdict, seeds in sorted(found.items()))
    lines = [f"certificates: {counts}"]
    if seeds := found.get(REFUTED):
        listed = ", ".join(map(str, seeds))
        lines.append(
            f"warning: seed {listed}: the best design is refuted, it does not fold as it should: see certificate.json"
        )
    return lines


def _differs(value: float | None, other: float | None) -> bool:
    """Whether a table with four decimals has something to tell about ``value``."""
    return value is not None and (other is None or abs(value - other) > 1e-6)


def _number(value: Any, form: str) -> str:
    return "–" if value is None or not math.isfinite(value) else format(value, form)
