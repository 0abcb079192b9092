"""A process that plays trials, as experiments and sweeps start, watch and end it; and its own end of the pipe."""

from __future__ import annotations

import atexit
import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from origami_lab.caches import KERNELS, kernel_cache
from origami_lab.errors import InputError
from origami_lab.streams import make_robust, open_descriptors
from origami_lab.workers.call_limit import CallLimit, Calls
from origami_lab.workers.interrupts import blocked_interrupts, ignore_interrupts

JOIN_SECONDS = 2.0
"""How long a process that was told to leave may take to end."""
STOP_CHECK_SECONDS = 0.1
_THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA")
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _THREADS}
"""A trial is one thread: the cores are for other trials."""
STOP = "stop"
"""The order to end the running trial."""


class WorkerProcess:
    """A process with a pipe of its own, so that its death costs its own trial only.

    It uses one core, hears no Ctrl-C, imports nothing of the parent's script, and ends when the parent is killed.

    Parameters
    ----------
    serve
        Called there with an :class:`Orders`, the :class:`Calls` that number those of a user's objective, and the
        arguments; the process ends when it returns, at once if it says so by returning True.
    arguments
        Further arguments of ``serve``; pickled.
    objective_seconds
        Longest that one call of a user's objective may take; None for no limit.
    """

    def __init__(
        self, serve: Callable[..., object], arguments: Sequence[object], objective_seconds: float | None
    ) -> None:
        open_descriptors()  # or the pipe would be what the process prints to
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._limit = CallLimit(context, objective_seconds)
        self.process: SpawnProcess = context.Process(
            target=_serve, args=(serve, theirs, self._limit.number, *arguments), daemon=True
        )
        kept = kernel_cache()  # what is odd about it is for this process to say, once
        known = {KERNELS: str(kept.base)} if kept.remark and kept.base else {}
        with _environment({**ONE_THREAD, **known}), _hidden_main(), blocked_interrupts(), _no_daemon():
            self.process.start()
        theirs.close()

    def send(self, message: object) -> None:
        """Give an order. One that died does not hear it; :func:`hear` tells of its death."""
        with suppress(OSError):
            self.pipe.send(message)

    def limit_calls(self, objective_seconds: float | None) -> None:
        """Set the longest that one call of a user's objective may take; None for no limit."""
        self._limit.seconds = objective_seconds

    def hangs(self) -> str:
        """The reason to kill it for its present call of the objective; empty if there is none.

        To be asked several times a second.
        """
        if not self._limit.exceeded():
            return ""
        return f"the objective took longer than objective_seconds={self._limit.seconds:g} in one call"

    def kill(self) -> None:
        """End the process, whatever it is doing; :meth:`bury` waits for its end."""
        self.process.kill()

    def bury(self) -> str:
        """Wait for the end of a process that died or was told to leave; returns how it ended."""
        self.process.join(JOIN_SECONDS)
        if self.process.is_alive():  # it lost no more than its pipe
            self.process.kill()
            self.process.join()
        self.pipe.close()
        code = self.process.exitcode
        return f"killed by signal {-code}" if code is not None and code < 0 else f"exit code {code}"


AnyWorker = TypeVar("AnyWorker", bound=WorkerProcess)


def hear(workers: Sequence[AnyWorker], seconds: float) -> Iterator[tuple[AnyWorker, Any]]:
    """The workers that have said something within a time, each with its message: None if it died."""
    by_pipe: dict[object, AnyWorker] = {worker.pipe: worker for worker in workers}
    for pipe in wait(list(by_pipe), seconds):  # type: ignore[arg-type]
        worker = by_pipe[pipe]
        try:
            message = worker.pipe.recv()
        except (EOFError, OSError):
            message = None
        yield worker, message


class Orders:
    """A worker's end of the pipe: what the parent asks for, and what it is told."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe, self._stopped, self._checked = pipe, False, 0.0

    def stop(self) -> bool:
        """Whether the running trial shall end. Called often: looks at the pipe ten times a second."""
        now = time.monotonic()
        if not self._stopped and now - self._checked >= STOP_CHECK_SECONDS:
            self._checked = now
            if self._pipe.poll():
                self._stopped = True
                try:
                    self._pipe.recv()
                except (EOFError, OSError):  # the parent was killed: nobody waits for this result
                    os._exit(1)
        return self._stopped

    def begin(self) -> None:
        """Begin another task: a stop order was for the one before."""
        self._stopped = False

    def next(self) -> Any:
        """The next order; None if there are no more, or the parent is gone."""
        try:
            return self._pipe.recv()
        except (EOFError, OSError):
            return None

    def say(self, message: object) -> None:
        """Tell the parent; raises OSError if it is gone."""
        self._pipe.send(message)


def _serve(serve: Callable[..., object], pipe: Connection, call_number: Any, *arguments: object) -> None:
    """The whole life of a worker process."""
    # the parent gets them too and tells its workers what to do
    ignore_interrupts()
    threading.Thread(target=_leave_with_parent, daemon=True, name="parent").start()
    make_robust()  # what reads the parent's output may leave, and costs no trial
    # what a user's objective prints must not mix with the parent's tables
    sys.stdout = sys.stderr
    with suppress(BrokenPipeError, ConnectionResetError):  # the parent is gone
        if serve(Orders(pipe), Calls(call_number), *arguments) is True:
            _leave_at_once()


def _leave_at_once() -> None:
    """End this process without taking apart all that it has imported, which takes nearly half a second."""
    if (run_exit_functions := getattr(atexit, "_run_exitfuncs", None)) is not None:  # else it ends as any other does
        run_exit_functions()
        sys.stderr.flush()
        os._exit(0)


def _leave_with_parent() -> None:
    """End this process when the parent is killed, whatever it is doing: another run may take up the folder at once."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def reason_of(error: BaseException) -> str:
    """The error in one short line."""
    kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
    try:
        lines = str(error).splitlines()
    except Exception:  # an exception of the user's may fail at that
        lines = []
    return f"{kind}{lines[0] if lines else ''}"[:200].rstrip(": ")


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """Environment variables for the processes started inside."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _no_daemon() -> Iterator[None]:
    """Let a daemonic process, one of a ``multiprocessing.Pool`` say, start processes.

    It may not, because it would leave them behind where it is killed; ours end with their parent.
    """
    configuration: dict[str, object] = multiprocessing.current_process()._config  # type: ignore[attr-defined]
    before = configuration.get("daemon")
    configuration["daemon"] = False
    try:
        yield
    finally:
        configuration["daemon"] = before


@contextmanager
def _hidden_main() -> Iterator[None]:
    """Keep spawned processes from importing the parent's main script.

    They do not need it, and a script that calls us without ``if __name__ == "__main__"`` would run again.
    """
    main = sys.modules["__main__"]
    saved: dict[str, object] = {
        name: main.__dict__.pop(name) for name in ("__file__", "__spec__") if name in main.__dict__
    }
    main.__dict__.setdefault("__spec__", None)
    try:
        yield
    finally:
        main.__dict__.update(saved)
