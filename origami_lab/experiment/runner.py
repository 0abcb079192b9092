"""One experiment from settings to summary: trials in worker processes, results on disk, then tracking."""

from __future__ import annotations

import errno
import math
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.instantiate import build_parts
from origami_lab.config.resumed_settings import like_begun, with_stages
from origami_lab.config.seeds import format_seeds, parse_seeds
from origami_lab.config.settings import Settings, fit_workers
from origami_lab.errors import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK
from origami_lab.experiment.checked_parts import CheckedParts, KeptTarget, look_at
from origami_lab.experiment.progress_display import Display, make_display
from origami_lab.experiment.run_page import FINISHED, RunPage
from origami_lab.experiment.run_summary import summarise
from origami_lab.experiment.trial import is_done, is_searched
from origami_lab.experiment.trial_pool import Event, TrialPool
from origami_lab.experiment.trial_process import TrialProcess
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.experiment.trial_worker import Failed, Finished
from origami_lab.runs.run_folder import NO_ROOM, FolderError, RunFolder, read_summary
from origami_lab.runs.trial_row import STOPPED, TrialRow
from origami_lab.runs.whereabouts import Whereabouts
from origami_lab.text import command_text
from origami_lab.tracking.store import from_here
from origami_lab.tracking.tracker import PATIENCE_SECONDS, Tracker, check_tracking, make_tracker
from origami_lab.workers.interrupts import Interrupts

if TYPE_CHECKING:
    from rich.console import Console


TABLE_SECONDS = 0.5
"""Least time between two writings of the table while trials run."""
HURRIED_SECONDS = 3.0
"""How long the tracker may take when we are to leave at once."""
LOST_TERMINAL = (OSError, SystemExit)
"""Errors of writing to a terminal that is gone; SystemExit is rich's answer to a broken pipe."""


@dataclass(frozen=True)
class Experiment:
    """A finished experiment."""

    folder: Path
    rows: tuple[TrialRow, ...]
    """One a trial, in order of the seeds."""
    summary: dict[str, Any]
    exit_code: int
    """0, 1 if a trial failed, 130 if it was interrupted."""
    left_at_once: bool = False
    """Whether a second interrupt ended the trials where they were."""


def run_experiment(
    settings: Settings,
    console: Console,
    command: Sequence[str] = (),
    interrupts: Interrupts | None = None,
    early: TrialProcess | None = None,
) -> Experiment:
    """Run the trials that the settings ask for.

    A folder that cannot be written any more costs the trials that end meanwhile and not the others. Ctrl-C (SIGTERM,
    SIGHUP) ends the running trials with their best so far, the second one ends all at once; what is known is written,
    tracked and returned in either case.

    Parameters
    ----------
    console
        Where progress goes.
    command
        The command line, for the record.
    interrupts
        What hears the signals, if others are to look at it meanwhile.
    early
        A worker that has begun to import already, to be the first.

    Raises
    ------
    InputError
        Before anything is written, if the settings cannot be used.
    KeyboardInterrupt
        If interrupted before the first trial.
    """
    settings = _as_begun(fit_workers(settings))
    check_tracking(settings)
    with interrupts or Interrupts() as interrupts, TrialPool(settings, early) as pool:
        parts = pool.checked_parts() or look_at(settings, build_parts(settings))  # which says what is wrong with them
        with RunFolder.opened(settings) as folder, Whereabouts(folder.path) as place:
            resumed = folder.has_begun
            rows = folder.known_rows()
            settings = _with_seeds_on_disk(settings, folder, rows)
            todo = tuple(seed for seed in settings.seeds if not is_done(rows.get(seed), settings))
            trouble = _begin(folder, settings, parts)
            draws, at_once = settings.files == "all", settings.workers
            shown = make_display(
                console, settings.verbosity, todo, settings.budget, draws, settings.minutes, workers=at_once
            )
            with _Unfailing(shown) as display:
                if settings.resume and not resumed:
                    display.note(f"nothing to resume in {folder.path} yet: starting")
                elif settings.resume:
                    display.note(_what_is_there(settings, rows, len(todo)))
                for remark in parts.remarks if settings.verbosity != "quiet" else ():
                    display.note(remark)
                record = _Record(settings, folder, place, rows, display, command, parts.target, trouble)
                try:
                    if record.begun:
                        _play(pool, folder, todo, record, display, interrupts)
                finally:
                    interrupts.limit = None
                    left_at_once = interrupts.count > 1
                    pool.close()
                    summary = record.write_summary(interrupted=interrupts.count > 0)
                if summary["interrupted"] and not record.rows and record.begun:
                    display.say(f"no trial had a design yet: resume=true output={folder.path} begins anew")
            code = record.exit_code(interrupted=summary["interrupted"])
            record.finish(interrupts)
    return Experiment(folder.path, record.ordered(), summary, code, left_at_once)


def _what_is_there(settings: Settings, rows: Mapping[int, TrialRow], todo: int) -> str:
    """A line on the trials of a run that is resumed: how many are there, and what is left to do with those."""
    there = [rows[seed] for seed in settings.seeds if seed in rows and rows[seed].spent_budget]
    searched = sum(is_searched(row, settings) for row in there)
    said = [f"{len(there)} of {len(settings.seeds)} trials are on disk"]
    if searched < len(there):
        said.append(f"{len(there) - searched} of them to go on, up to {settings.budget:,} interactions")
    if rest := searched - (len(settings.seeds) - todo):
        said.append(f"{rest} of them to be polished")
    return ", ".join(said)


def _begin(folder: RunFolder, settings: Settings, parts: CheckedParts) -> str:
    """Write the beginning of a run; why the folder cannot take even that, else an empty text."""
    try:
        folder.begin(settings.config, parts.target, parts.start)
    except FolderError as error:
        return error.why
    return ""


def _play(
    pool: TrialPool,
    folder: RunFolder,
    todo: Sequence[int],
    record: _Record,
    display: Display,
    interrupts: Interrupts,
) -> None:
    """Run the trials; the first interrupt stops them, the second one leaves at once."""
    interrupts.limit = 2
    try:
        for event in pool.run(folder, todo):
            display.show(event)
            record.take(event)
            if interrupts.count and not pool.stopping:
                display.say("stopping: saving the best so far (Ctrl-C again to leave at once)")
                pool.stop()
    except KeyboardInterrupt:
        interrupts.limit = None
        display.say("leaving at once")


class _Unfailing:
    """A display that may lose its terminal: the trials go on."""

    def __init__(self, display: Display) -> None:
        self.display = display

    def __enter__(self) -> _Unfailing:
        with suppress(*LOST_TERMINAL):
            self.display.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        with suppress(*LOST_TERMINAL):
            self.display.__exit__(*error)

    def show(self, event: Event) -> None:
        with suppress(*LOST_TERMINAL):
            self.display.show(event)

    def say(self, line: str) -> None:
        with suppress(*LOST_TERMINAL):
            self.display.say(line)

    def note(self, line: str) -> None:
        with suppress(*LOST_TERMINAL):
            self.display.note(line)


class _Record:
    """The record of the trials so far: on disk first, then with the tracker."""

    def __init__(
        self,
        settings: Settings,
        folder: RunFolder,
        place: Whereabouts,
        rows: dict[int, TrialRow],
        display: Display,
        command: Sequence[str],
        target: KeptTarget | None,
        trouble: str,
    ) -> None:
        self.units_per_cell = None if target is None else target.units_per_cell
        self.settings, self.folder, self.place, self.rows = settings, folder, place, rows
        self.display, self.command = display, command
        self.trouble = trouble
        """Why the folder could not be written, if that cost something."""
        self.begun = not trouble
        self.tabled = -math.inf
        """When the table was written last, by the clock that only goes on."""
        before = read_summary(folder.path).get("seconds")
        self.began = time.perf_counter() - (before if isinstance(before, int | float) else 0)
        """When it would have begun in one go: what a resumed run took before counts."""
        seeds, typed = len(settings.seeds), command_text(command)
        self.page = RunPage(folder, settings.config, seeds, typed, settings.open_page)
        self.page.begin(row for seed, row in rows.items() if is_done(row, settings))

    @cached_property
    def tracker(self) -> Tracker:
        """Opened when first needed: the import of mlflow must not delay the first interaction."""
        return make_tracker(self.settings, self.folder.path, self.display.say)

    def take(self, event: Event) -> None:
        """Record what an event says of a trial."""
        match event:
            case Progress() | Polishing():
                _ = self.tracker  # its process gets ready while the trials run
            case Finished(seed, row):
                self._end(seed, row)
            case Failed(seed, reason, traceback, trouble):
                self.trouble = trouble or self.trouble
                message = f"warning: seed {seed} failed: {reason}"
                if traceback:
                    with suppress(OSError):
                        message += f" (traceback in {self.folder.write_error(seed, traceback)})"
                    if self.settings.verbosity == "verbose":
                        message += "\n" + traceback
                self.display.say(message)
                # what ended in its polish keeps what its search has found
                kept = self.folder.rows([seed]).get(seed)
                self._end(seed, kept if kept is not None and kept.spent_budget else TrialRow.failed(seed, reason))
        if self.begun and not self.trouble and not self.place.has_moved:
            self.page.take(event)

    def _end(self, seed: int, row: TrialRow) -> None:
        self.rows[seed] = row
        now = time.monotonic()
        # the whole table, so with very many short trials not after each; a failure is on disk nowhere else
        if row.has_failed or now - self.tabled >= TABLE_SECONDS:
            self.tabled = now
            with suppress(OSError):  # the last one counts
                if not self.place.has_moved:  # another folder may be there now
                    self.folder.write_trials(self.rows.values())
        self.page.end(row)
        self.tracker.trial(seed)

    def ordered(self) -> tuple[TrialRow, ...]:
        return tuple(self.rows[seed] for seed in self.settings.seeds if seed in self.rows)

    def write_summary(self, interrupted: bool) -> dict[str, Any]:
        """Write the table once more and the summary beside it; say what could not be written."""
        seconds = time.perf_counter() - self.began
        summary = summarise(self.settings, self.rows, self.command, seconds, interrupted)
        if self.units_per_cell is not None:
            summary["units_per_cell"] = self.units_per_cell
        if self.begun:
            try:
                if self.place.has_moved:
                    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
                self.folder.write_trials(self.rows.values())
                self.folder.write_summary(summary)
                whole = all(is_done(self.rows.get(seed), self.settings) for seed in self.settings.seeds)
                self.page.write(FINISHED if whole else STOPPED)
            except OSError as error:
                self.trouble = FolderError(error).why
        if self.trouble:
            self.display.say(self._what_now())
        return summary

    def _what_now(self) -> str:
        path, seeds = self.folder.path, len(self.settings.seeds)
        now = self.place.now()
        kept = 0 if now is None else sum(row.spent_budget for row in RunFolder(now).rows().values())
        if now is not None and self.place.has_moved:
            return (
                f"error: {path} could not be written: it was moved to {now} while the trials ran; {kept} of {seeds}"
                f" trials kept there; the same command with resume=true output={now} runs the rest"
            )
        remedy = "make room" if self.trouble in NO_ROOM else "mend that"
        return (
            f"error: {path} could not be written: {self.trouble}; {kept} of {seeds} trials kept; "
            f"{remedy}, then the same command with resume=true output={path} runs the rest"
        )

    def exit_code(self, interrupted: bool) -> int:
        rows = self.rows.values()
        failed = self.trouble or any(row.has_failed or not is_searched(row, self.settings) for row in rows)
        return EXIT_INTERRUPTED if interrupted else EXIT_FAILED if failed else EXIT_OK

    def finish(self, interrupts: Interrupts) -> None:
        """Wait for the tracker: as long as it takes, or a moment if we are to leave at once."""
        if not self.begun:
            return
        patience = HURRIED_SECONDS if interrupts.count > 1 else PATIENCE_SECONDS
        interrupts.limit = interrupts.count + 1  # the next one ends the wait
        with suppress(KeyboardInterrupt):
            self.tracker.finish(patience=patience)
        interrupts.limit = None


def _as_begun(settings: Settings) -> Settings:
    """Settings of a run that goes on: what could not be said when it began is as it was, and its stages are known."""
    folder = RunFolder(settings.output) if settings.resume and settings.output is not None else None
    if folder is None or not folder.has_begun:
        return settings
    begun = folder.config()
    return with_stages(like_begun(settings, begun), begun)


def _with_seeds_on_disk(settings: Settings, folder: RunFolder, rows: Mapping[int, TrialRow]) -> Settings:
    """Settings that name the seeds of a resumed run, too, and whose configuration runs again as it is."""
    seeds = settings.seeds
    if folder.has_begun:
        asked = set(seeds) if settings.seeds_given else set()
        seeds = tuple(sorted(asked | rows.keys() | set(parse_seeds(folder.config().get("seed")))))
    config = {**settings.config, "seed": format_seeds(seeds), "output": None, "resume": False}
    tracking = config.get("tracking")
    if isinstance(tracking, dict) and isinstance(tracking.get("uri"), str):  # where a copy of the project has its own
        config["tracking"] = {**tracking, "uri": from_here(tracking["uri"])}
    return replace(settings, seeds=seeds, config=config)
