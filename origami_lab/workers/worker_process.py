"""A process with a pipe, a time limit and one thread: shared by experiments and sweeps."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.context import SpawnProcess

from origami_lab.errors import InputError
from origami_lab.workers.interrupts import blocked_interrupts

JOIN_SECONDS = 2.0


_THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA")


ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _THREADS}
"""A trial is one thread: the cores are for other trials."""


def start_apart(process: SpawnProcess) -> None:
    """Start a process that uses one core, hears no Ctrl-C and imports nothing of the parent's script."""
    with _environment(ONE_THREAD), _hidden_main(), blocked_interrupts():
        process.start()


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


STOP_CHECK_SECONDS = 0.1


def leave_with_parent() -> None:
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
