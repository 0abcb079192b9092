"""Searches that save themselves: killed, stopped, with damaged checkpoints, on a full disk."""

from __future__ import annotations

import errno
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from origami_lab.config.compose import compose_settings
from origami_lab.experiment.trial import run_trial
from origami_lab.file_names import ACTIONS, CURVE, checkpoint_file
from origami_lab.runs import checkpoint
from origami_lab.runs.checkpoint import Checkpoint
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import TrialRow
from tests.small_runs import TIMINGS, trial_row

WORDS = (
    "target=pyramid",
    "search=ppo",
    "search.layers=[8]",
    "search.batch=60",
    "search.games=3",
    "search.minibatch=20",
)
MORE = ("budget=600", "files=designs", "tracking=none", "seed=4")


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Saves before each batch."""
    pytest.importorskip("sb3_contrib", reason="needs the extra ppo")
    monkeypatch.setattr(checkpoint, "SAVE_SECONDS", 0.0)


def run(output: Path, **options: Any) -> TrialRow:
    settings = compose_settings([*WORDS, *MORE, f"output={output}", "resume=true"])
    with RunFolder.opened(settings) as folder:
        folder.begin(settings.config, None, None)
        return run_trial(settings, 4, folder, **options)[0]


def found(output: Path, row: TrialRow) -> tuple[Any, ...]:
    """All that a trial has found, without its times."""
    values = {key: value for key, value in row.values().items() if key not in TIMINGS}
    return values, *((output / "seed=4" / name).read_bytes() for name in (ACTIONS, CURVE, "best.fold"))


@pytest.fixture
def whole(tmp_path: Path) -> tuple[Any, ...]:
    """What comes of the run without any save."""
    pytest.importorskip("sb3_contrib", reason="needs the extra ppo")
    return found(tmp_path / "whole", run(tmp_path / "whole"))


def killed_after(checkpoints: int, output: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run in a process that is killed once it has written so many, in the midst of the batch that follows."""
    child = os.fork()
    if child == 0:
        left, write = checkpoints, Checkpoint.write

        def counted(self: Checkpoint, content: bytes) -> None:
            nonlocal left
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)
            left -= 1
            write(self, content)

        monkeypatch.setattr(Checkpoint, "write", counted)
        try:
            run(output)
        finally:
            os._exit(0)
    assert os.WIFSIGNALED(os.waitpid(child, 0)[1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills a forked process")
@pytest.mark.usefixtures("often")
def test_a_killed_search_goes_on_to_the_same(
    tmp_path: Path, whole: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed twice; the run that ends it plays what is left only."""
    output, played = tmp_path / "killed", list[int]()
    killed_after(3, output, monkeypatch)
    killed_after(4, output, monkeypatch)
    assert checkpoint_file(output, 4).is_file()
    assert not (output / "seed=4").exists()
    row = run(output, report=lambda progress: played.append(progress.interactions))
    assert found(output, row) == whole
    assert min(played) > 60 * 5
    assert not checkpoint_file(output, 4).exists()


@pytest.mark.usefixtures("often")
def test_a_stopped_search_goes_on_to_the_same(tmp_path: Path, whole: tuple[Any, ...]) -> None:
    output, looks = tmp_path / "stopped", list[int]()

    def stop() -> bool:
        looks.append(1)
        return checkpoint_file(output, 4).is_file() and len(looks) > 3

    first = run(output, should_stop=stop)
    assert first.status == "stopped"
    assert checkpoint_file(output, 4).is_file()
    row = run(output)
    assert found(output, row) == whole
    assert row["seconds"] >= 0
    assert not checkpoint_file(output, 4).exists()


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("damage", ["cut off", "changed", "another version", "no save"])
def test_a_save_that_is_no_use_counts_as_none(tmp_path: Path, whole: tuple[Any, ...], damage: str) -> None:
    output = tmp_path / damage
    run(output, should_stop=lambda: checkpoint_file(output, 4).is_file())
    content = checkpoint_file(output, 4).read_bytes()
    damaged = {
        "cut off": content[:-100],
        "changed": content[:-100] + bytes(100),
        "another version": content.replace(b'"version": "', b'"version": "9.', 1),
        "no save": b"",
    }
    checkpoint_file(output, 4).write_bytes(damaged[damage])
    assert found(output, run(output)) == whole


@pytest.mark.usefixtures("often")
def test_a_full_disk_costs_a_save_and_no_search(
    tmp_path: Path, whole: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    def full(*arguments: object, **options: object) -> None:
        tried.append(arguments)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(checkpoint, "write_whole", full)
    assert found(tmp_path / "full", run(tmp_path / "full")) == whole
    assert len(tried) == 10


def test_saves_of_finished_trials_are_cleared_with_what_killed_runs_left(tmp_path: Path) -> None:
    """A run may be killed between the end of a trial and that."""
    folder = RunFolder(tmp_path)
    for seed in (1, 2, 3):
        checkpoint_file(tmp_path, seed).write_bytes(b"save")
    for seed, status in ((1, "ok"), (2, "stopped"), (4, "ok")):
        with folder.new_trial(seed) as path:
            trial_row(seed, status=status).write(path / "result.json")
    checkpoint_file(tmp_path, 4).write_bytes(b"a later stage's")
    os.utime(checkpoint_file(tmp_path, 4), ns=(2**62, 2**62))
    (tmp_path / ".seed=3.checkpoint.123.tmp").write_bytes(b"half")
    (tmp_path / "seed=mine.checkpoint").write_bytes(b"the user's")
    folder.clear_leftovers()
    left = {file.name for file in tmp_path.iterdir() if file.is_file()}
    assert left == {"seed=2.checkpoint", "seed=3.checkpoint", "seed=4.checkpoint", "seed=mine.checkpoint"}


def test_the_time_of_a_search_counts_from_its_beginning(tmp_path: Path) -> None:
    first = Checkpoint(tmp_path, 1)
    first.begin(0, lambda: 12.5)
    first.write(b"policy")
    second = Checkpoint(tmp_path, 1)
    second.begin(0, lambda: 1.0)
    assert second.read() == b"policy"
    assert second.seconds_before == 12.5
    assert not second.due
    second.begin(1, lambda: 1.0)  # of a later stage it is no save
    assert second.read() is None
    assert second.seconds_before is None
