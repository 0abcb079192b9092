"""A run folder that is renamed, removed or replaced while its trials run: what was kept is said truly."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.experiment import runner
from origami_lab.experiment.trial_worker import Finished
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.whereabouts import Whereabouts

WORDS = ("target=pyramid", "search=rdm", "budget=60", "files=designs", "tracking=none", "workers=1", "seed=0..1")


def test_a_folder_is_known_by_what_it_is(tmp_path: Path) -> None:
    for name in ("moved", "gone", "replaced", "there"):
        (tmp_path / name).mkdir()
    places = {name: Whereabouts(tmp_path / name) for name in ("moved", "gone", "replaced", "there")}
    for place in places.values():
        place.__enter__()
    (tmp_path / "moved").rename(tmp_path / "elsewhere")
    (tmp_path / "gone").rmdir()
    (tmp_path / "replaced").rename(tmp_path / "old")
    (tmp_path / "replaced").mkdir()
    assert {name: place.has_moved for name, place in places.items()} == {
        "moved": True,
        "gone": True,
        "replaced": True,
        "there": False,
    }
    assert places["there"].now() == tmp_path / "there"
    assert places["gone"].now() is None
    if Path("/proc/self/fd").is_dir():
        assert places["moved"].now() == tmp_path / "elsewhere"
        assert places["replaced"].now() == tmp_path / "old"
    for place in places.values():
        place.__exit__()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system must tell where a folder is")
@pytest.mark.parametrize("what", ["moved", "removed", "replaced"])
def test_what_was_kept_is_said_truly(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    take = runner._Record.take

    def move_after_the_first(self: runner._Record, event: object) -> None:
        take(self, event)  # type: ignore[arg-type]
        if isinstance(event, Finished) and len(self.rows) == 1:
            if what == "removed":
                shutil.rmtree("out")
            else:
                Path("out").rename("elsewhere")
            if what == "replaced":
                Path("out").mkdir()
                Path("out/notes.txt").write_text("mine")

    monkeypatch.setattr(runner._Record, "take", move_after_the_first)
    assert main([*WORDS, "output=out"]) == 1
    said = capfd.readouterr().err
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    if what == "removed":
        assert "error: out could not be written: the folder is gone; 0 of 2 trials kept" in said
        assert not Path("out").exists()
        return
    kept = sum(row.spent_budget for row in RunFolder(Path("elsewhere")).rows().values())
    assert kept >= 1
    assert f"it was moved to {tmp_path}/elsewhere while the trials ran; {kept} of 2 trials kept there" in said
    assert f"resume=true output={tmp_path}/elsewhere" in said
    if what == "replaced":
        assert not (Path("out") / "trials.csv").exists()
        assert Path("out/notes.txt").read_text() == "mine"
    assert main([*WORDS, "output=elsewhere", "resume=true"]) == 0
    assert len(RunFolder(Path("elsewhere")).rows()) == 2
