"""No writer follows a link out of its folder, and only files of our own are removed: with real links, modes, pipes."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path

import pytest

from origami_lab.errors import InputError
from origami_lab.files import (
    open_marker,
    regular_bytes,
    remove_files,
    remove_folder,
    replacing,
    require_no_link,
    write_whole,
)
from origami_lab.multirun.job_interrupts import MARK, marked
from origami_lab.report.page import GENERATOR
from origami_lab.report.report_builder import _check_output, _write
from origami_lab.runs.locks import RUNNING, locked
from origami_lab.runs.multirun_folder import read_index
from origami_lab.runs.run_folder import RunFolder

FILES = {"index.html": f"<!DOCTYPE html>{GENERATOR}", "returns.md": "x", "figures/learning-a.png": b"1"}


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    """A folder of somebody else's, whose files must stay as they are."""
    folder = tmp_path / "precious"
    (folder / "inner").mkdir(parents=True)
    for name in ("best-thesis.html", "learning-a.png", "notes.txt", "viewer.js", "inner/deep.txt"):
        (folder / name).write_text("precious")
    return folder


def assert_untouched(folder: Path) -> None:
    files = sorted(file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file())
    assert files == ["best-thesis.html", "inner/deep.txt", "learning-a.png", "notes.txt", "viewer.js"]
    assert all((folder / name).read_text() == "precious" for name in files)


def test_a_file_in_the_place_of_a_link_is_a_file_of_its_own(precious: Path, tmp_path: Path) -> None:
    for name in ("at", "before"):
        (tmp_path / name).mkdir()
    (tmp_path / "at/a.txt").symlink_to(precious / "notes.txt")
    (tmp_path / f"before/.a.txt.{os.getpid()}.tmp").symlink_to(precious / "notes.txt")
    for name in ("at", "before"):
        write_whole(tmp_path / name / "a.txt", "new")
        assert not (tmp_path / name / "a.txt").is_symlink()
        assert (tmp_path / name / "a.txt").read_text() == "new"
        assert [file.name for file in (tmp_path / name).iterdir()] == ["a.txt"]
    assert_untouched(precious)


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_what_is_no_file_is_not_replaced(kind: str, tmp_path: Path) -> None:
    place = tmp_path / "a.txt"
    if kind == "pipe":
        os.mkfifo(place)
    elif kind == "folder":
        place.mkdir()
    else:
        place.symlink_to("/dev/null")
    before = place.lstat()
    with pytest.raises(OSError, match="of that name"), replacing(place):
        pass
    assert os.path.samestat(place.lstat(), before)
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_only_regular_files_below_a_folder_are_removed(precious: Path, tmp_path: Path) -> None:
    folder = tmp_path / "ours"
    (folder / "real").mkdir(parents=True)
    (folder / "real/a").touch()
    (folder / "link").symlink_to(precious)
    (folder / "one").symlink_to(precious / "notes.txt")
    os.mkfifo(folder / "pipe")
    names = ["real/a", "real", "link/notes.txt", "one", "pipe", "../precious/notes.txt", str(precious / "notes.txt")]
    remove_files(folder, [*names, "nosuch", "real/a/b", "nosuch/a"])
    assert sorted(file.name for file in folder.rglob("*") if file.parent == folder) == ["link", "one", "pipe", "real"]
    assert not list((folder / "real").iterdir())
    remove_folder(folder)
    remove_folder(folder / "link")
    assert sorted(file.name for file in folder.iterdir()) == ["link", "one", "pipe", "real"]
    assert_untouched(precious)
    for name in ("link", "link/notes.txt", "../precious", str(precious)):
        with pytest.raises(OSError, match="is a link, which is not followed"):
            require_no_link(folder, name)


def report(folder: Path, files: dict[str, str | bytes]) -> None:
    _check_output(folder)
    _write(folder, files)


def test_a_report_removes_what_it_has_drawn_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "report"
    report(folder, {**FILES, "designs/best-a.html": "1", "designs/viewer.js": "2"})
    for name in ("designs/best-mine.html", "figures/learning-mine.png", "notes.txt"):
        (folder / name).write_text("mine")
    (folder / "designs/best-a.html").unlink()
    (folder / "designs/best-a.html").symlink_to(folder / "notes.txt")
    report(folder, {**FILES, "figures/solved-a.png": b"3"})
    there = sorted(file.relative_to(folder).as_posix() for file in folder.rglob("*") if not file.is_dir())
    assert there == [
        *("designs/best-a.html", "designs/best-mine.html", "figures/learning-a.png", "figures/learning-mine.png"),
        *("figures/solved-a.png", "files.json", "index.html", "notes.txt", "returns.md"),
    ]
    listed = json.loads((folder / "files.json").read_text())["files"]
    assert listed == ["figures/learning-a.png", "figures/solved-a.png", "files.json", "index.html", "returns.md"]


def test_a_report_of_0_1_0_is_adopted_and_its_own_files_go(tmp_path: Path) -> None:
    folder = tmp_path / "report"
    for name in ("figures", "designs"):
        (folder / name).mkdir(parents=True)
    (folder / "index.html").write_text(FILES["index.html"])
    ours = ["figures/gallery.png", "figures/learning-old.svg", "designs/best-old.json", "designs/viewer.js"]
    others = [
        "figures/photo.png",
        "designs/thesis.html",
        "designs/best.html.bak",
        "figures/learning.txt",
        "solved-a.png",
    ]
    for name in [*ours, *others]:
        (folder / name).write_text("x")
    report(folder, FILES)
    assert not any((folder / name).exists() for name in ours)
    assert all((folder / name).exists() for name in others)


@pytest.mark.parametrize("linked", ["designs", "figures", "index.html"])
@pytest.mark.parametrize("listed", [True, False])
def test_a_report_follows_no_link(linked: str, listed: bool, precious: Path, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    folder.mkdir()
    (precious / "notes.txt").write_text("precious")
    if linked == "index.html":
        (tmp_path / "page.html").write_text(str(FILES["index.html"]))
        (folder / "index.html").symlink_to(tmp_path / "page.html")
    else:
        (folder / "index.html").write_text(str(FILES["index.html"]))
        (folder / linked).symlink_to(precious)
    if listed:
        names = [
            f"{linked}/best-thesis.html",
            "../precious/notes.txt",
            str(precious / "viewer.js"),
            "designs/viewer.js",
        ]
        (folder / "files.json").write_text(json.dumps({"files": names}))
    with pytest.raises(InputError, match="--output="):
        report(folder, {**FILES, "designs/best-thesis.html": "new"})
    assert_untouched(precious)


def test_a_list_that_a_stranger_wrote_removes_nothing_elsewhere(precious: Path, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    folder.mkdir()
    (folder / "index.html").write_text(str(FILES["index.html"]))
    (folder / "thesis.tex").write_text("x")
    for content in (
        json.dumps(
            {"files": ["../precious/notes.txt", str(precious / "notes.txt"), "designs/../../precious/notes.txt"]}
        ),
        json.dumps({"files": ["thesis.tex", 5, None]}),
        json.dumps({"files": 7}),
        "[" * 100_000,
        "no JSON",
    ):
        (folder / "files.json").write_text(content)
        report(folder, FILES)
    assert (folder / "thesis.tex").exists()
    assert_untouched(precious)


def test_a_lock_follows_no_link(precious: Path, tmp_path: Path) -> None:
    for number, target in enumerate((precious / "notes.txt", precious / "new.txt", precious)):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / RUNNING).symlink_to(target)
        with pytest.raises(InputError, match="cannot be made"), locked(folder):
            pass
    assert_untouched(precious)
    folder = tmp_path / "piped"
    folder.mkdir()
    os.mkfifo(folder / RUNNING)
    with pytest.raises(InputError, match="is a pipe"), locked(folder):
        pass


@pytest.mark.parametrize(("mode", "expected"), [(0o775, 0o664), (0o755, 0o644), (0o700, 0o600), (0o777, 0o666)])
@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_locks_and_marks_have_the_folders_permissions(mode: int, expected: int, mask: int, tmp_path: Path) -> None:
    tmp_path.chmod(mode)
    before = os.umask(mask)
    try:
        with locked(tmp_path):
            assert stat.S_IMODE((tmp_path / RUNNING).stat().st_mode) == expected
        os.close(open_marker(tmp_path / "mark"))
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "mark").stat().st_mode) == expected


def test_the_mark_of_a_multirun_is_read_from_a_file_only(precious: Path, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / MARK)
    assert marked(tmp_path) == 0  # without waiting
    (tmp_path / MARK).unlink()
    (tmp_path / MARK).symlink_to(precious / "notes.txt")
    with pytest.raises(OSError, match=r"symbolic links|Too many"):
        open_marker(tmp_path / MARK)
    assert_untouched(precious)


def test_leftovers_go_and_what_they_lead_to_stays(precious: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    (folder / ".seed=1.77.tmp").mkdir(parents=True)
    (folder / ".seed=1.77.tmp/best.fold").touch()
    (folder / ".seed=2.77.tmp").symlink_to(precious)
    (folder / ".config.yaml.77.tmp").symlink_to(precious / "notes.txt")
    (folder / ".seed=3.77.tmp").mkdir()
    (folder / ".seed=3.77.tmp/inner").symlink_to(precious)
    RunFolder(folder).clear_leftovers()
    assert [file.name for file in folder.iterdir()] == [".seed=3.77.tmp"]
    assert_untouched(precious)


def test_a_trial_that_runs_again_keeps_what_is_not_ours(precious: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    (folder / "seed=0").mkdir(parents=True)
    for name in ("best.fold", "polished.fold", "best.full.fold", "pattern.png", "notes.md"):
        (folder / "seed=0" / name).write_text("old")
    (folder / "seed=0/photos").mkdir()
    with RunFolder(folder).new_trial(0) as place:
        (place / "best.fold").write_text("new")
    there = {file.name: file for file in (folder / "seed=0").iterdir()}
    assert sorted(there) == ["best.fold", "notes.md", "photos"]
    assert there["best.fold"].read_text() == "new"
    assert [file.name for file in folder.iterdir()] == ["seed=0"]
    (folder / "seed=1").symlink_to(precious)
    with pytest.raises(Exception, match="is a link"), RunFolder(folder).new_trial(1):
        pass
    assert_untouched(precious)


@pytest.mark.parametrize("name", ["../elsewhere", "/tmp/elsewhere", "a/b", "..", ".", ".hidden", "a\n", ""])
def test_an_index_names_folders_in_its_own_only(name: str, tmp_path: Path) -> None:
    job = {"folder": name, "overrides": [], "varied": {}}
    (tmp_path / "multirun.json").write_text(json.dumps({"id": "x", "jobs": [job]}))
    assert read_index(tmp_path) is None
    (tmp_path / "multirun.json").write_text(json.dumps({"id": "x", "jobs": [{**job, "folder": "cube-seed=1"}]}))
    assert read_index(tmp_path) is not None


def test_a_file_is_read_within_bounds(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "big").write_bytes(b"x" * 11)
    for name, expected in ((tmp_path / "pipe", "pipe"), (Path("/dev/zero"), "device"), (tmp_path, "folder")):
        with pytest.raises(OSError, match=f"is a {expected}, must be a file|Is a directory"):
            regular_bytes(name, 10)
    with pytest.raises(OSError, match="larger than"):
        regular_bytes(tmp_path / "big", 10)
    assert regular_bytes(tmp_path / "big", 11) == b"x" * 11
