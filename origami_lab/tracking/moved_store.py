"""Stores that were moved or copied together with their runs: what goes on there goes on in the store that is there now.

MLflow writes down where an experiment's files are as an absolute path, and a run folder notes its store so; both are
read again from where the store, or the folder, is now.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from origami_lab.runs.run_folder import read_note
from origami_lab.tracking.mlflow_limits import artifact_folder

ARTIFACTS = "mlartifacts"
"""The folder beside an SQLite store for files of the runs."""
SQLITE = "sqlite:///"


def take_along(database: Path, patience: float) -> None:
    """Have a store keep its experiments' files beside itself again, if it was moved or copied since they were made.

    Raises
    ------
    sqlite3.Error
        If the database cannot be read, or written where that is needed.
    """
    here = database.absolute().parent
    with closing(sqlite3.connect(database, timeout=patience)) as connection:
        tables = connection.execute("SELECT name FROM sqlite_master WHERE name IN ('experiments', 'runs')").fetchall()
        if len(tables) < 2:
            return
        known = connection.execute("SELECT experiment_id, name, artifact_location FROM experiments").fetchall()
        for number, name, location in known:
            for folder in {str(name), artifact_folder(str(name)), str(number)}:
                end = (Path("/") / ARTIFACTS / folder).as_uri().removeprefix("file://")
                if not str(location).startswith("file:///") or not str(location).endswith(end):
                    continue
                made = (here / ARTIFACTS / folder).as_uri()
                if location == made or _is_same(str(location).removesuffix(end), here):
                    continue
                connection.execute(
                    "UPDATE experiments SET artifact_location = ? WHERE experiment_id = ?", (made, number)
                )
                connection.execute(
                    "UPDATE runs SET artifact_uri = ? || substr(artifact_uri, ?)"
                    " WHERE experiment_id = ? AND substr(artifact_uri, 1, ?) = ?",
                    (made, len(location) + 1, number, len(location) + 1, f"{location}/"),
                )
        connection.commit()


def _is_same(place: str, folder: Path) -> bool:
    """Whether a file:// address is that of a folder, by another name."""
    with suppress(OSError, ValueError):
        return folder.samefile(unquote(urlsplit(place).path))
    return False


def address_note(folder: Path, uri: str) -> dict[str, str]:
    """What a run folder notes of its store: the address, and the way there where both are in one project."""
    file = Path(uri.removeprefix(SQLITE).partition("?")[0]) if uri.startswith(SQLITE) else None
    if file is None or not _in_one_project(folder.absolute(), file.absolute()):
        return {"uri": uri}
    return {"uri": uri, "way": os.path.relpath(file.absolute(), folder.absolute())}


def noted_store(folder: Path, configured: str | None = None) -> str | None:
    """The address of the store that a run folder notes, as it is now; None if it notes none that is to be used.

    Parameters
    ----------
    configured
        The address in the run's configuration: one that a folder of version 0.1.0 notes though it is elsewhere.
    """
    note: Mapping[str, Any] = read_note(folder)
    uri, way = note.get("uri"), note.get("way")
    if not isinstance(uri, str) or not uri.startswith(SQLITE):
        return uri if isinstance(uri, str) else None
    name, mark, options = uri.removeprefix(SQLITE).partition("?")
    noted, here = Path(name), folder.absolute()
    found = Path(os.path.normpath(here / way)) if isinstance(way, str) else None
    if found is None and uri != configured and not _in_one_project(here, noted):
        # before ways were noted: the store of the same name around it
        found = next(
            (
                place / noted.parent.name / noted.name
                for place in here.parents
                if (place / noted.parent.name / noted.name).is_file()
            ),
            None,
        )
        if found is None:
            return None
    if found is None or found == noted:
        return uri
    if found.is_file():
        return f"{SQLITE}{found}{mark}{options}"
    # moved or copied without its store: within the project that is still the right one
    return uri if _in_one_project(here, noted) and noted.is_file() else None


def _in_one_project(folder: Path, file: Path) -> bool:
    """Whether a run folder lies where a store is, in the folder around that, or in the working directory with it."""
    around = [place for place in (file.parent, file.parent.parent) if len(place.parts) > 2]
    here = Path.cwd()
    return any(folder.is_relative_to(place) for place in around) or (
        folder.is_relative_to(here) and file.is_relative_to(here)
    )
