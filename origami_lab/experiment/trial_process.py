"""The worker process of an experiment as its parent sees it; the command's first one begins before it knows its trials.

This module imports next to nothing: while the command reads its configuration, that worker imports already.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from origami_lab.experiment.trial_orders import Begin, Task
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.worker_process import Orders, WorkerProcess

if TYPE_CHECKING:
    from origami_lab.config.settings import Settings


class TrialProcess(WorkerProcess):
    """A worker process and the trial that it was given."""

    def __init__(self) -> None:
        super().__init__(_serve, (), None)
        self.task: Task | None = None
        self.used = False
        """Whether it was ever given a trial; until then it imports, and hears nothing."""
        self.playing = False
        """Whether its trial has reported: only then is there something to save."""
        self.dropped = False
        """Whether it was ended by us, with nothing to save."""

    def begin(self, settings: Settings, first: bool) -> TrialProcess:
        """Tell it the experiment; the first of several loads all kernels. Returns itself."""
        self.limit_calls(settings.objective_seconds)
        self.send(Begin(settings, first))
        return self

    def give(self, task: Task) -> None:
        """Have it run a trial."""
        self.task, self.used, self.playing = task, True, False
        self.send(task)


@contextmanager
def early_process() -> Iterator[TrialProcess]:
    """A worker that imports from now on; it ends with the block, if nobody has ended it before."""
    process = TrialProcess()
    try:
        yield process
    finally:
        process.kill()
        process.bury()


def _serve(orders: Orders, calls: Calls) -> bool:
    from origami_lab.experiment.trial_worker import serve  # there: it imports all that plays

    return serve(orders, calls)
