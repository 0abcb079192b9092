"""Files written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


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
