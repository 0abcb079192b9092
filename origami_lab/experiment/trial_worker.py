"""A worker process: runs the trials it is given, one after the other, and reports over its pipe."""

from __future__ import annotations

import contextlib
import sys
import traceback
from dataclasses import dataclass, replace
from importlib import import_module

from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.settings import Settings
from origami_lab.config.trusted_code import names_only_ours
from origami_lab.experiment.checked_parts import CheckedParts, look_at
from origami_lab.experiment.kernel_loading import load_kernels, warm_up
from origami_lab.experiment.trial import run_trial
from origami_lab.experiment.trial_orders import Begin, Task
from origami_lab.runs.run_folder import FolderError
from origami_lab.runs.trial_row import TrialRow
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.worker_process import Orders, reason_of


@dataclass(frozen=True)
class Compiling:
    """A worker compiles kernels."""


@dataclass(frozen=True)
class Compiled:
    """A worker has all kernels of a run; compiling took so many seconds, 0 if they were on disk."""

    seconds: float


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
    """The folder's trouble, if the trial failed because its files could not be written."""


def serve(orders: Orders, calls: Calls) -> bool:
    """Run trials until the parent has no more or goes away.

    Before it is told its experiment a worker imports what plays; then it makes its parts. The experiment's first
    worker tells of them (:class:`CheckedParts`; of nothing, where something is wrong with them) and loads all kernels
    (only one does: on a fresh installation it compiles); the others load them with their first task.

    Returns whether nothing but this package's own code has run, so that there is nothing to wait for at its end.
    """
    with contextlib.suppress(Exception):  # what is wrong with the installation is for the parent to say
        _import_what_plays()
    begin = orders.next()
    if not isinstance(begin, Begin):
        return True
    settings, kernels = begin.settings, begin.kernels
    sys.path += [place for place in begin.importable if place not in sys.path]
    first: Parts | None = None
    parts: Parts | None = None
    with contextlib.suppress(Exception):  # what is wrong with the input is for the parent to say
        first = parts = _build(settings, calls)
    if kernels:
        orders.say(_looked_at(settings, first))
    with contextlib.suppress(Exception):
        if kernels and first is not None:
            seconds = warm_up(settings, first, lambda: orders.say(Compiling()))
            if seconds is not None:
                orders.say(Compiled(seconds))
    while isinstance(task := orders.next(), Task):
        if not kernels and first is not None:
            kernels = True
            with contextlib.suppress(Exception):
                load_kernels(settings, first)
        orders.say(_answer(task, orders, parts, first, calls))
        parts = None  # used up: each trial gets fresh ones
    return names_only_ours(settings.config)


def _import_what_plays() -> None:
    """Import what every run needs, and have numba get ready, which takes as long."""
    import_module("origami_lab.game.kernels.play")
    import_module("origami_lab.jit").get_ready(0)


def _looked_at(settings: Settings, parts: Parts | None) -> CheckedParts | None:
    if parts is None:
        return None
    with contextlib.suppress(Exception):
        return look_at(settings, parts)
    return None


def _build(settings: Settings, calls: Calls, earlier: Parts | None = None) -> Parts:
    from origami_lab.workers.guarded_objective import watched  # here: the parent does not need the game that it imports

    parts = build_parts(settings, earlier)
    return replace(parts, objective=watched(parts.objective, calls))


def _answer(task: Task, orders: Orders, parts: Parts | None, earlier: Parts | None, calls: Calls) -> Finished | Failed:
    def fresh() -> Parts:
        return _build(task.settings, calls, earlier)

    try:
        parts = parts or fresh()
        row, warnings = run_trial(task.settings, task.seed, task.folder, orders.say, orders.stop, parts, fresh)
        return Finished(task.seed, row, warnings)
    except FolderError as error:
        return Failed(task.seed, f"cannot write its files: {error.why}", "", error.why)
    except BaseException as error:  # also what a user's objective may do to end a program
        return Failed(task.seed, reason_of(error), traceback.format_exc())
