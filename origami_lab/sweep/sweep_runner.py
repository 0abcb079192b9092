"""A sweep from its declaration to its outcome: join the study, play, compare, write."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.errors import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK, InputError
from origami_lab.runs.run_folder import FolderError
from origami_lab.sweep.storage import (
    KEY,
    PATIENCE,
    TROUBLE,
    StorageError,
    explain,
    is_away,
    known_study,
    open_storage,
    storage_name,
)
from origami_lab.sweep.studies import HeldOutJob, SearchJob, best_place, check_comparison, check_space, point_of
from origami_lab.sweep.study_record import read_record, record_of, write_record
from origami_lab.sweep.summary import SweepSummary
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.sweep_display import SweepDisplay
from origami_lab.sweep.tracking import check_sweep_tracking, make_sweep_tracker
from origami_lab.sweep.trial_queue import STOPPED, Slot, TrialQueue
from origami_lab.sweep.worker_identity import Worker
from origami_lab.sweep.worker_pool import Crew
from origami_lab.tracking.tracker import Tracker
from origami_lab.workers.interrupts import Interrupts

if TYPE_CHECKING:
    from optuna.storages import BaseStorage
    from rich.console import Console

TICK_SECONDS = 0.2
LOOK_SECONDS = 1.0
"""How often the parent looks at the study."""


@dataclass(frozen=True)
class SweepResult:
    """A sweep that has ended, here."""

    folder: Path
    exit_code: int
    """0, 1 if a trial failed or something broke, 130 if it was interrupted."""
    summary: dict[str, Any] = field(default_factory=dict)
    """Empty unless all trials are done."""


def run_sweep(declaration: Declaration, console: Console, command: Sequence[str], quiet: bool = False) -> SweepResult:
    """Play a sweep's trials, or those that are left, and write what it found.

    Several processes on several machines may do this at once: they share the study.

    Raises
    ------
    InputError
        Before anything is played, if the declaration cannot be used or is not the study's.
    StorageError
        If the storage does not answer, or the folder cannot be written.
    """
    base = declaration.compose(declaration.base)
    check_sweep_tracking(declaration)
    with Interrupts() as interrupts, _in_plain_words(declaration):
        study = SharedStudy.opened(declaration)
        with SweepDisplay(console, quiet, len(declaration.seeds)) as display:
            display.resume(study.look(), declaration.trials)
            study.write_record()
            tracker = make_sweep_tracker(declaration, display.say, command)
            with Crew(declaration, base.objective_seconds, display.say, study.condemn) as crew:
                interrupts.limit = 2
                try:
                    _watch(crew, study, display, tracker, interrupts)
                except KeyboardInterrupt:
                    display.say("leaving at once")
                interrupts.limit = None
            study.release()
            study.write_record()
            done = study.done
            summary = study.write_outcome(command) if done else {}
            interrupts.limit = interrupts.count + 1  # the next one ends the wait
            with suppress(KeyboardInterrupt):
                tracker.finish()
            interrupts.limit = None
        for error in crew.errors[:1]:
            display.say(f"error: {error.error}; what was played is kept, the same command goes on")
        places = study.look()
        compared = study.look_at_comparison().values() if done else ()
        failed = crew.errors or any(place.state == "failed" for place in (*places, *compared))
        code = EXIT_FAILED if failed else EXIT_OK
        if interrupts.count and not done:
            code = EXIT_INTERRUPTED
            display.stopped(places, command)
        return SweepResult(declaration.folder, code, summary)


def _watch(crew: Crew, study: SharedStudy, display: SweepDisplay, tracker: Tracker, interrupts: Interrupts) -> None:
    """Look on until all workers have ended; the first interrupt stops them, the second one leaves at once."""
    looked, away = 0.0, 0.0
    while crew.at_work:
        crew.listen(TICK_SECONDS)
        if interrupts.count and not crew.stopping:
            display.stopping = True
            display.say("stopping: a seed that has not ended is played again later (Ctrl-C again to leave at once)")
            crew.stop()
        now = time.monotonic()
        if now - looked < LOOK_SECONDS:
            continue
        looked = now
        try:
            _look(crew, study, display, tracker)
            away = 0.0
        except Exception as error:
            # the workers wait for the database, too
            if not is_away(error) or (away and now - away > PATIENCE):
                raise
            if not away:
                away = now
                display.say(f"warning: {explain(error, study.name)}; waiting for it")
    display.show(study.look(), warm=True)


def _look(crew: Crew, study: SharedStudy, display: SweepDisplay, tracker: Tracker) -> None:
    places = study.look()
    display.show(places, crew.warm)
    for _ in range(study.write_record(places)):
        tracker.trial()
    if all(place.done for place in places):
        display.compare(study.look_at_comparison())


class SharedStudy:
    """The study as the parent of the workers sees it."""

    def __init__(self, declaration: Declaration, storage: BaseStorage) -> None:
        self.declaration, self.storage = declaration, storage
        self.worker = Worker.this()
        self.places = SearchJob(declaration).places(storage, self.worker)
        self.comparison: HeldOutJob | None = None
        self.compared: TrialQueue | None = None
        self._written = -1

    @classmethod
    def opened(cls, declaration: Declaration) -> SharedStudy:
        """Join the study, or make it with all its places.

        Raises
        ------
        InputError
            If it was declared otherwise, something in the space cannot be played, or the folder is another study's.
        """
        folder = declaration.folder
        # nothing is written before the declaration is known to be good
        known = known_study(declaration)
        if (folder / "trials").is_dir() and (known is None or known != _key_in(folder, known)):
            expected = f"holds trials of a study that {storage_name(declaration)} does not have; choose another one"
            raise InputError("output", folder, expected)
        if known is None:
            check_space(declaration)
        check_comparison(declaration)
        _check_writable(folder)
        study = cls(declaration, open_storage(declaration))
        study.places.fill()
        return study

    @property
    def name(self) -> str:
        """Its storage, for people."""
        return storage_name(self.declaration)

    @property
    def key(self) -> str:
        """What its MLflow runs bear, on all machines."""
        return str(self.places.study.user_attrs[KEY])

    def look(self) -> list[Slot]:
        return self.places.look()

    @property
    def done(self) -> bool:
        """Whether all trials and, if any of them was played to the end, the comparison are done."""
        places = self.look()
        if not all(place.done for place in places):
            return False
        return all(place.done for place in self.look_at_comparison().values())

    def look_at_comparison(self) -> dict[str, Slot]:
        """How far the comparison is, by the names of the settings: to be asked when all trials are done.

        It is empty if no trial was played to its end.
        """
        best = best_place(self.look())
        if best is None:
            return {}
        # another machine may have added trials, and one of them may be better
        if self.comparison is None or self.compared is None or self.comparison.best != point_of(best):
            self.comparison = HeldOutJob(self.declaration, point_of(best))
            self.compared = self.comparison.places(self.storage, self.worker)
        return dict(zip(self.comparison.names, self.compared.look(), strict=True))

    def condemn(self, pid: int, reason: str) -> None:
        """Let the trial fail that a worker of this machine plays, before the worker is killed."""
        for places in filter(None, (self.places, self.compared)):
            places.condemn(pid, reason)

    def release(self) -> None:
        """Let others at once have the trials of workers that had to be ended."""
        for places in filter(None, (self.places, self.compared)):
            places.reap(STOPPED)

    def write_record(self, places: Sequence[Slot] | None = None) -> int:
        """Write what has ended, if there is more of it; how many trials more."""
        places = self.look() if places is None else places
        ended = sum(place.done for place in places)
        more = ended - max(self._written, 0)
        if ended != self._written:
            record = record_of(self.declaration, self.key, places)
            write_record(self.declaration.folder, record, [parameter.name for parameter in self.declaration.space])
            self._written = ended
        return more

    def write_outcome(self, command: Sequence[str]) -> dict[str, Any]:
        """Write what the sweep found; returns the summary."""
        compared = self.look_at_comparison()
        record = record_of(self.declaration, self.key, self.look())
        outcome = SweepSummary(self.declaration, self.places.study, record, self.comparison, compared, command)
        return outcome.write()


def _key_in(folder: Path, default: str) -> str:
    """The key of the study whose trials are in a folder; the default if it does not tell."""
    try:
        return str(read_record(folder)["key"])
    except (OSError, ValueError, KeyError):
        return default


def _check_writable(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        expected = f"must be a folder that can be written ({error.strerror or error})"
        raise InputError("output", folder, expected) from error


@contextmanager
def _in_plain_words(declaration: Declaration) -> Iterator[None]:
    """What is wrong with the storage or the disk becomes a StorageError."""
    try:
        yield
    except OSError as error:
        raise StorageError(f"{declaration.folder} could not be written: {FolderError(error).why}") from error
    except TROUBLE as error:
        raise StorageError(explain(error, storage_name(declaration))) from error
