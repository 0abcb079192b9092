"""Tracking of a sweep: a process of its own pushes the study's record, as with single experiments.

``python -m origami_lab.sweep.tracking DIR URI`` is that process.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.runs.run_folder import write_note
from origami_lab.sweep.study_record import RECORD
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.tracking.moved_store import address_note, noted_store
from origami_lab.tracking.store import absolute_uri, check_store, default_uri
from origami_lab.tracking.tracker import MlflowTracker, NullTracker, Say, Tracker


def store_of_study(declaration: Declaration) -> str:
    """The URI of the store: as declared, else where the study was tracked before, else the default one."""
    return str(declaration.tracking.uri or noted_store(declaration.folder) or default_uri())


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
    write_note(
        declaration.folder, {**address_note(declaration.folder, uri), "experiment": declaration.tracking.experiment}
    )
    return MlflowTracker(declaration.folder, uri, say, pusher=__name__, later=later)


def find_studies(directory: Path) -> list[Path]:
    """The folders of sweeps at or below a directory."""
    return sorted(file.parent for file in directory.rglob(RECORD) if (file.parent / "trials").is_dir())


if __name__ == "__main__":
    from origami_lab.sweep.study_runs import StudyRuns
    from origami_lab.tracking.push_process import serve_pushes

    serve_pushes(StudyRuns, Path(sys.argv[1]), sys.argv[2])
