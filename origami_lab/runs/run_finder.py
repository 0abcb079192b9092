"""Finding run folders."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from origami_lab.errors import InputError

_NOT_OURS = re.compile(r"\.|[0-9a-f]{32}$")
"""Hidden folders, and MLflow's own for its runs, which hold copies of a run folder's files."""


def find_runs(directory: Path, field: str) -> Iterator[Path]:
    """The run folders at or below a directory, in order.

    Parameters
    ----------
    field
        What the user names the directory by, for the message.

    Raises
    ------
    InputError
        If there is none.
    """
    found = False
    for place, folders, files in os.walk(directory):
        if _is_run(folders, files):
            found = True
            folders.clear()
            yield Path(place)
        else:
            folders[:] = sorted(name for name in folders if not _NOT_OURS.match(name))
    if not found:
        what = "there is no run folder at or below it (config.yaml and trials.csv)"
        if directory.is_file():
            what = "must be a folder, this is a file"
        raise InputError(field, directory, what + _hint(directory))


def _is_run(folders: Iterable[str], files: Iterable[str]) -> bool:
    return "config.yaml" in files and ("trials.csv" in files or any(name.startswith("seed=") for name in folders))


def _hint(place: Path) -> str:
    """Names the run folder that a place is in, if it is in one."""
    for parent in place.parents:
        _, folders, files = next(os.walk(parent), ("", [], []))
        if _is_run(folders, files):
            return f"; did you mean the run folder that it is in, {parent}?"
    return ""
