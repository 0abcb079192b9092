"""Which trials belong together: those whose whole configuration is the same but for their seeds.

A column of a table is a task with the settings of its game and objective, a row a searcher with its own numbers and the
budget. Where a name stands for several settings, the usual ones go by it, and the others say what differs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from origami_lab.report.report_order import Ordering
from origami_lab.report.run_reader import Note, Part, Run, Trial
from origami_lab.runs.trial_row import FAILED, NO_DESIGN, STOPPED, best_row

_MOST_IN_NAME = 3
"""Differing settings that a name spells out; more are listed in a note."""


@dataclass(frozen=True)
class Heading:
    """A row or a column of the tables."""

    name: str
    """Of the task or the searcher."""
    label: str
    """The name and what tells it from others of that name."""

    @property
    def is_usual(self) -> bool:
        """Whether it goes by the bare name."""
        return self.label == self.name


@dataclass(frozen=True)
class Group:
    """The trials of one cell, one a seed."""

    trials: tuple[Trial, ...]
    budget: int
    distance: str | None

    @property
    def counted(self) -> tuple[Trial, ...]:
        """Trials that ran to their end."""
        return tuple(trial for trial in self.trials if trial.counts)

    def number(self, status: str) -> int:
        return sum(trial.status == status for trial in self.trials)

    @property
    def best(self) -> Trial | None:
        """The counted trial with the highest return and a design."""
        row = best_row(trial.row for trial in self.counted if trial.status != NO_DESIGN)
        return next((trial for trial in self.counted if trial.row is row), None)


@dataclass(frozen=True)
class Groups:
    """All cells by row and column; what is missing was not run."""

    rows: tuple[Heading, ...]
    columns: tuple[Heading, ...]
    cells: Mapping[tuple[Heading, Heading], Group]
    notes: tuple[Note, ...]
    order: Ordering
    """The order of the columns, and of rows that are not among ours."""

    def column(self, column: Heading) -> list[tuple[Heading, Group]]:
        """The cells of a column that there are, in order of the rows."""
        return [(row, self.cells[row, column]) for row in self.rows if (row, column) in self.cells]

    def best_of(self, column: Heading) -> tuple[Heading, Trial] | None:
        """The best trial of a column with a design, and its row."""
        found = [(row, group.best) for row, group in self.column(column)]
        known = [(row, trial) for row, trial in found if trial is not None]
        return max(known, key=lambda pair: pair[1].value, default=None)


def group_runs(runs: Sequence[Run]) -> Groups:
    """Sort runs into the cells of a table."""
    notes: list[Note] = []
    order = Ordering.of(runs)
    column_of: dict[tuple[str, Part], Heading] = {}
    for task in order.tasks({run.task for run in runs}):
        column_of |= _headings(task, Counter(run.game for run in runs if run.task == task), notes)
    row_of: dict[tuple[str, Part], Heading] = {}
    for method in order.methods({run.method for run in runs}):
        own = [run for run in runs if run.method == method]
        cells = {(run.task, run.game, run.search) for run in own}
        if len({cell[:2] for cell in cells}) < len(cells):
            row_of |= _headings(method, Counter(run.search for run in own), notes)
        else:  # each task has one kind of this searcher: they can share a row
            row_of |= {(method, run.search): Heading(method, method) for run in own}
            notes += _across_tasks(method, own, order)
    gathered: dict[tuple[Heading, Heading], list[Run]] = {}
    for run in runs:
        place = (row_of[run.method, run.search], column_of[run.task, run.game])
        gathered.setdefault(place, []).append(run)
    for place, members in gathered.items():
        notes += _versions(place, members)
    cells_of = {
        place: Group(_once_a_seed(members, notes), members[0].budget, members[0].distance)
        for place, members in gathered.items()
    }
    return Groups(tuple(dict.fromkeys(row_of.values())), tuple(column_of.values()), cells_of, tuple(notes), order)


def _headings(name: str, runs: Mapping[Part, int], notes: list[Note]) -> dict[tuple[str, Part], Heading]:
    """One heading for each kind of settings that a name stands for; that of most runs goes by the bare name.

    ``runs`` says how many there are of each kind.
    """
    parts = {variant: dict(variant) for variant in runs}
    keys = _differing(parts.values())
    ordered = sorted(parts, key=lambda variant: [_sorting(key, parts[variant]) for key in keys])
    ordered.sort(key=lambda variant: runs[variant] < max(runs.values()))
    usual = parts[ordered[0]]
    headings = {(name, ordered[0]): Heading(name, name)}
    if keys:
        notes.append(Note(f"{name}, where nothing else is said: {', '.join(_shown(key, usual) for key in keys)}"))
    for number, variant in enumerate(ordered[1:], start=2):
        part = parts[variant]
        own = [key for key in keys if (key in part) != (key in usual) or part.get(key) != usual.get(key)]
        label = ", ".join(_shown(key, part) for key in own)
        if len(own) > _MOST_IN_NAME:
            notes.append(Note(f"{name} #{number}: {label}"))
            label = f"#{number}"
        headings[name, variant] = Heading(name, f"{name} ({label})")
    return headings


def _differing(parts: Iterable[Mapping[str, Any]]) -> list[str]:
    """The keys, in order, that are not the same in all."""
    parts = list(parts)
    keys = sorted({key for part in parts for key in part})
    return [key for key in keys if any(key not in p or p[key] != parts[0].get(key) for p in parts)]


def _sorting(key: str, part: Mapping[str, Any]) -> tuple[int, float, str]:
    """The sorting key of a setting: not set comes first, then numbers by size, then words."""
    if key not in part:
        return (0, 0.0, "")
    value = part[key]
    return (1, float(value), "") if isinstance(value, int | float) else (2, 0.0, str(value))


def _shown(key: str, part: Mapping[str, Any]) -> str:
    """A setting as it is typed."""
    name = key.removesuffix("._target_").removesuffix(".name")
    if key not in part:
        return f"{name} not set"
    value = part[key]
    if value is None or isinstance(value, bool):
        value = {None: "null", True: "true", False: "false"}[value]
    return f"{name}={str(value).rpartition('.')[2] if key.endswith('._target_') else value}"


def _across_tasks(method: str, runs: Sequence[Run], order: Ordering) -> list[Note]:
    """Notes on the settings that a searcher's row mixes; the budgets are in the tables' own notes."""
    parts = [{k: v for k, v in run.settings.items() if k.startswith("search.")} for run in runs]
    differing = _differing(parts)
    tasks: dict[str, set[str]] = {}
    for run, part in zip(runs, parts, strict=True):
        tasks.setdefault(", ".join(_shown(key, part) for key in differing), set()).add(run.task)
    if not differing:
        return []
    listed = "; ".join(f"{', '.join(order.tasks(names))} with {text}" for text, names in tasks.items())
    return [Note(f"{method}: {listed}")]


def _versions(place: tuple[Heading, Heading], runs: Sequence[Run]) -> list[Note]:
    """Whether a cell mixes what different versions found."""
    made = sorted({str(run.versions["origami-lab"]) for run in runs if "origami-lab" in run.versions})
    if len(made) < 2:
        return []
    return [Note(f"{place[1].label}, {place[0].label}: of several versions of origami-lab ({', '.join(made)})")]


def _once_a_seed(runs: Sequence[Run], notes: list[Note]) -> tuple[Trial, ...]:
    """The trials of runs with the same settings; a seed that is there twice, as in a copied folder, counts once."""
    chosen: dict[int, Trial] = {}
    twice: dict[tuple[Path, Path, bool], list[int]] = {}
    for run in runs:
        for trial in run.trials:
            other = chosen.get(trial.seed)
            if other is None or _rank(trial) > _rank(other):
                chosen[trial.seed] = trial
            if other is not None and other.counts and trial.counts:
                same = trial.value == other.value
                twice.setdefault((other.run, trial.run, same), []).append(trial.seed)
    for (first, second, same), seeds in twice.items():
        what = "the same trials" if same else "different returns though all settings are the same"
        listed = ", ".join(map(str, seeds))
        notes.append(Note(f"{what} (seed {listed}); those of the first count", (first, second)))
    return tuple(chosen[seed] for seed in sorted(chosen))


def _rank(trial: Trial) -> int:
    """Finished trials count before others."""
    return 2 if trial.counts else {STOPPED: 1, FAILED: 0}.get(trial.status, 0)
