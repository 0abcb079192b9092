"""A worker process: runs the trials it is given, one after the other, and reports over its pipe."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from origami_lab.experiment.build import Parts, build_parts
from origami_lab.experiment.folder import RunFolder
from origami_lab.experiment.settings import Settings
from origami_lab.experiment.trial import Progress, run_trial

STOP_CHECK_SECONDS = 0.1


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
    row: dict[str, Any]
    warnings: list[str]


@dataclass(frozen=True)
class Failed:
    """A trial raised, or its process died (no traceback)."""

    seed: int
    reason: str
    traceback: str


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


def serve(pipe: Connection, settings: Settings, kernels: bool) -> None:
    """The worker's main loop: until the parent sends None or goes away.

    Before its first task it imports what that will need, while the parent still checks its input; with
    ``kernels`` it loads the objective's kernels, too (one worker only: on a fresh installation it compiles).
    """
    # the parent gets Ctrl-C too and tells its workers what to do
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # what a user's objective prints must not mix with the parent's tables
    sys.stdout = sys.stderr
    parts: Parts | None = None
    with contextlib.suppress(Exception):  # what is wrong with the input is for the parent to say
        from origami_lab.search.problem import Problem

        parts = build_parts(settings)
        if kernels:
            Problem(parts.game, parts.objective, settings.budget)
    orders = _Orders(pipe)
    try:
        while isinstance(task := pipe.recv(), Task):
            pipe.send(_answer(task, pipe, orders, parts))
            parts = None  # used up: each trial gets fresh ones
    except (EOFError, OSError):  # the parent is gone
        pass


def _answer(task: Task, pipe: Connection, orders: _Orders, parts: Parts | None) -> Finished | Failed:
    try:

        def report(progress: Progress) -> None:
            pipe.send(progress)

        row, warnings = run_trial(task.settings, task.seed, task.folder, report, orders.stop, parts)
        return Finished(task.seed, row, warnings)
    except Exception as error:
        lines = str(error).splitlines() or [""]
        reason = f"{type(error).__name__}: {lines[0]}"[:200]
        return Failed(task.seed, reason.rstrip(": "), traceback.format_exc())
