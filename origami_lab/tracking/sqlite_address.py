"""SQLite databases that processes cannot share, told by their addresses."""

from __future__ import annotations

import stat
from pathlib import Path
from urllib.parse import unquote

IN_MEMORY = "is a database in the memory of one process, and several are to share it; must name a file on a disk"
DEVICES = tuple(map(Path, ("/dev", "/proc", "/sys")))
SHARED_MEMORY = Path("/dev/shm")
"""Where files are files, though they do not outlive the machine's next start."""


def why_not_shared(address: str) -> str | None:
    """The end of a message on why processes cannot share a database; None if they can, or it is not SQLite's.

    Parameters
    ----------
    address
        SQLAlchemy's: ``sqlite:///FILE``, also with a driver's name, with quotes inside or with SQLite's ``file:``.
    """
    scheme, _, rest = address.strip("'\" ").partition("://")
    if scheme.lower().partition("+")[0] != "sqlite":
        return None
    place, _, options = unquote(rest).partition("?")
    path = place.partition("/")[2].strip("'\" ")
    lower = f"{path} {options}".lower().replace(" ", "")
    in_memory = path in ("", "file:") or ":memory:" in lower or "mode=memory" in lower or "vfs=memdb" in lower
    return IN_MEMORY if in_memory else why_no_file(Path(path.removeprefix("file:")))


def why_no_file(path: Path) -> str | None:
    """The end of a message on why data cannot be kept in a file of this name; None if it can."""
    try:
        inside = path.absolute().resolve()
        if any(inside.is_relative_to(folder) for folder in DEVICES) and not inside.is_relative_to(SHARED_MEMORY):
            return "is no place for files, but the system's own; must name a file on a disk"
        mode = path.stat().st_mode
    except (OSError, ValueError, RuntimeError):  # not there yet, or out of reach for now
        return None
    return None if stat.S_ISREG(mode) or stat.S_ISDIR(mode) else "is no file, but a pipe or a device"
