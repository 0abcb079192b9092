"""One row of trials.csv: its columns, its CSV and JSON, its failed form, and statistics over rows."""

from __future__ import annotations

import csv
import io
import json
import math
import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType, NoneType
from typing import Any, get_args, get_type_hints

from origami_lab.files import LARGEST_TABLE, read_json, regular_bytes

VERDICTS = CERTIFIED, REFUTED, UNDECIDED = "certified", "refuted", "not certifiable"
"""Verdicts of certificates; those of :mod:`origami_lab.verification.certificate`."""
NOT_CHECKED = "not checked"
"""Stands in the column ``certificate`` for a design that nothing has verified."""
STATUSES = OK, NO_DESIGN, STOPPED, FAILED = "ok", "no design", "stopped", "failed"
"""First words of a row's status; a failed trial's goes on with a colon and the reason."""
TIME_LIMIT = "time limit"
POLISH_ENDS = OK, TIME_LIMIT, STOPPED, FAILED
"""First words of how a polish ended; a failed one's goes on with a colon and the reason."""
RETURNS = ("return", "return_vertex", "return_surface", "return_sampled")
FIGURES = ("return_percent", "return_units", "return_mm", "chamfer", "likeness")
"""What else is told of a design for a target: its return in other units, and how like the target it is."""
LIKENESSES = ("chamfer", "likeness")
SEARCH_ENDS = BUDGET, GOAL, MINUTES, BY_ITSELF = "budget", "target return", "minutes", "searcher"
"""What ended a trial's search: budget, target_return, minutes, or the searcher itself, which had no more to try."""
SURFACE_TOLERANCE = 1e-3
"""Board cells that surfaces are measured to."""
POLISHED_RETURNS = tuple(f"polished_{name}" for name in RETURNS)
"""Those of a trial's best design once it is polished off the grid."""

Value = int | float | str | None


@dataclass(frozen=True, kw_only=True)
class TrialRow:
    """One trial in the table of its run. Each field is a column; angles are in degrees, None stands for no value.

    Raises
    ------
    ValueError
        If a value is not of its column's kind, or a trial that did not fail lacks its return.
    """

    seed: int
    return_: float | None = None
    """The column ``return``."""
    return_vertex: float | None = None
    return_surface: float | None = None
    return_sampled: float | None = None
    driving_angle: float | None = None
    interactions: int | None = None
    interactions_to_best: int | None = None
    seconds: float | None = None
    interactions_per_second: float | None = None
    vertices: int | None = None
    creases: int | None = None
    panels: int | None = None
    reach: int | None = None
    status: str
    episodes: int | None = None
    rejected: int | None = None
    certificate: str | None = None
    places_evaluated: int | None = None
    """Places that were looked at without being played; they are no interactions."""
    polish: str | None = None
    """How the polish of its best design ended: :data:`POLISH_ENDS`; None if there was none."""
    polish_steps: int | None = None
    """Designs that it laid."""
    polished_return: float | None = None
    polished_return_vertex: float | None = None
    polished_return_surface: float | None = None
    polished_return_sampled: float | None = None
    polished_driving_angle: float | None = None
    polished_certificate: str | None = None
    return_percent: float | None = None
    """The distance that the search used, as a return in percent of the target's size."""
    return_units: float | None = None
    """The same in the unit of the target's file."""
    chamfer: float | None = None
    """The mean distance between the surfaces, both ways, in board cells."""
    likeness: float | None = None
    """The share of the target's area that has a panel near it whose normal agrees."""
    cell_mm: float | None = None
    """The length of a board cell on paper, in millimetres, where the run was told."""
    return_mm: float | None = None
    """The distance that the search used, as a return in millimetres on paper."""
    width_mm: float | None = None
    height_mm: float | None = None
    """Those of the flat pattern, in millimetres."""
    polished_chamfer: float | None = None
    polished_likeness: float | None = None
    ended: str | None = None
    """What ended its search: :data:`SEARCH_ENDS`."""
    stages: int | None = None
    """Stages of the run that it has gone through; None in runs made before there were any, which is one."""

    def __post_init__(self) -> None:
        for column, kind in KINDS.items():
            if not _fits(self[column], kind) or (self[column] is None and column in ("seed", "status")):
                raise ValueError(f"{column}={self[column]!r} is not of the kind {kind.__name__}")
        if self.outcome not in STATUSES:
            raise ValueError(f"status={self.status!r} is unknown")
        if self.polish is not None and self.polish.partition(":")[0] not in POLISH_ENDS:
            raise ValueError(f"polish={self.polish!r} is unknown")
        if not self.has_failed and (self.return_ is None or self.interactions_to_best is None):
            raise ValueError("a trial that did not fail has a return and interactions_to_best")

    @classmethod
    def failed(cls, seed: int, reason: str) -> TrialRow:
        """The row of a trial that has no result."""
        return cls(seed=seed, status=f"{FAILED}: {reason}")

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> TrialRow:
        """The row that a mapping of column to value stands for; columns that are unknown here are left out.

        Raises
        ------
        ValueError
            If it is damaged.
        """
        try:
            return cls(**{_FIELDS[column]: value for column, value in values.items() if column in _FIELDS})
        except TypeError as error:
            raise ValueError(str(error)) from error

    def values(self) -> dict[str, Value]:
        """Column → value, for JSON and MLflow; of a failed trial only those that it has."""
        found = {column: getattr(self, name) for column, name in _FIELDS.items()}
        return {column: value for column, value in found.items() if value is not None} if self.has_failed else found

    def said(self) -> dict[str, Value]:
        """Column → value without empty columns that version 0.1.0 did not have: tells whether a row has changed."""
        columns = list(KINDS)
        later = columns[columns.index("certificate") + 1 :]
        return {column: value for column, value in self.values().items() if value is not None or column not in later}

    def write(self, file: Path, beside: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Write the row as a trial's result.json, with what it says beside the row."""
        file.write_text(json.dumps({**self.values(), **beside}, indent=2) + "\n", encoding="utf-8")

    def __getitem__(self, column: str) -> Any:
        """The value of a column whose name is only known as text."""
        return getattr(self, _FIELDS[column])

    @property
    def outcome(self) -> str:
        """OK, NO_DESIGN, STOPPED or FAILED."""
        return self.status.partition(":")[0]

    @property
    def reason(self) -> str:
        """Why it failed; empty if it did not."""
        return self.status.partition(": ")[2]

    @property
    def has_failed(self) -> bool:
        return self.outcome == FAILED

    @property
    def spent_budget(self) -> bool:
        """Whether the trial ran to its end, so that it is comparable with others."""
        return self.outcome in (OK, NO_DESIGN)

    @property
    def surface_is_worse(self) -> bool:
        """Whether the surfaces are further apart than the vertices tell, by more than a tenth."""
        if self.return_vertex is None or self.return_surface is None:
            return False
        return self.return_vertex - self.return_surface > max(0.1 * abs(self.return_surface), SURFACE_TOLERANCE)

    def has_gone_through(self, stages: int, budget: int) -> bool:
        """Whether its search has come to the end of so many stages, the last of them with this budget."""
        if not self.spent_budget:
            return False
        return (self.stages or 1) >= stages or (self.interactions or 0) >= budget or self.ended == BY_ITSELF

    @property
    def may_be_polished(self) -> bool:
        """Whether it ran to its end with a design whose polish did not come to its own end."""
        return self.outcome == OK and self.polish in (None, STOPPED)


_FIELDS = {field.name.rstrip("_"): field.name for field in fields(TrialRow)}
"""Column → name of its field: ``return`` is a word of Python's."""
COLUMNS = tuple(_FIELDS)
"""Columns of trials.csv, in order."""


def _kind(hint: Any) -> type:
    """The kind of a field that may be None."""
    kinds: list[type] = [kind for kind in get_args(hint) if kind is not NoneType]
    return kinds[0] if kinds else hint


KINDS: dict[str, type] = {
    column: _kind(hint)
    for name, hint in get_type_hints(TrialRow).items()
    for column in [name.rstrip("_")]
    if column in _FIELDS
}
"""Column → int, float or str."""


def _fits(value: Value, kind: type) -> bool:
    if value is None or kind is str:
        return value is None or isinstance(value, str)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value) and (kind is float or isinstance(value, int))


@dataclass(frozen=True)
class Spread:
    """Mean and sample standard deviation (n − 1; None for fewer than two values) of n values."""

    mean: float
    std: float | None
    n: int

    @property
    def rounded(self) -> str:
        """Mean ± std to the first digit of the standard error of the mean: the digits after it are chance."""
        digits = self.digits
        return f"{self.mean:z.{digits}f}" if self.std is None else f"{self.mean:z.{digits}f} ± {self.std:z.{digits}f}"

    @property
    def digits(self) -> int:
        """Decimals that the mean is worth; 4, as for a single value, where nothing says how far off it is."""
        if not self.std:
            return 4
        return min(max(-math.floor(math.log10(self.std / math.sqrt(self.n))), 0), 4)

    def __str__(self) -> str:
        return f"{self.mean:z.4f}" if self.std is None else f"{self.mean:z.4f} ± {self.std:z.4f}"


def spreads(rows: Iterable[TrialRow]) -> dict[str, Spread]:
    """Mean ± std of each return and figure over the trials that ran to their end, and of the polished designs'."""
    rows = [row for row in rows if row.spent_budget]
    found = {}
    for column in (*RETURNS, *FIGURES, *POLISHED_RETURNS, *(f"polished_{name}" for name in LIKENESSES)):
        spread = spread_of(row[column] for row in rows if row[column] is not None)
        if spread is not None:
            found[column] = spread
    return found


def spread_of(values: Iterable[float]) -> Spread | None:
    """Mean ± std of numbers; None if there are none."""
    values = list(values)
    if not values:
        return None
    return Spread(statistics.fmean(values), statistics.stdev(values) if len(values) > 1 else None, len(values))


def best_row(rows: Iterable[TrialRow], column: str = "return") -> TrialRow | None:
    """The trial with the highest return, or value of another column; the lowest seed among equals."""
    scored = [(row[column], -row.seed, row) for row in rows if row[column] is not None]
    return max(scored, key=lambda entry: entry[:2])[2] if scored else None


def counts(rows: Iterable[TrialRow]) -> dict[str, int]:
    """Outcome → number of trials that ended so, in order of the names."""
    outcomes = [row.outcome for row in rows]
    return {name: outcomes.count(name) for name in sorted(set(outcomes))}


def certificates(rows: Iterable[TrialRow]) -> dict[str, list[int]]:
    """Verdict, or NOT_CHECKED → the seeds whose best design has it; trials of before there were any have none."""
    found: dict[str, list[int]] = {}
    for row in sorted(rows, key=lambda row: row.seed):
        if row.certificate:
            found.setdefault(row.certificate, []).append(row.seed)
    return found


def beside_row(result: Path) -> dict[str, Any]:
    """What a trial's result.json says beside its row; nothing if it cannot be read."""
    try:
        return {key: value for key, value in read_json(result).items() if key not in KINDS}
    except (OSError, ValueError, AttributeError):
        return {}


def format_trials(rows: Iterable[TrialRow]) -> str:
    """The text of trials.csv: the rows in order of their seeds."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in sorted(rows, key=lambda row: row.seed):
        writer.writerow(["" if row[name] is None else row[name] for name in COLUMNS])
    return text.getvalue()


def read_trials(path: Path) -> list[TrialRow]:
    """The rows of a trials.csv.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged.
    """
    with io.StringIO(regular_bytes(path, LARGEST_TABLE).decode("utf-8"), newline="") as file:
        return [
            TrialRow.from_values({name: _value(name, cell) for name, cell in row.items() if name in KINDS})
            for row in csv.DictReader(file)
        ]


def _value(column: str, cell: str | None) -> Value:
    """A cell of trials.csv as its column's kind; None for an empty one, and the text where it is no number."""
    if not cell:
        return None
    return cell if KINDS[column] is str else KINDS[column](cell)
