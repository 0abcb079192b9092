"""Interrupts: Ctrl-C and the signals of batch systems and closed terminals, counted so that a run can ask for them."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any

from origami_lab.errors import EXIT_INTERRUPTED

NUMBERS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
SAME_SECONDS = 0.3
"""Signals this close to each other are one: `timeout` and batch systems send theirs twice."""


class Interrupts:
    """Counts Ctrl-C, SIGTERM and SIGHUP while it is entered; from the ``limit``-th on they raise KeyboardInterrupt.

    A signal that the process was started to ignore (`nohup`) stays ignored. Outside the main thread, where no handlers
    can be set, it counts nothing.
    """

    def __init__(self) -> None:
        self.count = 0
        self.limit: int | None = 1
        """None: only count."""
        self._last = -SAME_SECONDS
        self._before: dict[int, Any] = {}
        self._mask: set[int] | None = None

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            for number in NUMBERS:
                if signal.getsignal(number) is not signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._handle)
            if hasattr(signal, "pthread_sigmask"):
                self._mask = set(signal.pthread_sigmask(signal.SIG_BLOCK, ()))
                try:  # a launcher starts its jobs with all of them blocked, and one may have come
                    signal.pthread_sigmask(signal.SIG_UNBLOCK, self._before)
                except KeyboardInterrupt:
                    self.__exit__(None, None, None)
                    raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        same, self._last = now - self._last < SAME_SECONDS, now
        if same:
            return
        self.count += 1
        if self.limit is not None and self.count >= self.limit:
            raise KeyboardInterrupt


@contextmanager
def process_interrupts() -> Iterator[None]:
    """Around all that a process does: SIGTERM and SIGHUP are Ctrl-C; once all is done each of them ends it at once.

    The interpreter takes its time to end; a signal meanwhile would be reported as a death by it. Signals that are
    ignored or handled already stay so.
    """

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    def leave(number: int, frame: FrameType | None) -> None:
        os._exit(EXIT_INTERRUPTED)

    def deafen() -> None:
        for number in NUMBERS:
            signal.signal(number, signal.SIG_IGN)

    # the last thing before the interpreter takes its handlers away
    atexit.register(deafen)
    ours = [number for number in NUMBERS if signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, interrupt)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):  # its reader left
                stream.flush()
        for number in NUMBERS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, leave)


def ignore_interrupts() -> None:
    """In a worker: none of them does anything, but programs that it starts hear them."""
    for number in NUMBERS:
        signal.signal(number, lambda *_: None)  # SIG_IGN would be inherited
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, NUMBERS)


@contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Start processes that see none of them, not even while they import; ours are delivered afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    # started by the first process otherwise, which would unblock the signals on the way
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, NUMBERS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
