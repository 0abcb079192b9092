"""The run folder stays whole."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
import trimesh

from origami_lab.config.node import flatten
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.files import write_whole
from origami_lab.runs.run_folder import RunFolder, ply_bytes
from origami_lab.runs.trial_row import TrialRow
from tests.small_runs import bare_settings, trial_row

NOW = datetime(2026, 1, 2, 3, 4, 5)


def opened(settings: Settings) -> RunFolder:
    """Take up a folder and leave it again."""
    with RunFolder.opened(settings, NOW) as folder:
        return folder


@pytest.fixture
def settings() -> Settings:
    return bare_settings(config={"budget": 10, "seed": 0, "search": {"children": 3}})


def test_default_place_is_unique_in_the_same_second(
    settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    paths = [opened(settings).path for _ in range(3)]
    assert paths[0] == Path("results/pyramid/rdm/2026-01-02_03-04-05")
    assert len(set(paths)) == 3


def test_a_folder_with_something_in_it_is_refused(settings: Settings, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("precious")
    with pytest.raises(InputError, match=r"output=.*new or empty.*resume=true"):
        opened(replace(settings, output=tmp_path))
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("place", ["/proc/nothing/here", "file/below"])
def test_a_place_that_cannot_be_written_is_refused(settings: Settings, tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"output=.*can be written"):
        opened(replace(settings, output=tmp_path / place))


def test_resume_wants_the_same_settings(settings: Settings, tmp_path: Path) -> None:
    first = replace(settings, output=tmp_path / "run")
    folder = opened(first)
    folder.begin(first.config, None, None)
    again = replace(first, resume=True)
    assert opened(replace(again, config={**first.config, "seed": "0..9"})).path == folder.path
    other = {**first.config, "search": {"children": 4}}
    with pytest.raises(InputError, match=r"search\.children was 3, is 4"):
        opened(replace(again, config=other))
    with pytest.raises(InputError, match=r"more was not set, is 1"):
        opened(replace(again, config={**first.config, "more": 1}))


def test_resume_without_a_folder_names_the_last_one(
    settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"output=DIR$"):
        opened(replace(settings, resume=True))
    folder = opened(settings)
    folder.begin(settings.config, None, None)
    with pytest.raises(InputError, match=rf"output={folder.path}"):
        opened(replace(settings, resume=True))


def test_a_trial_appears_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)

    def half_a_trial() -> None:
        with folder.new_trial(3) as path:
            (path / "best.fold").write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        half_a_trial()
    assert list(tmp_path.iterdir()) == []
    with folder.new_trial(3) as path:
        (path / "result.json").write_text(json.dumps(trial_row(3, status="stopped").values()))
        assert not folder.trial(3).exists()
    assert folder.rows() == {3: trial_row(3, status="stopped")}
    folder.write_error(3, "it failed before")
    with folder.new_trial(3) as path:
        (path / "result.json").write_text(json.dumps(trial_row(3).values()))
    assert folder.rows() == {3: trial_row(3)}
    assert [file.name for file in tmp_path.iterdir()] == ["seed=3"]


def test_leftovers_of_a_killed_run_are_cleared_and_broken_results_ignored(settings: Settings, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    folder.begin(settings.config, None, None)
    (tmp_path / ".seed=4.123.tmp").mkdir()
    for seed, text in ((5, "{"), (6, "[]"), (7, "{}"), (8, '{"seed": 8, "status": "ok"}')):
        folder.trial(seed).mkdir()
        (folder.trial(seed) / "result.json").write_text(text)
    assert opened(replace(settings, output=tmp_path, resume=True)).rows() == {}
    assert not (tmp_path / ".seed=4.123.tmp").exists()


def test_a_write_that_fails_keeps_the_old_file(tmp_path: Path) -> None:
    file = tmp_path / "trials.csv"
    write_whole(file, "old", sync=True)
    with pytest.raises(UnicodeEncodeError):
        write_whole(file, "new \ud800", sync=True)
    assert file.read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["trials.csv"]


def test_what_is_known_of_the_trials(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    for seed, status in ((0, "ok"), (1, "stopped"), (2, "ok")):
        folder.trial(seed).mkdir()
        (folder.trial(seed) / "result.json").write_text(json.dumps(trial_row(seed, status=status).values()))
    # a finished trial is on disk whatever the table says; one that was stopped may have failed since
    folder.write_trials([TrialRow.failed(seed, "lost") for seed in (1, 2, 3)])
    assert {seed: row.status for seed, row in folder.known_rows().items()} == {
        0: "ok",
        1: "failed: lost",
        2: "ok",
        3: "failed: lost",
    }


def test_ply_is_read_by_others(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 2, 3))
    (tmp_path / "target.ply").write_bytes(ply_bytes(box.vertices, box.faces))
    read = trimesh.load(tmp_path / "target.ply", process=False)
    np.testing.assert_array_equal(read.vertices, box.vertices)
    np.testing.assert_array_equal(read.faces, box.faces)


def test_flatten() -> None:
    assert flatten({"a": {"b": {"c": 1}, "d": {}}, "e": [1, {"f": 2}]}) == {
        "a.b.c": 1,
        "a.d": {},
        "e": [1, {"f": 2}],
    }
