"""The folder of a multirun: an index of its jobs, one run folder each, and a table of what they found.

::

    multirun.json          the index: what tells the jobs apart, and their folders
    multirun.csv           one row a job; written at the end
    multirun.yaml          Hydra's own record of the command
    cube-rdm/ ...          the run folders, named by what differs

The index is written before the first job starts and read by every job, in whatever process or on whatever machine it
runs, by what writes to MLflow, and by the summary.
"""

from __future__ import annotations

import csv
import io
import json
import re
import uuid
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import zip_longest
from pathlib import Path

from origami_lab.config.node import FREE_TO_CHANGE
from origami_lab.config.seeds import format_seeds, parse_seeds
from origami_lab.errors import InputError
from origami_lab.files import read_json, write_whole
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import FAILED, STOPPED, Spread, TrialRow, best_row, spreads

INDEX, TABLE = "multirun.json", "multirun.csv"
NAMES = ("target", "objective", "search", "experiment")
"""Groups whose options say by themselves what they are."""
_FOUND = (
    *("status", "trials", "asked", "return_mean", "return_std"),
    *("best_return", "best_seed", "interactions"),
)
_FOLDER = re.compile(r"[\w+=-][\w.+=-]*")
"""Names of folders as :meth:`Index.planned` gives them."""
LONGEST = 100
"""Characters of a folder's name."""


@dataclass(frozen=True)
class PlannedJob:
    """One experiment of a multirun."""

    folder: str
    """The name of its run folder."""
    overrides: tuple[str, ...]
    """As Hydra hands them to the job."""
    varied: Mapping[str, str]
    """The keys that had several values in the multirun when the job was added, and this job's."""
    task: str = ""
    method: str = ""
    seeds: str | int | list[int] | None = None
    """All that its folder is to hold, also before it has begun; None in indexes of before they said."""

    @property
    def own(self) -> tuple[str, ...]:
        """The settings beside task and searcher that differ, in short."""
        return tuple(text for key, text in short(self.varied).items() if key not in ("target", "objective", "search"))

    @property
    def name(self) -> str:
        """A job's name for people: settings that differ, task and searcher; a narrow column keeps its beginning."""
        return " · ".join([*self.own, self.task, self.method])

    @property
    def wanted(self) -> tuple[int, ...]:
        """Its seeds, in order; () if the index does not say."""
        return () if self.seeds is None else tuple(sorted(parse_seeds(self.seeds)))

    @property
    def as_it_is(self) -> PlannedJob:
        """The job with all seeds that its folder holds, though the last command asked for some of them only."""
        if self.seeds is None:
            return self
        typed = (f"seed={self.seeds}" if _split(text)[0] == "seed" else text for text in self.overrides)
        return replace(self, overrides=tuple(typed))

    @property
    def differs(self) -> str:
        """The settings that differ, as they are typed."""
        return " ".join(f"{key}={value}" for key, value in self.varied.items())


@dataclass(frozen=True)
class Index:
    """All jobs of a multirun."""

    id: str
    """The folder's name when it was made, and a few letters of its own: the same for all its runs in MLflow."""
    jobs: tuple[PlannedJob, ...] = ()

    @property
    def experiment(self) -> str:
        """The MLflow experiment that holds all of them."""
        return f"multirun-{self.id}"

    def find(self, overrides: Iterable[str]) -> PlannedJob | None:
        """The job that Hydra gives these overrides."""
        wanted = tuple(overrides)
        return next((job for job in self.jobs if job.overrides == wanted), None)

    def heading(self, job: PlannedJob) -> str:
        """Which of the jobs it is."""
        return f"job {self.jobs.index(job) + 1} of {len(self.jobs)}: {job.name}"

    def planned(self, jobs: Sequence[Sequence[str]], seeds: Sequence[Sequence[int]] = ()) -> Index:
        """The index with the jobs of a command: those that are there keep their folders, others get one.

        What a run may change when it is resumed does not make another job, unless jobs differ in it already: those of
        the command, or those of the index when they were added.

        Parameters
        ----------
        seeds
            Those of each job, where they are known.

        Raises
        ------
        InputError
            If two jobs are the same.
        """
        telling = _varied(jobs) | {key for job in self.jobs for key in job.varied}
        # and what tells the new ones from those that are there
        differing = telling | {key for key in _varied([*(job.overrides for job in self.jobs), *jobs]) if _is_fixed(key)}
        found = [job.as_it_is for job in self.jobs]
        there = {_identity(job.overrides, telling, job.wanted): place for place, job in enumerate(found)}
        asked = set[frozenset[tuple[str, str]]]()
        for overrides, own in zip_longest(jobs, seeds, fillvalue=()):
            values = {key: value for key, value in map(_split, overrides) if key in differing}
            identity = _identity(overrides, telling, own)
            if identity in asked:
                key, value = [*map(_split, overrides), *values.items()][-1]
                raise InputError(key, value, "makes the same job twice; every job must be another one")
            asked.add(identity)
            if identity in there:
                place = there[identity]
                found[place] = replace(found[place], overrides=tuple(overrides))
            else:
                named = values or {key: value for key, value in map(_split, overrides) if key in NAMES}
                name = _unique("-".join(short(named).values()), [job.folder for job in found])
                found.append(PlannedJob(name, tuple(overrides), values))
        return replace(self, jobs=tuple(found))


@dataclass(frozen=True)
class JobResult:
    """The result of a job, as it is on disk."""

    job: PlannedJob
    begun: bool
    asked: int
    """How many seeds it is to have; 0 if it was not started and the index does not say."""
    done: int
    """Trials that ran to their end."""
    failed: int
    spread: Spread | None
    """Of the returns."""
    best: TrialRow | None
    """The best trial's row."""
    interactions: int

    @property
    def status(self) -> str:
        if not self.begun:
            return "not run"
        return FAILED if self.failed else "ok" if self.done == self.asked else STOPPED


def new_index(folder: Path) -> Index:
    """An index without jobs."""
    name = re.sub(r"[^\w.-]+", "_", folder.absolute().name)
    return Index(f"{name}-{uuid.uuid4().hex[:4]}")


def read_index(folder: Path) -> Index | None:
    """The index in a folder; None if there is none that can be read."""
    try:
        content = read_json(folder / INDEX)
        jobs = tuple(PlannedJob(**{**job, "overrides": tuple(job["overrides"])}) for job in content["jobs"])
        if not all(_FOLDER.fullmatch(job.folder) for job in jobs):  # they lie in this one
            return None
        return Index(str(content["id"]), jobs)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def write_index(folder: Path, index: Index) -> None:
    """Write it as a whole; raises OSError."""
    write_whole(folder / INDEX, json.dumps(asdict(index), indent=1) + "\n", sync=True)


def membership(run: Path) -> tuple[Index, PlannedJob] | None:
    """The multirun that a run folder belongs to, and which of its jobs it is."""
    run = run.absolute()
    index = read_index(run.parent)
    job = next((job for job in index.jobs if job.folder == run.name), None) if index else None
    return (index, job) if index and job else None


def outcomes(folder: Path, index: Index) -> list[JobResult]:
    """The results of all jobs, in the order of the index."""
    return [_outcome(folder / job.folder, job) for job in index.jobs]


def table_text(found: Sequence[JobResult]) -> str:
    """The text of multirun.csv."""
    keys = list(dict.fromkeys(key for outcome in found for key in outcome.job.varied))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["job", "folder", "task", "method", *keys, *_FOUND])
    for number, outcome in enumerate(found):
        job, spread, best = outcome.job, outcome.spread, outcome.best
        values = dict(map(_split, job.overrides))  # a key may differ only since the multirun was extended
        if job.seeds is not None:  # the last command may have asked for some of them
            values["seed"] = str(job.seeds)
        cells = [number, job.folder, job.task, job.method, *(values.get(key, "") for key in keys)]
        cells += [outcome.status, outcome.done, outcome.asked]
        cells += ["", ""] if spread is None else [spread.mean, "" if spread.std is None else spread.std]
        cells += ["", ""] if best is None else [best.return_, best.seed]
        writer.writerow([*cells, outcome.interactions])
    return text.getvalue()


def short(varied: Mapping[str, str]) -> dict[str, str]:
    """The settings that differ, by key, as short words: ``rdm``, ``population=10``."""
    last = [key.rpartition(".")[2] for key in varied]
    shown = {}
    for key, value in varied.items():
        name = key.rpartition(".")[2]
        shown[key] = value if key in NAMES else f"{name if last.count(name) == 1 else key}={value}"
    return shown


def begun_seeds(folder: Path) -> tuple[int, ...]:
    """The seeds that a run folder was started with; () if none can be read."""
    run = RunFolder(folder)
    with suppress(InputError):
        return parse_seeds(run.config().get("seed")) if run.has_begun else ()
    return ()


def _outcome(folder: Path, job: PlannedJob) -> JobResult:
    run = RunFolder(folder)
    rows = list(run.known_rows().values())
    return JobResult(
        job,
        run.has_begun,
        len({*job.wanted, *begun_seeds(folder)}),
        done=sum(row.spent_budget for row in rows),
        failed=sum(row.has_failed for row in rows),
        spread=spreads(rows).get("return"),
        best=best_row(rows),
        interactions=sum(row.interactions or 0 for row in rows),
    )


def _split(override: str) -> tuple[str, str]:
    key, _, value = override.partition("=")
    return key.lstrip("+"), value.replace("\\", "").strip("'\"")


def _varied(jobs: Sequence[Sequence[str]]) -> set[str]:
    """The keys that do not have the same value in all jobs."""
    values = [dict(map(_split, overrides)) for overrides in jobs]
    return {key for key in set[str]().union(*values) if len({found.get(key) for found in values}) > 1}


def _identity(overrides: Iterable[str], telling: set[str], seeds: Sequence[int]) -> frozenset[tuple[str, str]]:
    """The identity of a job: settings that may not change, and keys in which jobs differ; seeds as numbers."""
    values = dict(map(_split, overrides))
    if seeds:
        values["seed"] = str(format_seeds(sorted(seeds)))
    return frozenset((key, value) for key, value in values.items() if key in telling or _is_fixed(key))


def _is_fixed(key: str) -> bool:
    return key.partition(".")[0] not in FREE_TO_CHANGE


def _unique(text: str, taken: Iterable[str]) -> str:
    """A folder's name that is not taken, also where capitals do not count."""
    used = {name.casefold() for name in taken}
    stem = name = re.sub(r"[^\w.+=-]+", "_", text)[:LONGEST].strip("._") or "job"
    number = 1
    while name.casefold() in used:
        number += 1
        name = f"{stem}_{number}"
    return name
