"""A worker process: runs the trials it is given, one after the other, and reports over its pipe."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
import traceback
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Any

from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.trial import Progress, run_trial
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.trial_row import TrialRow
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.interrupts import ignore_interrupts
from origami_lab.workers.worker_process import STOP_CHECK_SECONDS, leave_with_parent, reason_of


@dataclass(frozen=True)
class Task:
    """What a worker is asked: run one trial."""

    settings: Settings
    folder: RunFolder
    seed: int


@dataclass(frozen=True)
class Finished:
    """A trial is on disk."""

    seed: int
    row: TrialRow
    warnings: list[str]


@dataclass(frozen=True)
class Failed:
    """A trial raised, or its process died (no traceback)."""

    seed: int
    reason: str
    traceback: str
    folder_trouble: str = ""
    """What kept it from writing its files, if that is what it failed for."""


class _Orders:
    """The worker's end of the pipe: asks now and then whether to stop, and leaves if the parent is gone."""

    def __init__(self, pipe: Connection) -> None:
        self.pipe, self.stopped, self.checked = pipe, False, 0.0

    def stop(self) -> bool:
        """Whether the running trial shall end. Called often: looks at the pipe ten times a second."""
        now = time.monotonic()
        if not self.stopped and now - self.checked >= STOP_CHECK_SECONDS:
            self.checked = now
            if self.pipe.poll():
                self.stopped = True
                try:
                    self.pipe.recv()
                except (EOFError, OSError):  # the parent was killed: nobody waits for this result
                    os._exit(1)
        return self.stopped


def serve(pipe: Connection, settings: Settings, call_number: Any, kernels: bool) -> None:
    """The worker's main loop: until the parent sends None or goes away.

    Before its first task it imports what that will need, while the parent still checks its input; with
    ``kernels`` it loads the objective's kernels, too (one worker only: on a fresh installation it compiles).

    Parameters
    ----------
    call_number
        Where it writes the number of the call of a user's objective that it is in.
    """
    # the parent gets them too and tells its workers what to do
    ignore_interrupts()
    threading.Thread(target=leave_with_parent, daemon=True, name="parent").start()
    # what a user's objective prints must not mix with the parent's tables
    sys.stdout = sys.stderr
    calls = Calls(call_number)
    parts: Parts | None = None
    with contextlib.suppress(Exception):  # what is wrong with the input is for the parent to say
        from origami_lab.search.problem import Problem

        parts = _build(settings, calls)
        if kernels:
            Problem(parts.game, parts.objective, settings.budget)
    orders = _Orders(pipe)
    try:
        while isinstance(task := pipe.recv(), Task):
            pipe.send(_answer(task, pipe, orders, parts, calls))
            parts = None  # used up: each trial gets fresh ones
    except (EOFError, OSError):  # the parent is gone
        pass


def _build(settings: Settings, calls: Calls) -> Parts:
    from origami_lab.workers.guarded_objective import watched  # here: the parent does not need the game that it imports

    parts = build_parts(settings)
    return replace(parts, objective=watched(parts.objective, calls))


def _answer(task: Task, pipe: Connection, orders: _Orders, parts: Parts | None, calls: Calls) -> Finished | Failed:
    def report(progress: Progress) -> None:
        pipe.send(progress)

    try:
        parts = parts or _build(task.settings, calls)
        row, warnings = run_trial(task.settings, task.seed, task.folder, report, orders.stop, parts)
        return Finished(task.seed, row, warnings)
    except FolderError as error:
        return Failed(task.seed, f"cannot write its files: {error.why}", "", error.why)
    except BaseException as error:  # also what a user's objective may do to end a program
        return Failed(task.seed, reason_of(error), traceback.format_exc())
