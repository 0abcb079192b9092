"""Runs on disk with their settings and trials; unreadable ones are left out and named in a note."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from origami_lab.config.node import FREE_TO_CHANGE, OF_STAGES, flatten
from origami_lab.config.seeds import parse_seeds
from origami_lab.errors import InputError
from origami_lab.file_names import START, SUMMARY, TARGET, TRIALS, trial_folder
from origami_lab.runs.run_finder import find_runs
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import STOPPED, TrialRow, read_trials

IDENTITY = ("task", "method")
"""Keys that name the column and the row of a table."""
FILES = {"target.path": ("target.surface", TARGET), "start.path": ("start.pattern", START)}
"""By settings that name a file of the user's: what it held is compared by this name, and kept in the run folder as."""


@dataclass(frozen=True)
class Note:
    """Something a reader must know."""

    text: str
    folders: tuple[Path, ...] = ()
    """Folders that the note is about."""

    def shown(self, base: Path | None = None) -> str:
        """In one line, the folders as seen from ``base``, or as the user named them."""
        names = [str(folder) if base is None else relative(folder, base) for folder in self.folders]
        return f"{' and '.join(names)}: {self.text}" if names else self.text


def relative(folder: Path, base: Path) -> str:
    """The way from one folder to another one."""
    return Path(os.path.relpath(folder.resolve(), base.resolve())).as_posix()


@dataclass(frozen=True)
class Trial:
    """One seed of a run."""

    seed: int
    row: TrialRow
    """Its row of trials.csv."""
    run: Path
    """The run's folder."""

    @property
    def folder(self) -> Path:
        """Where its files are, if they are still there."""
        return trial_folder(self.run, self.seed)

    @property
    def counts(self) -> bool:
        """Whether it ran to its end, so that it is comparable with others."""
        return self.row.spent_budget

    @property
    def status(self) -> str:
        return self.row.outcome

    @property
    def value(self) -> float:
        """Its return."""
        if self.row.return_ is None:
            raise ValueError(f"seed {self.seed} has no return")
        return self.row.return_


Part = tuple[tuple[str, Any], ...]
"""Some of the settings, in order, to be compared."""


@dataclass(frozen=True)
class Run:
    """One run folder."""

    folder: Path
    task: str
    method: str
    settings: Mapping[str, Any]
    """Dotted keys: all that decides what a trial finds, but for its seed."""
    trials: tuple[Trial, ...]
    asked: int
    """How many seeds it was started with."""
    summary: Mapping[str, Any]
    """summary.json; empty if there is none yet."""
    report_order: Mapping[str, float]
    """The places that its options gave its task and its searcher in reports."""

    @property
    def search(self) -> Part:
        """Settings of the searcher: its own numbers and the budget."""
        return tuple((key, value) for key, value in sorted(self.settings.items()) if _is_searcher_s(key))

    @property
    def game(self) -> Part:
        """Settings of the task: all but the searcher's."""
        return tuple((key, value) for key, value in sorted(self.settings.items()) if not _is_searcher_s(key))

    @property
    def budget(self) -> int:
        return int(self.settings["budget"])

    @property
    def distance(self) -> str | None:
        """The distance that the search used; None without a target."""
        distance = self.settings.get("objective.distance")
        return None if distance is None else str(distance)

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions that the run was computed with, as far as its summary says."""
        found = self.summary.get("versions")
        return found if isinstance(found, dict) else {}


def _is_searcher_s(key: str) -> bool:
    return key in OF_STAGES or key.startswith("search.")


def read_runs(directories: Sequence[Path]) -> tuple[list[Run], list[Note]]:
    """All runs at or below some directories, each once, and notes on what was left out or is not finished.

    Raises
    ------
    InputError
        If there is no such directory, no run in it, or none that can be read.
    """
    folders: dict[Path, Path] = {}
    for directory in directories:
        if not directory.exists():
            raise InputError("DIR", directory, "there is no such folder")
        for folder in find_runs(directory, "DIR"):
            folders.setdefault(folder.resolve(), folder)
    runs: list[Run] = []
    notes: list[Note] = []
    for folder in folders.values():
        try:
            run = _read_run(folder, notes)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            notes.append(Note(f"left out, it cannot be read ({_reason(error)})", (folder,)))
            continue
        if run.trials:
            runs.append(run)
        else:
            notes.append(Note("left out, none of its trials has ended yet or can be read", (folder,)))
    if not runs:
        reasons = "; ".join(note.shown() for note in notes)
        raise InputError("DIR", ", ".join(map(str, directories)), f"there is no run that can be read ({reasons})")
    return runs, notes


def _reason(error: Exception) -> str:
    if isinstance(error, InputError):
        return error.expected
    if isinstance(error, KeyError):
        return f"its config.yaml does not say {error.args[0]}"
    return next(iter(str(error).splitlines()), type(error).__name__)


def _read_run(folder: Path, notes: list[Note]) -> Run:
    config = RunFolder(folder).config()
    settings = _settings(folder, config)
    rows = _rows(folder, notes)
    trials = tuple(Trial(seed, row, folder) for seed, row in sorted(rows.items()))
    seeds = parse_seeds(0 if config.get("seed") is None else config["seed"])
    summary = _summary(folder, notes)
    order = {key: place for key, place in (config.get("report_order") or {}).items() if isinstance(place, int | float)}
    absent = sum(seed not in rows or rows[seed].outcome == STOPPED for seed in seeds)
    if absent and rows:
        notes.append(Note(f"not finished, {len(seeds) - absent} of {len(seeds)} trials", (folder,)))
    return Run(folder, str(config["task"]), str(config["method"]), settings, trials, len(seeds), summary, order)


def _settings(folder: Path, config: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted keys of what tells runs apart. A file may have changed between them: what it held is compared, too."""
    kept = {key: value for key, value in config.items() if key not in (*FREE_TO_CHANGE, *IDENTITY)}
    settings = {key: value for key, value in flatten(kept).items() if not key.startswith("objective.target")}
    settings["budget"] = int(settings["budget"])  # what people write is also 1e6
    for key, (name, copy) in FILES.items():
        if key in settings and (folder / copy).is_file():
            settings[name] = hashlib.sha256((folder / copy).read_bytes()).hexdigest()[:8]
    if "target.surface" in settings:  # it says what came of it, and earlier runs do not say what was up
        settings.pop("target.up", None)
    # lists as they are typed: they are compared and shown, nothing else
    return {k: v if isinstance(v, str | int | float | None) else json.dumps(v) for k, v in settings.items()}


def _rows(folder: Path, notes: list[Note]) -> dict[int, TrialRow]:
    """The trials' rows by seed: from their folders, else from the table."""
    run = RunFolder(folder)
    found = run.rows()
    try:
        for row in read_trials(folder / TRIALS) if (folder / TRIALS).is_file() else []:
            if row.seed not in found or (row.has_failed and not found[row.seed].spent_budget):
                found[row.seed] = row
    except (OSError, ValueError, KeyError):
        notes.append(Note("its trials.csv is damaged, the folders of its trials are read instead", (folder,)))
    for seed in run.damaged_seeds():
        found.pop(seed, None)
        notes.append(Note("left out, its result is damaged", (trial_folder(folder, seed),)))
    return dict(sorted(found.items()))


def _summary(folder: Path, notes: list[Note]) -> dict[str, Any]:
    path = folder / SUMMARY
    if not path.is_file():
        return {}
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        summary = None
    if not isinstance(summary, dict):
        notes.append(Note("its summary.json is damaged, so its command and versions are not known", (folder,)))
        return {}
    return summary
