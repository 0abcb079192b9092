"""Files written whole or not at all, and no further than where they belong: links are not followed out of a folder."""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

LARGEST_TABLE = 256 * 2**20
"""Bytes of a table: a hundred thousand trials are a tenth of that."""
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
    with suppress(FileNotFoundError):
        if not stat.S_ISREG(mode := path.stat().st_mode):
            raise OSError(errno.EINVAL, f"there is {kind_of_file(mode)} of that name", str(path))
    with suppress(FileNotFoundError):
        temporary.unlink()
    # made here, so that it is a file of its own and no link to another one
    os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
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


def open_marker(path: Path) -> int:
    """A descriptor of a lock's or marker's file, which is made if it is not there: for all who may write to the folder.

    Raises
    ------
    OSError
        If it cannot be made, is a link or no regular file.
    """
    flags = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
    folder = path.parent.stat()
    mode = stat.S_IMODE(folder.st_mode) & 0o666
    try:
        descriptor = os.open(path, flags | os.O_CREAT | os.O_EXCL, mode)
    except FileExistsError:
        descriptor = os.open(path, flags)
        if not stat.S_ISREG(mode := os.fstat(descriptor).st_mode):
            os.close(descriptor)
            raise OSError(errno.EINVAL, f"is {kind_of_file(mode)}, must be a file", str(path)) from None
        return descriptor
    if hasattr(os, "fchmod"):  # what the process's own mask has taken from it
        with suppress(OSError):
            os.fchown(descriptor, -1, folder.st_gid)
            os.fchmod(descriptor, mode)
    return descriptor


def require_no_link(folder: Path, name: str | os.PathLike[str]) -> Path:
    """A path in a folder, none of whose parts below the folder is a link.

    Raises
    ------
    OSError
        If one is.
    """
    path = folder
    for part in Path(name).parts:
        path = path / part
        if part == ".." or Path(part).is_absolute() or path.is_symlink():
            raise OSError(errno.ELOOP, f"{path} is a link, which is not followed", str(path))
    return path


def is_regular(path: Path) -> bool:
    """Whether there is a file that is neither a link nor a pipe or device."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except (OSError, ValueError):
        return False


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove files of a folder, if they are regular ones that no link leads to; raises OSError."""
    for name in names:
        with suppress(FileNotFoundError, NotADirectoryError):
            try:
                file = require_no_link(folder, name)
            except OSError:
                continue
            if stat.S_ISREG(file.lstat().st_mode):
                file.unlink()


def remove_folder(folder: Path) -> None:
    """Remove a folder with the files in it; folders, links and all else in it stay, and so does it then."""
    with suppress(OSError):
        if folder.is_symlink():
            return
        remove_files(folder, [file.name for file in folder.iterdir()])
        folder.rmdir()


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
        if stat.S_ISDIR(state.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
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
