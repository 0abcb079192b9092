"""Ctrl-C in a multirun whose jobs are other processes of the same terminal.

joblib and submitit answer a KeyboardInterrupt by killing the jobs, and a job that a signal meets while it imports dies
of it. So the signals are blocked in the command's process, and in those that it starts until they can save what they
have (:class:`Interrupts`); one thread of the command's takes them. It leaves a mark in the multirun's folder: jobs
that have not begun do not begin, those that run and did not hear the signal themselves stop, too.
"""

from __future__ import annotations

import _thread
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

from origami_lab.files import open_marker, regular_bytes
from origami_lab.workers.interrupts import NUMBERS, SAME_SECONDS, Interrupts

MARK = ".stopping"
LOOK_SECONDS = 0.25
STOPPING = "stopping: the jobs that run save their best so far, no others begin (Ctrl-C again to end all at once)"


class LauncherInterrupts:
    """In the command's process: the first signal stops the jobs, the second one raises KeyboardInterrupt.

    A first one before the jobs have been checked raises at once. Where threads cannot wait for signals (Windows), or
    outside the main thread, nothing is done and the launcher's own ways hold.

    Parameters
    ----------
    folder
        The multirun's.
    has_started
        Whether its jobs have been checked.
    say
        Takes a line for the user.
    """

    def __init__(self, folder: Path, has_started: Callable[[], bool], say: Callable[[str], None]) -> None:
        self.folder, self.has_started, self.say = folder, has_started, say
        self.count = 0
        self._raises = self._ended = False
        self._last = -SAME_SECONDS
        self._before: dict[int, Any] = {}
        self._mask: set[int] = set()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> LauncherInterrupts:
        if threading.current_thread() is threading.main_thread() and hasattr(signal, "sigwait"):
            heard = [number for number in NUMBERS if signal.getsignal(number) is not signal.SIG_IGN]
            if heard:
                # started by the first process otherwise, which would unblock the signals on the way
                resource_tracker.ensure_running()
                # the system may hand a signal to a library's thread that does not block it, and Python to these
                self._before = {number: signal.signal(number, self._handle) for number in heard}
                self._mask = set(signal.pthread_sigmask(signal.SIG_BLOCK, heard))
                self._thread = threading.Thread(target=self._listen, args=(heard,), daemon=True, name="interrupts")
                self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._thread is not None:
            self._ended = True
            if self._thread.is_alive() and self._thread.ident is not None:
                signal.pthread_kill(self._thread.ident, next(iter(self._before)))
            self._thread.join()
            for number, handler in self._before.items():
                signal.signal(number, handler)
            signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
        if self.count < 2:  # else jobs may still be on their way out
            clear_mark(self.folder)

    def _listen(self, heard: list[int]) -> None:
        while True:
            signal.sigwait(heard)
            if self._ended:
                return
            self._take()
            if self._raises:
                _thread.interrupt_main(next(iter(self._before)))

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if not self._raises:
            self._take()
        if self._raises:
            raise KeyboardInterrupt

    def _take(self) -> None:
        """Count a signal, and pass it on."""
        now = time.monotonic()
        same, self._last = now - self._last < SAME_SECONDS, now
        if same:
            return
        self.count += 1
        self._raises = self.count > 1 or not self.has_started()
        if self.has_started():
            try:
                with os.fdopen(open_marker(self.folder / MARK), "r+b") as mark:
                    mark.write(str(self.count).encode())
            except OSError:  # no job would see it
                self._raises = True
        if not self._raises:
            with suppress(OSError):  # the terminal is gone
                self.say(STOPPING)


def clear_mark(folder: Path) -> None:
    """Remove what an interrupted command has left."""
    with suppress(OSError):
        (folder / MARK).unlink()


def marked(folder: Path) -> int:
    """How many signals the command of a multirun has taken."""
    try:
        return int(regular_bytes(folder / MARK, 10))
    except (OSError, ValueError):
        return 0


@contextmanager
def following(folder: Path) -> Iterator[Interrupts]:
    """Interrupts for the run of a job's process; signals that only the command has heard are added to its own."""
    interrupts, ended = Interrupts(), threading.Event()

    def follow() -> None:
        while not ended.wait(LOOK_SECONDS):
            if marked(folder) > interrupts.count:
                _thread.interrupt_main(signal.SIGTERM)

    thread = threading.Thread(target=follow, daemon=True, name="multirun")
    thread.start()
    try:
        yield interrupts
    finally:
        ended.set()
        thread.join()
