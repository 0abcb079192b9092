"""Tracking of a sweep: a process of its own pushes the study's record, as with single experiments.

``python -m origami_lab.sweep.tracking DIR URI`` is that process.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.runs.locks import held
from origami_lab.runs.run_folder import read_note, write_note
from origami_lab.sweep.study_record import RECORD
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.tracking.push_process import Pusher, main
from origami_lab.tracking.store import absolute_uri, check_store, default_uri, explain
from origami_lab.tracking.tracker import MlflowTracker, NullTracker, Say, Tracker


def store_of_study(declaration: Declaration) -> str:
    """The URI of the store: as declared, else where the study was tracked before, else the default one."""
    return str(declaration.tracking.uri or read_note(declaration.folder).get("uri") or default_uri())


def check_sweep_tracking(declaration: Declaration) -> None:
    """Raise InputError if the store can never work."""
    if declaration.tracking.kind != "none":
        check_store(store_of_study(declaration))


def make_sweep_tracker(declaration: Declaration, say: Say, later: Sequence[str]) -> Tracker:
    """The tracker that is declared; the study's record must be on disk.

    Parameters
    ----------
    later
        The command that pushes what was missed.
    """
    if declaration.tracking.kind == "none":
        return NullTracker()
    uri = absolute_uri(store_of_study(declaration))
    write_note(declaration.folder, {"uri": uri, "experiment": declaration.tracking.experiment})
    return MlflowTracker(declaration.folder, uri, say, pusher=__name__, later=later)


def find_studies(directory: Path) -> list[Path]:
    """The folders of sweeps at or below a directory."""
    return sorted(file.parent for file in directory.rglob(RECORD) if (file.parent / "trials").is_dir())


def sync_studies(folders: Sequence[Path], uri: str | None, say: Say, complain: Say) -> tuple[int, set[str]]:
    """Push what the stores do not have yet of studies; one line a study.

    Parameters
    ----------
    uri
        The store to push to; None for the one that each study notes, or the default one.
    say, complain
        Take lines about studies that went well, and about those that did not.

    Returns
    -------
    How many could not be pushed, and the URIs of the stores that have the others.
    """
    from origami_lab.sweep.study_runs import StudyRuns

    failed, stores = 0, set[str]()
    for folder in folders:
        note = read_note(folder)
        store = absolute_uri(str(uri or note.get("uri") or default_uri()))
        try:
            with held(folder, wait=False) as free:
                if not free:
                    say(f"{folder}: left alone, another process runs or pushes it")
                    continue
                added = StudyRuns(folder, store, note.get("experiment")).push(live=False)
        except Exception as error:
            failed += 1
            complain(f"{folder}: {explain(error, store)}")
            continue
        stores.add(store)
        say(f"{folder}: {added} trial{'' if added == 1 else 's'} pushed" if added else f"{folder}: already there")
    return failed, stores


class StudyPusher(Pusher):
    """Pushes a study's folder whenever it is told to."""

    def add_missing(self, live: bool) -> None:
        from origami_lab.sweep.study_runs import StudyRuns

        if not (self.folder / RECORD).is_file():
            return
        self.runs = self.runs or StudyRuns(self.folder, self.uri, read_note(self.folder).get("experiment"))
        self.runs.push(live, lambda trial: self.answer("pushed", trial))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], StudyPusher)
