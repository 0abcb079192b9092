"""What a store's URI must be like, who may push, and errors in plain words. Without mlflow."""

from __future__ import annotations

import socket
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pytest

from origami_lab.errors import InputError
from origami_lab.runs.locks import held
from origami_lab.text import command_text
from origami_lab.tracking import store as stores
from origami_lab.tracking.store import StoreError, absolute_uri, cause_of, check_store, probe, shown, sqlite_file
from origami_lab.tracking.tracker import MlflowTracker, commands_to_look


@pytest.mark.parametrize(
    "uri",
    [
        *("foo://bar", "http://", "http://host:99999", "http://host:0", "http://[::1"),
        *("sqlite://my.db", "sqlite:///", "mlruns", "file:///mlruns", "", 5),
    ],
)
def test_a_uri_that_can_never_work_is_refused(uri: object) -> None:
    with pytest.raises(InputError, match=r"^tracking.uri="):
        check_store(uri)


@pytest.mark.parametrize(
    "uri", ["http://host:5000", "https://me:secret@host/sub", "sqlite:///new/my.db", "postgresql+psycopg2://h/db"]
)
def test_a_uri_that_may_work_is_not(uri: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    check_store(uri)


@pytest.mark.parametrize("content", [b"", b"dear diary"])
def test_a_file_that_is_no_database_is_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "my.db").write_bytes(content)
    with pytest.raises(InputError, match=r"--uri=.*must be a new file or an MLflow database"):
        check_store(f"sqlite:///{tmp_path}/my.db", "--uri")
    with pytest.raises(InputError, match="folder"):
        check_store(f"sqlite:///{tmp_path}")


def test_a_store_is_named_from_anywhere_and_without_its_password(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert absolute_uri("sqlite:///a/my.db?timeout=3") == f"sqlite:///{tmp_path}/a/my.db?timeout=3"
    assert absolute_uri("http://host") == "http://host"
    assert sqlite_file(f"sqlite:///{tmp_path}/a/my.db") == tmp_path / "a/my.db"
    assert sqlite_file("http://host") is None
    assert shown(f"sqlite:///{tmp_path}/a/my.db") == "the store a/my.db"
    assert shown("https://me:secret@host:1/x") == "the server https://host:1/x"


@pytest.mark.parametrize(
    "address",
    [
        *("postgresql://me:secret@host/x", "postgresql://me:a/secret@host/x", "postgresql://me:a@secret@host/x"),
        *("postgresql://host/x?user=me&password=secret", "http://me:secret@host:5000"),
    ],
)
def test_records_of_a_command_have_no_passwords(address: str) -> None:
    text = command_text(["origami-lab", "sweep", "file.yaml", f"storage={address}", "workers=2"])
    assert "secret" not in text
    assert "host" in text
    assert text.endswith(" workers=2")


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("HTTPConnectionPool(...): Max retries exceeded (Caused by ... [Errno 111] Connection refused)", "refused"),
        ("(sqlite3.OperationalError) database is locked\n[SQL: BEGIN]", "locked"),
        ("Detected out-of-date database schema (found version 1, but expected 2)", "mlflow db upgrade sqlite:///x.db"),
        ("API request to endpoint /api failed with error code 200 != 200. Response body: '<html>'", "as MLflow does"),
        ("HTTP Error 503: Service Unavailable", "internal error"),
    ],
)
def test_common_causes_are_said_in_plain_words(text: str, meaning: str) -> None:
    assert meaning in str(cause_of(text, "sqlite:///x.db"))


def test_other_errors_are_not_explained_away() -> None:
    assert cause_of("KeyError: 'seed'", "sqlite:///x.db") is None


def test_the_probe_tells_a_dead_store_from_a_living_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stores, "LOCK_SECONDS", 0.1)
    monkeypatch.setattr(stores, "ANSWER_SECONDS", 0.2)
    monkeypatch.setenv("no_proxy", "*")
    database = tmp_path / "my.db"
    probe(f"sqlite:///{database}")  # not made yet
    with closing(sqlite3.connect(database, isolation_level=None)) as connection:
        connection.execute("CREATE TABLE t (x)")
        probe(f"sqlite:///{database}")
        connection.execute("BEGIN EXCLUSIVE")
        with pytest.raises(StoreError, match="locked by another process"):
            probe(f"sqlite:///{database}")
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        uri = f"http://127.0.0.1:{listening.getsockname()[1]}"
        with pytest.raises(StoreError, match="connection refused"):
            probe(uri)
        listening.listen()
        with pytest.raises(StoreError, match="does not answer in time"):
            probe(uri)


@pytest.mark.skipif(sys.platform == "win32", reason="no locks there")
def test_one_process_at_a_time_pushes_a_folder(tmp_path: Path) -> None:
    with held(tmp_path, wait=False) as first, held(tmp_path, wait=False) as second:
        assert (first, second) == (True, False)
    with held(tmp_path, wait=False) as again:
        assert again


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a shell script")
def test_the_end_waits_no_longer_than_it_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hangs = tmp_path / "hangs"
    hangs.write_text("#!/bin/sh\nexec sleep 600\n")
    hangs.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(hangs))
    said: list[str] = []
    tracker = MlflowTracker(tmp_path, "http://host", said.append)
    tracker.trial(0)
    tracker.finish(patience=0.5)
    assert tracker._process is not None
    assert tracker._process.returncode is not None
    (line,) = said
    assert line.startswith("warning: tracking: the server http://host did not take everything")
    assert "0 of 1 trials" in line
    assert line.endswith(f"origami-lab dashboard --sync {tmp_path}")


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a shell script")
def test_a_tracking_process_that_crashes_costs_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crashes = tmp_path / "crashes"
    crashes.write_text("#!/bin/sh\nexit 3\n")
    crashes.chmod(0o755)
    for name, reason in (("crashes", "ended by itself"), ("nothing", "could not be started")):
        monkeypatch.setattr(sys, "executable", str(tmp_path / name))
        said: list[str] = []
        tracker = MlflowTracker(tmp_path, "http://host", said.append)
        tracker.trial(0)
        tracker.finish()
        (line,) = said
        assert line.startswith("warning: tracking: the process for MLflow ")
        assert reason in line


@pytest.mark.parametrize(
    ("tracking", "typed"),
    [
        ({"kind": "none"}, ["origami-lab dashboard --sync 'a run'", "origami-lab dashboard"]),
        ({"kind": "mlflow", "uri": None}, ["origami-lab dashboard"]),
        ({"kind": "mlflow", "uri": "sqlite:///other.db"}, ["origami-lab dashboard --uri sqlite:///other.db"]),
        ({"kind": "mlflow", "uri": "https://lab.example"}, ["https://lab.example"]),
        ({}, ["origami-lab dashboard"]),
    ],
)
def test_a_page_names_the_store_that_its_runs_are_in(tracking: dict[str, str], typed: list[str]) -> None:
    assert commands_to_look(tracking, Path("a run")) == typed
