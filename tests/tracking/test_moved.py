"""A project that was moved or copied together with its store goes on where it is, and leaves the original alone."""

from __future__ import annotations

import hashlib
import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from origami_lab.runs.run_folder import read_note
from origami_lab.tracking.moved_store import address_note, noted_store, take_along
from tests.small_runs import inside, run

QUICK = ("target=pyramid", "search=rdm", "budget=200", "files=designs", "workers=1", "verbosity=quiet")
ADDRESSES = {"default": "results/mlflow.db", "absolute": "stores/mine.db"}


def everything(folder: Path) -> dict[str, str]:
    """All files below a folder, with digests of what they hold."""
    return {
        file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in folder.rglob("*")
        if file.is_file()
    }


def locations(database: Path) -> set[str]:
    """Where the files of all experiments and runs of a store are said to be."""
    with closing(sqlite3.connect(database)) as connection:
        rows = connection.execute("SELECT artifact_location FROM experiments").fetchall()
        rows += connection.execute("SELECT artifact_uri FROM runs").fetchall()
    return {row[0] for row in rows}


def seeds(database: Path) -> list[str]:
    """The seeds that a store has runs of, each as often as it has."""
    query = "SELECT value FROM tags JOIN runs USING (run_uuid) WHERE key = 'seed' AND lifecycle_stage = 'active'"
    with closing(sqlite3.connect(database)) as connection:
        return sorted(row[0] for row in connection.execute(query))


@pytest.fixture(scope="module", params=list(ADDRESSES))
def original(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A project with one tracked trial, and its store."""
    project, store = tmp_path_factory.mktemp("original"), ADDRESSES[request.param]
    (project / "stores").mkdir()
    named = [f"tracking.uri=sqlite:///{project / store}"] if request.param == "absolute" else []
    assert run(project, *QUICK, "seed=0", "output=results/one", *named) == 0
    return project, store


@pytest.mark.slow
def test_a_copy_goes_on_in_its_own_store(original: tuple[Path, str], tmp_path: Path) -> None:
    project, store = original
    before = everything(project)
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    assert run(copy, "results/one/config.yaml", "seed=7", "output=results/again", "verbosity=quiet") == 0
    assert run(copy, *QUICK, "seed=0..1", "output=results/one", "resume=true") == 0
    assert run(copy, "dashboard", "--sync", "results") == 0
    assert everything(project) == before
    assert seeds(copy / store) == ["0", "1", "7"]
    assert all(place.startswith(copy.as_uri()) for place in locations(copy / store))
    assert all(str(project) not in json.dumps(read_note(folder)) for folder in (copy / "results").iterdir())


@pytest.mark.slow
def test_a_moved_project_goes_on_where_it_is(original: tuple[Path, str], tmp_path: Path) -> None:
    project, store = original
    aside, moved = tmp_path / "aside", tmp_path / "moved"
    shutil.copytree(project, aside)
    project.rename(moved)
    try:
        assert run(moved, "dashboard", "--sync", "results") == 0
        assert run(moved, *QUICK, "seed=1", "output=results/one", "resume=true") == 0
        assert not project.exists()
        assert seeds(moved / store) == ["0", "1"]
        assert all(place.startswith(moved.as_uri()) for place in locations(moved / store))
    finally:
        aside.rename(project)


def test_a_note_names_the_way_to_the_store(tmp_path: Path) -> None:
    folder, store = tmp_path / "a/results/bowl/one", tmp_path / "a/results/mlflow.db"
    folder.mkdir(parents=True)
    store.touch()
    note = address_note(folder, f"sqlite:///{store}?timeout=5")
    (folder / "tracking.json").write_text(json.dumps(note), encoding="utf-8")
    assert note["way"] == "../../mlflow.db"
    assert noted_store(folder) == f"sqlite:///{store}?timeout=5"
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    assert noted_store(tmp_path / "b/results/bowl/one") == f"sqlite:///{tmp_path}/b/results/mlflow.db?timeout=5"
    shutil.copytree(folder, tmp_path / "elsewhere/one")  # without its store
    assert noted_store(tmp_path / "elsewhere/one") is None
    shutil.copytree(folder, tmp_path / "a/results/two")  # in the same project
    assert noted_store(tmp_path / "a/results/two") == f"sqlite:///{store}?timeout=5"


def test_what_lies_elsewhere_is_noted_as_it_is(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    for uri in ("http://host:5000", "postgresql://host/db", "sqlite:////somewhere/else/mlflow.db"):
        assert address_note(folder, uri) == {"uri": uri}
        (folder / "tracking.json").write_text(json.dumps({"uri": uri}), encoding="utf-8")
        assert noted_store(folder, uri) == uri


def test_a_note_of_before_ways_were_noted(tmp_path: Path) -> None:
    folder = tmp_path / "b/results/bowl/one"
    folder.mkdir(parents=True)
    old = f"sqlite:///{tmp_path}/a/results/mlflow.db"
    (folder / "tracking.json").write_text(json.dumps({"key": "k", "uri": old}), encoding="utf-8")
    assert noted_store(folder) is None  # the store of the working directory, not that of the original
    (tmp_path / "b/results/mlflow.db").touch()
    assert noted_store(folder) == f"sqlite:///{tmp_path}/b/results/mlflow.db"


def test_a_store_that_is_no_mlflow_database_yet_is_left_alone(tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "x.db")) as connection:
        connection.execute("CREATE TABLE experiments (name TEXT)")
        connection.commit()
    before = (tmp_path / "x.db").read_bytes()
    take_along(tmp_path / "x.db", 1.0)
    assert (tmp_path / "x.db").read_bytes() == before


def test_a_link_to_the_same_place_is_no_move(tmp_path: Path) -> None:
    real = tmp_path / "real"
    real.mkdir()
    (tmp_path / "link").symlink_to(real)
    location = (real / "mlartifacts/bowl").as_uri()
    with closing(sqlite3.connect(real / "x.db")) as connection:
        connection.execute("CREATE TABLE experiments (experiment_id INTEGER, name TEXT, artifact_location TEXT)")
        connection.execute("CREATE TABLE runs (experiment_id INTEGER, artifact_uri TEXT)")
        connection.execute("INSERT INTO experiments VALUES (1, 'bowl', ?)", (location,))
        connection.execute("INSERT INTO runs VALUES (1, ?)", (f"{location}/r/artifacts",))
        connection.commit()
    with inside(tmp_path):
        take_along(Path("link/x.db"), 1.0)
        assert locations(real / "x.db") == {location, f"{location}/r/artifacts"}
        shutil.copytree(real, tmp_path / "copy")
        take_along(Path("copy/x.db"), 1.0)
    made = (tmp_path / "copy/mlartifacts/bowl").as_uri()
    assert locations(tmp_path / "copy/x.db") == {made, f"{made}/r/artifacts"}
