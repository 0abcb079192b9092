"""The file of a search that is not finished: ``seed=N.saved`` in the run folder, whole whenever the run is killed."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from origami_lab.about import __version__
from origami_lab.file_names import SAVED, SEED, saved_file
from origami_lab.files import regular_bytes, remove_files, write_whole

SAVE_SECONDS = 30.0
"""Time between two saves: what a killed search loses, at most, but for what it plays until it can save."""
LARGEST_SAVE = 2**32
"""Bytes of a file that is read: the policy of the largest observation that is allowed, with Adam's moments."""


class SavedSearch:
    """Where a trial's search is saved, if its searcher saves anything.

    A save that cannot be written leaves the one before; one that is damaged, or of another version, counts as none.

    Parameters
    ----------
    folder
        The run's.
    seed
        The trial's.
    elapsed
        Seconds that the search has taken, those before it was saved included.
    """

    def __init__(self, folder: Path, seed: int, elapsed: Callable[[], float]) -> None:
        self.path = saved_file(folder, seed)
        self.seconds_before = 0.0
        """Seconds that the search had taken when it was saved, if it goes on from there."""
        self._elapsed = elapsed
        self._last = time.monotonic()

    @property
    def due(self) -> bool:
        """Whether it is time to save again."""
        return time.monotonic() - self._last >= SAVE_SECONDS

    def write(self, content: bytes) -> None:
        """Keep this instead of what was kept before."""
        head = {"version": __version__, "sha256": hashlib.sha256(content).hexdigest(), "seconds": self._elapsed()}
        with suppress(OSError):  # a full disk shall not end a search of hours
            write_whole(self.path, json.dumps(head).encode() + b"\n" + content, sync=True)
        self._last = time.monotonic()

    def read(self) -> bytes | None:
        """What was kept last; None if nothing was, or nothing that can be gone on with."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            line, _, content = regular_bytes(self.path, LARGEST_SAVE).partition(b"\n")
            head = json.loads(line)
            if head["version"] == __version__ and head["sha256"] == hashlib.sha256(content).hexdigest():
                self.seconds_before = float(head["seconds"])
                return content
        return None

    def remove(self) -> None:
        """The search has ended."""
        with suppress(OSError):
            remove_files(self.path.parent, [self.path.name])


def remove_saves(folder: Path, is_finished: Callable[[int], bool]) -> None:
    """Remove the saves of finished trials from a run folder: it may have been killed before it did so."""
    for file in folder.glob(f"{SEED}*{SAVED}"):
        seed = file.name.removeprefix(SEED).removesuffix(SAVED)
        if seed.isdigit() and is_finished(int(seed)):
            remove_files(folder, [file.name])
