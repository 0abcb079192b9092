"""Standard streams that cannot fail a command: closed ones, ones whose reader leaves, ones that know few letters."""

from __future__ import annotations

import codecs
import errno
import io
import os
import stat
import sys
from typing import Any, TextIO

SHOWN = "origami_lab.shown"
"""The error handler of the streams: a letter that they cannot show is a question mark."""


class _Stream(io.FileIO):
    """The bytes of a standard stream; all that follows a failure goes nowhere.

    A program like ``head`` that has read enough, or a terminal that was closed, is no trouble.
    """

    trouble: OSError | None = None
    """The error of a stream that could not take all, because of a full disk say."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            left = error.errno == errno.EIO and stat.S_ISCHR(os.fstat(self.fileno()).st_mode)
            if not (left or isinstance(error, BrokenPipeError | BlockingIOError)):
                self.trouble = error
            _lead_nowhere(self.fileno(), os.O_WRONLY)
            return memoryview(data).nbytes


def open_descriptors() -> None:
    """Open the standard streams that a process was started without; they lead nowhere.

    The next files that it opens would take their places else, and be written to by whatever prints: also by processes
    that it starts.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            _lead_nowhere(number, os.O_WRONLY if number else os.O_RDONLY)


def make_robust() -> None:
    """Replace the standard streams of a process of our own by such that cannot fail."""
    if os.name != "posix":  # a Windows console is no file
        return
    open_descriptors()
    codecs.register_error(SHOWN, _shown)
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.FileIO(0, "r", closefd=False), "utf-8")
    sys.stdout, sys.stderr = _robust(sys.stdout, 1), _robust(sys.stderr, 2)


def _robust(stream: TextIO | None, number: int) -> TextIO:
    """A stream like one that a process began with, which is None where that was closed."""
    encoding, by_lines = "utf-8", False
    if stream is not None:
        stream.flush()
        encoding, by_lines = stream.encoding, bool(getattr(stream, "line_buffering", False))
    binary = io.BufferedWriter(_Stream(number, "w", closefd=False))
    return io.TextIOWrapper(binary, encoding, SHOWN, line_buffering=by_lines)


def trouble_of_output() -> OSError | None:
    """The error that kept standard output from taking all that was written; None if there was none."""
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    if not isinstance(raw, _Stream):
        return None
    sys.stdout.flush()
    return raw.trouble


def _shown(error: UnicodeError) -> tuple[bytes, int]:
    """Question marks in place of letters; parts of a file's name that are no letters stay the bytes that they are."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    shown = b""
    for letter in error.object[error.start : error.end]:
        shown += letter.encode("ascii", "surrogateescape" if "\udc80" <= letter <= "\udcff" else "replace")
    return shown, error.end


def _lead_nowhere(number: int, mode: int) -> None:
    """Have a descriptor read or write nothing."""
    null = os.open(os.devnull, mode)
    if null != number:
        os.dup2(null, number)
        os.close(null)
    os.set_inheritable(number, True)
