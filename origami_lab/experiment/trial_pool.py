"""The worker processes of an experiment: one trial after the other is given to each.

Not a library's pool, because three things must hold together: progress while a trial runs, a stop order that
saves the best so far, and a worker that crashes (is killed for its memory, hangs) failing one seed and no other.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from origami_lab.config.settings import Settings
from origami_lab.experiment.checked_parts import CheckedParts
from origami_lab.experiment.kernel_loading import can_compile_beside, compile_beside
from origami_lab.experiment.trial_orders import Task
from origami_lab.experiment.trial_process import TrialProcess
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.experiment.trial_worker import Compiled, Compiling, Failed, Finished
from origami_lab.runs.run_folder import RunFolder
from origami_lab.workers.worker_process import STOP, WorkerProcess, hear

TICK_SECONDS = 0.1
HEAD_START_SECONDS = 15.0
"""How long the first trial plays alone if it finds nothing."""


@dataclass(frozen=True)
class Started:
    """A worker took up a trial."""

    seed: int


@dataclass(frozen=True)
class Tick:
    """Nothing happened for a moment: time to refresh the display."""


Event = Started | Compiling | Compiled | Progress | Polishing | Finished | Failed | Tick


class TrialPool:
    """Worker processes. They start at once; the first makes the parts and loads kernels before it is given a trial.

    Parameters
    ----------
    early
        A worker that has begun to import already, to be the first.
    """

    def __init__(self, settings: Settings, early: TrialProcess | None = None) -> None:
        self._settings = settings
        self._workers = [(early or TrialProcess()).begin(settings, first=True)]
        while len(self._workers) < min(settings.workers, len(settings.seeds)):
            self._workers.append(TrialProcess().begin(settings, first=False))
        self._compiler: WorkerProcess | None = None
        self.stopping = False

    def checked_parts(self) -> CheckedParts | None:
        """What the first worker says of the parts that it has made; None if it could not make them, or died."""
        first = self._workers[0]
        while first.process.is_alive() or first.pipe.poll():
            for _, answer in hear([first], TICK_SECONDS):
                return answer if isinstance(answer, CheckedParts) else None
        return None

    def run(self, folder: RunFolder, seeds: Sequence[int]) -> Iterator[Event]:
        """Run one trial for each seed and yield what happens, until all have ended.

        The first worker goes ahead until it has all kernels, or its trial has found something or has looked for a
        while: on a fresh installation it compiles the kernels that the others then load.
        """
        todo = deque(seeds)
        ready, first_report = False, math.inf
        for idle in self._workers[max(len(todo), 1) :]:  # of a resumed run there may be less to do
            idle.kill()
            idle.bury()
        del self._workers[max(len(todo), 1) :]
        while True:
            if not self.stopping:
                for worker in self._workers if ready else self._workers[:1]:
                    if worker.task is None and todo:
                        seed = todo.popleft()
                        if not worker.process.is_alive():  # it died between two trials
                            worker = self._replace(worker)
                        worker.give(Task(self._settings, folder, seed))
                        yield Started(seed)
            busy = [worker for worker in self._workers if worker.task is not None]
            if not busy and (not todo or self.stopping):
                return
            events = list(self._listen(busy))
            if first_report == math.inf and any(isinstance(event, Progress) for event in events):
                first_report = time.monotonic()
            if any(isinstance(event, Compiling) for event in events) and can_compile_beside():
                self._compiler = WorkerProcess(compile_beside, (self._settings,), None)
            ready = ready or any(_is_under_way(event) for event in events)
            if ready:
                self._end_compiler()
            ready = ready or time.monotonic() - first_report > HEAD_START_SECONDS
            yield from events or [Tick()]

    def stop(self) -> None:
        """Ask the running trials to save their best so far and end; start no others."""
        if self.stopping:
            return
        self.stopping = True
        self._end_compiler()
        for worker in self._workers:
            if worker.task is None:
                continue
            if not worker.playing and not worker.pipe.poll():  # still loading or compiling: nothing to save
                worker.dropped = True
                worker.kill()
            else:
                worker.send(STOP)

    def close(self) -> None:
        """End all workers, whatever they are doing. More than once does no harm."""
        self._end_compiler()
        for worker in self._workers:
            if worker.task is None and worker.used:
                worker.send(None)
            else:
                worker.kill()
        for worker in self._workers:
            worker.bury()
        self._workers = []

    def __enter__(self) -> TrialPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _end_compiler(self) -> None:
        """End the process that compiles beside the first worker, if there is one: nothing of it is lost."""
        if self._compiler is not None:
            self._compiler.kill()
            self._compiler.bury()
            self._compiler = None

    def _listen(self, busy: Sequence[TrialProcess]) -> Iterator[Event]:
        for worker, event in hear(busy, TICK_SECONDS):
            if event is None:
                yield self._bury(worker)
                continue
            if isinstance(event, Compiling | Compiled):
                yield event
                continue
            worker.playing = True
            if isinstance(event, Finished | Failed):
                worker.task = None
            yield event
        for worker in busy:
            if worker.task is not None and (reason := worker.hangs()):
                worker.kill()
                yield self._bury(worker, reason)

    def _bury(self, worker: TrialProcess, reason: str = "") -> Event:
        """A worker died with its trial. Another takes its place."""
        task, worker.task = worker.task, None
        assert task is not None
        cause = worker.bury()
        if not self.stopping:
            self._replace(worker)
        elif worker.dropped:
            return Tick()
        return Failed(task.seed, reason or f"the worker process died ({cause})", "")

    def _replace(self, worker: TrialProcess) -> TrialProcess:
        """A fresh process in a dead one's place."""
        worker.bury()
        fresh = TrialProcess().begin(self._settings, first=False)
        self._workers[self._workers.index(worker)] = fresh
        return fresh


def _is_under_way(event: Event) -> bool:
    """Whether all kernels are on disk, or a trial has played and certified a design, or is over."""
    return isinstance(event, Compiled | Polishing | Finished | Failed) or (
        isinstance(event, Progress) and event.best is not None
    )
