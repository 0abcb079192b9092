"""Files written whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

LARGEST_JSON = 64 * 2**20
"""Bytes of a JSON file: the record of a study of thousands of trials is a few megabytes."""


@contextmanager
def replacing(path: str | os.PathLike[str], *, sync: bool = False, keep: bool = False) -> Iterator[Path]:
    """A hidden file beside ``path`` that takes its place when the block ends, and vanishes if the block raises.

    Parameters
    ----------
    sync
        The content is on the disk before: some file systems only say then that there is no room for it.
    keep
        A file that another process has put there meanwhile stays: it may be in use.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        if sync:
            on_disk(temporary)
        if not (keep and _put_unless_there(temporary, path)):
            temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _put_unless_there(file: Path, path: Path) -> bool:
    """Give a file another name, unless that is taken, all at once; False if the file system cannot do it."""
    try:
        os.link(file, path)
    except FileExistsError:
        pass
    except OSError:  # no hard links
        return path.exists()
    return True


def write_whole(path: str | os.PathLike[str], content: str | bytes, *, sync: bool = False) -> None:
    """Write a file so that a reader finds the old content or the new one, never a part.

    Text is written as UTF-8. Raises ``OSError`` where it cannot be written; nothing is left of it then.
    """
    with replacing(path, sync=sync) as temporary:
        temporary.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))


def on_disk(file: Path) -> None:
    """Have the system write a file to its disk."""
    with file.open("rb+") as stream:
        os.fsync(stream.fileno())


def expanded(path: str | os.PathLike[str]) -> Path:
    """A path with ``~`` replaced by the user's home, if it is known."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        return Path(path)


def nearest_existing(path: Path) -> Path:
    """A folder, or the innermost one around it that is there."""
    return next(place for place in (path, *path.absolute().parents) if place.exists())


def is_writable(folder: Path) -> bool:
    """Whether files can be made in a folder, or the folder itself where it is not there yet."""
    try:
        place = nearest_existing(folder)
        return place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    except OSError:  # a folder on the way that cannot be looked into
        return False


def regular_bytes(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of a file that somebody else may have made.

    Raises
    ------
    OSError
        If it is no regular file (a pipe, a device or a folder, which might never end), holds more than ``most`` bytes,
        or cannot be read.
    """
    # without waiting for the other end of a pipe
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    with os.fdopen(descriptor, "rb") as stream:
        state = os.fstat(descriptor)
        if not stat.S_ISREG(state.st_mode):
            raise OSError(errno.EINVAL, f"is {kind_of_file(state.st_mode)}, must be a file", str(path))
        content = stream.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"is larger than {most / 2**20:.0f} MB", str(path))
    return content


def read_json(path: str | os.PathLike[str], most: int = LARGEST_JSON) -> Any:
    """The content of a JSON file that somebody else may have made; raises OSError or ValueError if there is none."""
    try:
        return json.loads(regular_bytes(path, most))
    except RecursionError:
        raise ValueError("is nested too deeply") from None


def kind_of_file(mode: int) -> str:
    """What a path is, by its mode, in a word: a folder, a pipe ..."""
    kinds = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFREG: "a file"}
    return kinds.get(stat.S_IFMT(mode), "a device")
