"""The file of a search that is not finished: ``seed=N.checkpoint`` in the run folder, whole whenever that is killed."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from origami_lab.about import __version__
from origami_lab.file_names import CHECKPOINT, RESULT, SEED, checkpoint_file, trial_folder
from origami_lab.files import regular_bytes, remove_files, write_whole

SAVE_SECONDS = 30.0
"""Time between two checkpoints: what a killed search loses, at most, but for what it plays until it can save."""
LARGEST_SAVE = 2**32
"""Bytes of a file that is read: the policy of the largest observation that is allowed, with Adam's moments."""


class Checkpoint:
    """Where a trial's search is saved, if its searcher saves anything.

    A save that cannot be written leaves the one before; one that is damaged, or of another version, counts as none.

    Parameters
    ----------
    folder
        The run's.
    seed
        The trial's.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self.path = checkpoint_file(folder, seed)
        self.seconds_before: float | None = None
        """Seconds that the search had taken when it was saved, if it goes on from there."""
        self._stage = 0
        self._elapsed: Callable[[], float] = lambda: 0.0
        self._last = time.monotonic()

    def begin(self, stage: int, elapsed: Callable[[], float]) -> None:
        """A stage begins: what was saved in another one counts as nothing.

        Parameters
        ----------
        elapsed
            Gives the seconds that the trial's search has taken, those before it was saved included.
        """
        self._stage, self._elapsed, self.seconds_before = stage, elapsed, None

    @property
    def due(self) -> bool:
        """Whether it is time to save again."""
        return time.monotonic() - self._last >= SAVE_SECONDS

    def write(self, content: bytes) -> None:
        """Keep this instead of what was kept before."""
        head = {"version": __version__, "stage": self._stage, "seconds": self._elapsed()}
        head["sha256"] = hashlib.sha256(content).hexdigest()
        with suppress(OSError):  # a full disk shall not end a search of hours
            write_whole(self.path, json.dumps(head).encode() + b"\n" + content, sync=True)
        self._last = time.monotonic()

    def read(self) -> bytes | None:
        """What was kept last; None if nothing was, or nothing that can be gone on with."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            line, _, content = regular_bytes(self.path, LARGEST_SAVE).partition(b"\n")
            head = json.loads(line)
            mine = (head["version"], head["stage"]) == (__version__, self._stage)
            if mine and head["sha256"] == hashlib.sha256(content).hexdigest():
                self.seconds_before = float(head["seconds"])
                return content
        return None

    def remove(self) -> None:
        """The search has ended."""
        with suppress(OSError):
            remove_files(self.path.parent, [self.path.name])


def remove_checkpoints(folder: Path, is_finished: Callable[[int], bool]) -> None:
    """Remove the checkpoints of finished trials from a run folder: it may have been killed before it did so.

    One that is younger than the trial's result is of a later stage, which is not finished.
    """
    for file in folder.glob(f"{SEED}*{CHECKPOINT}"):
        seed = file.name.removeprefix(SEED).removesuffix(CHECKPOINT)
        if seed.isdigit() and is_finished(int(seed)):
            result = trial_folder(folder, int(seed)) / RESULT
            if file.stat().st_mtime_ns <= result.stat().st_mtime_ns:
                remove_files(folder, [file.name])
