"""Who may write to a run folder, and who may push it to a store: locks that the system drops when a process ends."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from origami_lab.errors import InputError
from origami_lab.files import open_marker

RUNNING = ".running"
"""The file that a run has locked in its folder, and removes when it ends."""


class FolderInUseError(InputError):
    """Another process has the run folder."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep a run folder for this process. The system drops the lock when the process ends, in whatever way.

    Raises
    ------
    FolderInUseError
        If another process has it.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        yield
        return
    path = folder / RUNNING
    while True:
        try:
            descriptor = open_marker(path)
        except OSError as error:
            expected = f"must be a folder that can be locked: {RUNNING} cannot be made ({error.strerror})"
            raise InputError("output", folder, expected) from error
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise FolderInUseError(
                    "output", folder, "must be a folder that no running experiment writes to"
                ) from error
            except OSError:  # a file system without locks
                pass
            if not _is_at(descriptor, path):  # its last owner removed it in the meantime
                continue
            try:
                yield
            finally:
                with suppress(OSError):
                    path.unlink()
            return
        finally:
            os.close(descriptor)


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.lstat())
    except FileNotFoundError:
        return False


@contextmanager
def held(folder: Path, wait: bool) -> Iterator[bool]:
    """Keep other processes from pushing a run folder; whether it could be had (always, where locks are unknown)."""
    try:
        import fcntl
    except ImportError:  # Windows
        yield True
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        except OSError:  # a file system without locks
            yield True
        else:
            yield True
    finally:
        os.close(descriptor)
