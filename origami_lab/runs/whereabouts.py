"""Where a folder is that somebody may rename, or remove, while a run writes to it."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


class Whereabouts:
    """A folder by what it is and not by its name, as a context."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._descriptor: int | None = None

    def __enter__(self) -> Whereabouts:
        with suppress(OSError):  # where folders cannot be opened (Windows), they cannot be moved either
            self._descriptor = os.open(self.folder, os.O_RDONLY)
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)

    @property
    def has_moved(self) -> bool:
        """Whether it is not where it was, though another one may be there now."""
        return self._descriptor is not None and not self._is_at(self.folder)

    def now(self) -> Path | None:
        """Where it is now; None if it was removed, or the system does not tell."""
        if self._descriptor is None or not self.has_moved:
            return self.folder
        with suppress(OSError, ValueError):
            found = Path(_name_of(self._descriptor))
            return found if self._is_at(found) else None
        return None

    def _is_at(self, path: Path) -> bool:
        assert self._descriptor is not None
        try:
            return os.path.samestat(os.fstat(self._descriptor), path.stat())
        except OSError:
            return False


def _name_of(descriptor: int) -> str:
    """The name of an open folder, as the system knows it; raises OSError where it does not say."""
    try:
        return str(Path(f"/proc/self/fd/{descriptor}").readlink())
    except OSError:
        import fcntl

        command = getattr(fcntl, "F_GETPATH", None)  # macOS
        if command is None:
            raise
        return os.fsdecode(fcntl.fcntl(descriptor, command, b"\0" * 1024).rstrip(b"\0"))
