"""Worker processes that run trials: one pipe each, so that a dead worker costs its own trial only.

Not a library's pool, because three things must hold together: progress while a trial runs, a stop order that
saves the best so far, and a worker that crashes (is killed for its memory, hangs) failing one seed and no other.
"""

from __future__ import annotations

import math
import multiprocessing
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from origami_lab.config.settings import Settings
from origami_lab.experiment.trial import Progress
from origami_lab.experiment.trial_worker import Failed, Finished, Task, serve
from origami_lab.runs.run_folder import RunFolder
from origami_lab.workers.call_limit import CallLimit
from origami_lab.workers.worker_process import JOIN_SECONDS, start_apart

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


Event = Started | Progress | Finished | Failed | Tick


@dataclass(eq=False)
class _Worker:
    process: SpawnProcess
    pipe: Connection
    limit: CallLimit
    task: Task | None = None
    used: bool = False
    """Whether it was ever given a trial; until then it imports, and hears nothing."""
    playing: bool = False
    """Whether its trial has reported: only then is there something to save."""
    dropped: bool = False
    """Whether it was ended by us, with nothing to save."""


class Pool:
    """Worker processes. The first starts at once, and imports while the parent still checks its input."""

    def __init__(self, settings: Settings) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._settings = settings
        self._workers = [self._start(first=True)]
        self.stopping = False

    def run(self, folder: RunFolder, seeds: Sequence[int]) -> Iterator[Event]:
        """Run one trial for each seed and yield what happens, until all have ended.

        The first trial goes ahead until it has found something, or has looked for a while: on a fresh installation
        it compiles the kernels that the others then load.
        """
        todo = deque(seeds)
        ready, first_report = False, math.inf
        while len(self._workers) < min(self._settings.workers, len(todo)):
            self._workers.append(self._start())
        while True:
            if not self.stopping:
                for worker in self._workers if ready else self._workers[:1]:
                    if worker.task is None and todo:
                        seed = todo.popleft()
                        self._give(worker, Task(self._settings, folder, seed))
                        yield Started(seed)
            busy = [worker for worker in self._workers if worker.task is not None]
            if not busy and (not todo or self.stopping):
                return
            events = list(self._listen(busy))
            if first_report == math.inf and any(isinstance(event, Progress) for event in events):
                first_report = time.monotonic()
            ready = ready or any(_is_under_way(event) for event in events)
            ready = ready or time.monotonic() - first_report > HEAD_START_SECONDS
            yield from events or [Tick()]

    def stop(self) -> None:
        """Ask the running trials to save their best so far and end; start no others."""
        if self.stopping:
            return
        self.stopping = True
        for worker in self._workers:
            if worker.task is None:
                continue
            if not worker.playing and not worker.pipe.poll():  # still loading or compiling: nothing to save
                worker.dropped = True
                worker.process.kill()
                continue
            with suppress(OSError):  # it died; _listen will say so
                worker.pipe.send("stop")

    def close(self) -> None:
        """End all workers, whatever they are doing. More than once does no harm."""
        for worker in self._workers:
            try:
                if worker.task is None and worker.used:
                    worker.pipe.send(None)
                else:
                    worker.process.kill()
                worker.pipe.close()
            except OSError:
                pass
        for worker in self._workers:
            worker.process.join(JOIN_SECONDS)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self, first: bool = False) -> _Worker:
        ours, theirs = self._context.Pipe()
        limit = CallLimit(self._context, self._settings.objective_seconds)
        arguments = (theirs, self._settings, limit.number, first)
        process = self._context.Process(target=serve, args=arguments, daemon=True)
        start_apart(process)
        theirs.close()
        return _Worker(process, ours, limit)

    def _give(self, worker: _Worker, task: Task) -> None:
        if not worker.process.is_alive():  # between two trials
            self._replace(worker)
        worker.task, worker.used, worker.playing = task, True, False
        with suppress(OSError):  # it died; _listen will say so
            worker.pipe.send(task)

    def _listen(self, busy: Sequence[_Worker]) -> Iterator[Event]:
        by_pipe: dict[object, _Worker] = {worker.pipe: worker for worker in busy}
        for pipe in wait(list(by_pipe), TICK_SECONDS):  # type: ignore[arg-type]
            worker = by_pipe[pipe]
            try:
                event = worker.pipe.recv()
            except (EOFError, OSError):
                yield self._bury(worker)
                continue
            worker.playing = True
            if not isinstance(event, Progress):
                worker.task = None
            yield event
        for worker in busy:
            if worker.task is not None and worker.limit.exceeded():
                worker.process.kill()
                limit = f"objective_seconds={worker.limit.seconds:g}"
                yield self._bury(worker, f"the objective took longer than {limit} in one call")

    def _bury(self, worker: _Worker, reason: str = "") -> Event:
        """A worker died with its trial. Another takes its place."""
        task = worker.task
        assert task is not None
        worker.process.join(JOIN_SECONDS)
        if worker.process.is_alive():  # it lost no more than its pipe
            worker.process.kill()
            worker.process.join()
        code = worker.process.exitcode
        worker.task = None
        if self.stopping:
            worker.pipe.close()
            if worker.dropped:
                return Tick()
        else:
            self._replace(worker)
        cause = f"killed by signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        return Failed(task.seed, reason or f"the worker process died ({cause})", "")

    def _replace(self, worker: _Worker) -> None:
        """A fresh process in a dead one's place."""
        worker.pipe.close()
        fresh = self._start()
        worker.process, worker.pipe, worker.limit, worker.used = fresh.process, fresh.pipe, fresh.limit, False


def _is_under_way(event: Event) -> bool:
    """Whether a trial has played and certified a design, or is over."""
    return isinstance(event, Finished | Failed) or (isinstance(event, Progress) and event.best is not None)
