"""A sweep from its declaration to its summary: join the study, have it played, look on, write."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.errors import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK
from origami_lab.runs.whereabouts import Whereabouts
from origami_lab.sweep.shared_study import SharedStudy
from origami_lab.sweep.storage import PATIENCE, explain, in_plain_words, is_away, storage_name
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.sweep_display import SweepDisplay
from origami_lab.sweep.sweep_page import SweepPage
from origami_lab.sweep.tracking import check_sweep_tracking, make_sweep_tracker
from origami_lab.sweep.worker_pool import WorkerPool
from origami_lab.tracking.tracker import Tracker
from origami_lab.workers.interrupts import Interrupts

if TYPE_CHECKING:
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
    objective_seconds = declaration.compose(declaration.base).objective_seconds
    check_sweep_tracking(declaration)
    with Interrupts() as interrupts, in_plain_words(declaration):
        study = SharedStudy(declaration)
        with Whereabouts(declaration.folder) as place, SweepDisplay(console, quiet, len(declaration.seeds)) as display:
            standing = study.look()
            display.resume(standing.slots, declaration.trials)
            study.write_record(standing)
            page = SweepPage(declaration, command)
            tracker = make_sweep_tracker(declaration, display.say, command)
            with WorkerPool(declaration, objective_seconds, display.say, study.condemn) as pool:
                interrupts.limit = 2
                try:
                    _watch(pool, study, display, tracker, interrupts, page)
                except KeyboardInterrupt:
                    display.say("leaving at once")
                interrupts.limit = None
            for error in pool.errors[:1]:
                kept = "what was played is kept, the same command goes on"
                if place.has_moved:
                    now = place.now()
                    kept = "the folder and what was played is gone" if now is None else f"it was moved to {now}"
                display.say(f"error: {error.error}; {kept}")
            study.release()
            standing = study.look()
            display.show(standing.slots, warm=True)
            study.write_record(standing)
            summary = study.write_summary(standing, command) if standing.done else {}
            if not place.has_moved:
                page.write(standing.slots, "finished" if standing.done else "stopped", summary)
            interrupts.limit = interrupts.count + 1  # the next one ends the wait
            with suppress(KeyboardInterrupt):
                tracker.finish()
            interrupts.limit = None
        code = EXIT_FAILED if pool.errors or standing.failed else EXIT_OK
        if interrupts.count and not standing.done:
            code = EXIT_INTERRUPTED
            display.stopped(standing.slots, command)
        return SweepResult(declaration.folder, code, summary)


def _watch(
    pool: WorkerPool,
    study: SharedStudy,
    display: SweepDisplay,
    tracker: Tracker,
    interrupts: Interrupts,
    page: SweepPage,
) -> None:
    """Look on until all workers have ended; the first interrupt stops them, the second one leaves at once."""
    looked, away = 0.0, 0.0
    while pool.at_work:
        pool.listen(TICK_SECONDS)
        if interrupts.count and not pool.stopping:
            display.stopping = True
            display.say("stopping: a seed that has not ended is played again later (Ctrl-C again to leave at once)")
            pool.stop()
        now = time.monotonic()
        if now - looked < LOOK_SECONDS:
            continue
        looked = now
        try:
            standing = study.look()
            display.show(standing.slots, pool.warm)
            for number in study.write_record(standing):
                tracker.trial(number)
            page.update(standing.slots)
            if standing.compared:
                display.compare(standing.compared)
            away = 0.0
        except Exception as error:
            # the workers wait for the database, too
            if not is_away(error) or (away and now - away > PATIENCE):
                raise
            if not away:
                away = now
                display.say(f"warning: {explain(error, storage_name(study.declaration))}; waiting for it")
