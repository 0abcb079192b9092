"""Small studies, played in this process to the bits."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from origami_lab.runs.run_folder import FolderError
from origami_lab.runs.trial_row import read_trials
from origami_lab.sweep.studies import best_slot, returns_of
from tests.sweep.conftest import ROOT, declare, play_here, values

TPE: dict[str, Any] = {"sampler": {"name": "tpe", "seed": 3, "startup": 3}, "pruner": {"name": "median", "startup": 2}}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Any]]:
    """A study that nobody disturbed, with the sampler and the pruner that look at what was found before."""
    folder = tmp_path_factory.mktemp("whole")
    return folder, play_here(declare(folder, trials=6, **TPE))


def test_a_trial_is_a_run_folder_and_its_value_the_mean(whole: tuple[Path, list[Any]]) -> None:
    folder, slots = whole
    assert {slot.state for slot in slots} == {"complete", "pruned"}
    for slot in slots:
        assert slot.reason[:7] == ("below -" if slot.state == "pruned" else "")
        run = folder / "out" / "trials" / f"{slot.number:04d}"
        rows = read_trials(run / "trials.csv")
        assert [row.seed for row in rows] == [0, 1][: 2 if slot.state == "complete" else 1]
        assert returns_of(slot) == [row.return_ for row in rows]
        assert slot.trial.value == pytest.approx(sum(returns_of(slot)) / len(rows), abs=1e-15)
        assert json.loads((run / "summary.json").read_text())["search"] == "evo"
        for seed in range(len(rows)):
            assert (run / f"seed={seed}" / "best.fold").is_file()
            assert not (run / f"seed={seed}" / "folded.png").exists()
    best = best_slot(slots)
    assert best is not None
    assert best.trial.value == max(slot.trial.value for slot in slots if slot.state == "complete")


@pytest.mark.slow
def test_the_same_seed_gives_the_same_study_also_if_it_was_stopped_twice(
    tmp_path: Path, whole: tuple[Path, list[Any]]
) -> None:
    declaration = declare(tmp_path, trials=6, **TPE)
    assert not all(slot.done for slot in play_here(declaration, stop_after=3))
    assert not all(slot.done for slot in play_here(declaration, stop_after=4))
    resumed = play_here(declaration)
    assert values(resumed) == values(whole[1])
    assert sum(slot.losses for slot in resumed) >= 1


def test_seeds_on_disk_are_not_played_again(tmp_path: Path) -> None:
    declaration = declare(tmp_path, trials=1, seeds="0..2")
    play_here(declaration, stop_after=2)
    result = tmp_path / "out" / "trials" / "0000" / "seed=1" / "result.json"
    result.write_text(json.dumps({**json.loads(result.read_text()), "return": -123.0}))
    (slot,) = play_here(declaration)
    assert slot.state == "complete"
    assert returns_of(slot)[1] == -123.0


def test_an_objective_that_raises_fails_its_trial_only(tmp_path: Path) -> None:
    notes = tmp_path / "notes"
    notes.mkdir()
    task = [
        "objective=broken",
        "board=9x9",
        "symmetry=xy",
        "start.size=1",
        "objective.ways=[raises]",
        f"objective.notes={notes}",
    ]
    first, second = play_here(declare(tmp_path, trials=2, task=task, config_dir=str(ROOT / "tests/experiment/conf")))
    assert (first.state, second.state) == ("failed", "complete")
    assert first.reason == "failed: seed 0: RuntimeError: the kettle is empty"
    assert "Traceback" in (tmp_path / "out" / "trials" / "0000" / "seed=0.error.txt").read_text()


def test_a_folder_that_cannot_be_made_is_no_fault_of_its_trial(tmp_path: Path) -> None:
    declaration = declare(tmp_path, trials=2)
    (tmp_path / "out" / "trials").mkdir(parents=True)
    obstacle = tmp_path / "out" / "trials" / "0001"
    obstacle.write_text("in the way")
    with pytest.raises(FolderError):
        play_here(declaration)
    obstacle.unlink()
    assert [slot.state for slot in play_here(declaration)] == ["complete", "complete"]
