"""Tracking of a sweep: a process of its own pushes the study's record, as with single experiments.

``python -m origami_lab.sweep.tracking DIR URI`` is that process.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.experiment.note import read_note, write_note
from origami_lab.experiment.pusher import Pusher, main
from origami_lab.experiment.stores import absolute_uri, check_store, default_uri
from origami_lab.experiment.tracking import MlflowTracker, NullTracker, Say, Tracker
from origami_lab.sweep.declaration import Declaration
from origami_lab.sweep.records import RECORD


def store_of_study(declaration: Declaration) -> str:
    """The URI of the store: as declared, else where the study was tracked before, else the default one."""
    return str(declaration.tracking.get("uri") or read_note(declaration.folder).get("uri") or default_uri())


def check_sweep_tracking(declaration: Declaration) -> None:
    """Raise InputError if the store can never work."""
    if declaration.tracking["kind"] != "none":
        check_store(store_of_study(declaration))


def make_sweep_tracker(declaration: Declaration, say: Say, later: Sequence[str]) -> Tracker:
    """The tracker that is declared; the study's record must be on disk.

    Parameters
    ----------
    later
        The command that pushes what was missed.
    """
    if declaration.tracking["kind"] == "none":
        return NullTracker()
    uri = absolute_uri(store_of_study(declaration))
    write_note(declaration.folder, {"uri": uri, "experiment": declaration.tracking.get("experiment")})
    return MlflowTracker(declaration.folder, uri, say, pusher=__name__, later=later)


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
