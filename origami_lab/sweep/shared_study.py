"""The study as the parent of the workers sees it: joined, looked at, recorded, and summed up when it has ended."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from origami_lab.errors import InputError
from origami_lab.sweep.storage import KEY, known_study, open_storage, storage_name
from origami_lab.sweep.studies import HeldOutJob, SearchJob, best_slot, check_comparison, check_space, point_of
from origami_lab.sweep.study_record import read_record, record_of, write_record
from origami_lab.sweep.summary import SweepSummary
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.trial_queue import STOPPED, Slot, TrialQueue
from origami_lab.sweep.worker_identity import Worker


@dataclass(frozen=True)
class Standing:
    """How far a sweep is, by one look."""

    slots: Sequence[Slot]
    """The trials of the search."""
    compared: Mapping[str, Slot]
    """The comparison, by the names of the settings; empty until all trials are done, and if none is complete."""

    @property
    def done(self) -> bool:
        """Whether nothing is left to play."""
        return all(slot.done for slot in (*self.slots, *self.compared.values()))

    @property
    def failed(self) -> bool:
        """Whether any trial has failed."""
        return any(slot.state == "failed" for slot in (*self.slots, *self.compared.values()))


class SharedStudy:
    """A study that workers, also those of other machines, play.

    Raises
    ------
    InputError
        If it was declared otherwise, something in the space cannot be played, or the folder is another study's;
        nothing is written then.
    """

    def __init__(self, declaration: Declaration) -> None:
        folder = declaration.folder
        known = known_study(declaration)
        if (folder / "trials").is_dir() and (known is None or known != _key_in(folder, known)):
            expected = f"holds trials of a study that {storage_name(declaration)} does not have; choose another one"
            raise InputError("output", folder, expected)
        if known is None:
            check_space(declaration)
        check_comparison(declaration)
        _check_writable(folder)
        self.declaration = declaration
        self._storage, self._worker = open_storage(declaration), Worker.this()
        self._queue = SearchJob(declaration).queue(self._storage, self._worker)
        self._queue.fill()
        self._comparison: HeldOutJob | None = None
        self._compared: TrialQueue | None = None
        self._recorded: set[int] | None = None
        """The trials in the record; None before it is written."""

    def look(self) -> Standing:
        """Ask the storage how far the study is."""
        slots = self._queue.look()
        best = best_slot(slots)
        if best is None or not all(slot.done for slot in slots):
            return Standing(slots, {})
        # another machine may have added trials, and one of them may be better
        if self._comparison is None or self._compared is None or self._comparison.best != point_of(best):
            self._comparison = HeldOutJob(self.declaration, point_of(best))
            self._compared = self._comparison.queue(self._storage, self._worker)
        return Standing(slots, dict(zip(self._comparison.names, self._compared.look(), strict=True)))

    def condemn(self, pid: int, reason: str) -> None:
        """Let the trial fail that a worker of this machine plays, before the worker is killed."""
        for queue in filter(None, (self._queue, self._compared)):
            queue.condemn(pid, reason)

    def release(self) -> None:
        """Let others at once have the trials of workers that had to be ended."""
        for queue in filter(None, (self._queue, self._compared)):
            queue.reap(STOPPED)

    def write_record(self, standing: Standing) -> list[int]:
        """Write the trials that have ended, unless the record has them all; returns the numbers of the new ones."""
        ended = {slot.number for slot in standing.slots if slot.done}
        if ended == self._recorded:
            return []
        write_record(self.declaration.folder, self._record(standing))
        new, self._recorded = ended - (self._recorded or set()), ended
        return sorted(new)

    def write_summary(self, standing: Standing, command: Sequence[str]) -> dict[str, Any]:
        """Write all that the sweep found; returns the contents of summary.json."""
        comparison = self._comparison if standing.compared else None
        record, study = self._record(standing), self._queue.study
        return SweepSummary(self.declaration, study, record, comparison, standing.compared, command).write()

    def _record(self, standing: Standing) -> dict[str, Any]:
        return record_of(self.declaration, str(self._queue.study.user_attrs[KEY]), standing.slots)


def _key_in(folder: Path, default: str) -> str:
    """The key of the study whose trials are in a folder; the default if it does not tell."""
    try:
        return str(read_record(folder)["key"])
    except (OSError, ValueError, KeyError):
        return default


def _check_writable(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        expected = f"must be a folder that can be written ({error.strerror or error})"
        raise InputError("output", folder, expected) from error
