"""One experiment from settings to summary: trials in worker processes, results on disk, then tracking."""

from __future__ import annotations

import platform
import shlex
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import origami_lab
from origami_lab.experiment.build import build_parts
from origami_lab.experiment.folder import RunFolder, failed_row
from origami_lab.experiment.pool import Event, Pool
from origami_lab.experiment.progress import Display, make_display
from origami_lab.experiment.remarks import remarks
from origami_lab.experiment.seeds import format_seeds
from origami_lab.experiment.settings import Settings
from origami_lab.experiment.tracking import Tracker, check_tracking, make_tracker
from origami_lab.experiment.trial import Progress
from origami_lab.experiment.worker import Failed, Finished
from origami_lab.reporting.tables import FAILED, Row, best_row, spent_budget, spreads

if TYPE_CHECKING:
    from rich.console import Console

    from origami_lab.objectives.targets import Target

EXIT_OK, EXIT_FAILED, EXIT_INTERRUPTED = 0, 1, 130
PACKAGES = ("numpy", "numba", "scipy", "trimesh", "hydra-core", "mlflow")


@dataclass(frozen=True)
class Experiment:
    """A finished experiment."""

    folder: Path
    rows: tuple[Row, ...]
    """One a trial, in order of the seeds."""
    summary: dict[str, Any]
    exit_code: int
    """0, 1 if a trial failed, 130 if it was interrupted."""


def run_experiment(settings: Settings, console: Console, command: Sequence[str] = ()) -> Experiment:
    """Run the trials that the settings ask for.

    Parameters
    ----------
    console
        Where progress goes.
    command
        The command line, for the record.

    Raises
    ------
    InputError
        Before anything is written, if the settings cannot be used.
    """
    with _signals() as signals, Pool(settings) as pool:
        # the workers import while the parent checks its input
        check_tracking(settings)
        parts = build_parts(settings)
        target = parts.target
        if signals:
            raise KeyboardInterrupt
        folder = RunFolder.create(settings)
        rows = folder.rows() if settings.resume else {}
        todo = tuple(seed for seed in settings.seeds if seed not in rows or not spent_budget(rows[seed]))
        settings = _with_seeds_on_disk(settings, rows)
        folder.write_config(settings.config)
        if target is not None:
            folder.write_target(target)
        with make_display(console, settings.verbosity, todo, settings.budget) as display:
            if settings.resume:
                display.note(f"{len(settings.seeds) - len(todo)} of {len(settings.seeds)} trials are on disk")
            if settings.verbosity != "quiet":
                for remark in remarks(settings, parts):
                    display.note(remark)
            record = _Record(settings, folder, rows, display, command, target)
            try:
                for event in pool.run(folder, todo):
                    display.show(event)
                    record.take(event)
                    if signals and not pool.stopping:
                        display.say("stopping: saving the best so far (Ctrl-C again to leave at once)")
                        pool.stop()
            finally:
                summary = record.write_summary(interrupted=bool(signals))
    # Ctrl-C is itself again: it ends the wait for a slow tracking server
    record.tracker.finish(summary)
    ordered = tuple(rows[seed] for seed in settings.seeds if seed in rows)
    failed = any(str(row["status"]).startswith(FAILED) for row in ordered)
    code = EXIT_INTERRUPTED if signals else EXIT_FAILED if failed else EXIT_OK
    return Experiment(folder.path, ordered, summary, code)


class _Record:
    """What happened so far: on disk first, then with the tracker."""

    def __init__(
        self,
        settings: Settings,
        folder: RunFolder,
        rows: dict[int, dict[str, Any]],
        display: Display,
        command: Sequence[str],
        target: Target | None,
    ) -> None:
        self.units_per_cell = None if target is None else target.units_per_cell
        self.settings, self.folder, self.rows = settings, folder, rows
        self.display, self.command = display, command
        self.began = time.perf_counter()

    @cached_property
    def tracker(self) -> Tracker:
        """Opened when first needed: the import of mlflow must not delay the first interaction."""
        return make_tracker(self.settings, self.folder.path, self.display.say)

    def take(self, event: Event) -> None:
        """Record what an event says of a trial."""
        match event:
            case Progress():
                _ = self.tracker  # it gets ready in its own thread while the trials run
            case Finished(seed, row):
                self._end(seed, row)
            case Failed(seed, reason, traceback):
                message = f"warning: seed {seed} failed: {reason}"
                if traceback:
                    message += f" (traceback in {self.folder.write_error(seed, traceback)})"
                    if self.settings.verbosity == "verbose":
                        message += "\n" + traceback
                self.display.say(message)
                self._end(seed, failed_row(seed, reason))

    def _end(self, seed: int, row: dict[str, Any]) -> None:
        self.rows[seed] = row
        self.folder.write_trials(self.rows.values())
        self.tracker.trial(row)

    def write_summary(self, interrupted: bool) -> dict[str, Any]:
        """Write the table once more and the summary beside it."""
        self.folder.write_trials(self.rows.values())
        seconds = time.perf_counter() - self.began
        summary = summarise(self.settings, self.rows, self.command, seconds, interrupted)
        if self.units_per_cell is not None:
            summary["units_per_cell"] = self.units_per_cell
        self.folder.write_summary(summary)
        return summary


def summarise(
    settings: Settings,
    rows: dict[int, dict[str, Any]],
    command: Sequence[str],
    seconds: float,
    interrupted: bool,
) -> dict[str, Any]:
    """The contents of summary.json."""
    best = best_row(rows.values())
    statuses = [str(row["status"]).split(":")[0] for row in rows.values()]
    return {
        "task": settings.task,
        "search": settings.method,
        "budget": settings.budget,
        "seeds": format_seeds(settings.seeds),
        "trials": {name: statuses.count(name) for name in sorted(set(statuses))},
        "interrupted": interrupted,
        "returns": {name: asdict(spread) for name, spread in spreads(rows.values()).items()},
        "std": "sample standard deviation (n - 1)",
        "best": None if best is None else {name: best.get(name) for name in ("seed", "return", "driving_angle")},
        "interactions": sum(int(row.get("interactions") or 0) for row in rows.values()),
        "seconds": round(seconds, 3),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": shlex.join(command),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """What the results were computed with."""
    found = {"origami-lab": origami_lab.__version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _with_seeds_on_disk(settings: Settings, rows: dict[int, dict[str, Any]]) -> Settings:
    """Settings that also name the seeds on disk, and whose configuration runs again as it is."""
    seeds = tuple(sorted(rows.keys() | set(settings.seeds))) if rows else settings.seeds
    config = {**settings.config, "seed": format_seeds(seeds), "output": None, "resume": False}
    return replace(settings, seeds=seeds, config=config)


@contextmanager
def _signals() -> Iterator[list[int]]:
    """Collect Ctrl-C and SIGTERM in a list instead of raising; the second one raises KeyboardInterrupt."""
    arrived: list[int] = []

    def handle(number: int, frame: object) -> None:
        arrived.append(number)
        if len(arrived) > 1:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():  # only the main thread may set handlers
        yield arrived
        return
    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield arrived
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
