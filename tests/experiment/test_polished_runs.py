"""Runs with polish=N: what comes of it stands beside the search's own, and is the same however it came about."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import origami_lab
from origami_lab.config.compose import compose_settings
from origami_lab.config.settings import Settings
from origami_lab.experiment.trial import is_done, run_trial
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.fold_format.reader import read_fold
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.trial_row import POLISHED_RETURNS, RETURNS, TrialRow, read_trials
from origami_lab.search.problem import Problem
from origami_lab.verification.verify_design import verify
from tests.small_runs import SMALL, run

STEPS = 320
QUICK = (*SMALL, "files=designs", "tracking=none")
OWN = ("best.fold", "actions.json", "curve.csv")
"""What the search of a trial leaves."""


@pytest.fixture(scope="module")
def there(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs: "plain" by one worker without a polish, and "polished" by two."""
    folder = tmp_path_factory.mktemp("polished")
    assert run(folder, *QUICK, "seed=0..1", "workers=1", "output=plain") == 0
    assert run(folder, *QUICK, "seed=0..1", "workers=2", f"polish={STEPS}", "output=polished") == 0
    return folder


def rows_of(folder: Path) -> dict[int, TrialRow]:
    """The rows of trials.csv, which those of the trials' folders must be."""
    rows = {row.seed: row for row in read_trials(folder / "trials.csv")}
    assert rows == RunFolder(folder).rows()
    return rows


def without_timings(row: TrialRow) -> dict[str, Any]:
    return {name: value for name, value in row.values().items() if not name.endswith(("seconds", "per_second"))}


def test_the_polished_design_stands_beside_the_search_s_own(there: Path) -> None:
    plain, polished = rows_of(there / "plain"), rows_of(there / "polished")
    for seed, row in polished.items():
        trial = there / "polished" / f"seed={seed}"
        for name in OWN:
            assert (trial / name).read_bytes() == (there / "plain" / f"seed={seed}" / name).read_bytes()
        own = {name: value for name, value in without_timings(row).items() if not name.startswith("polish")}
        assert own == {name: without_timings(plain[seed])[name] for name in own}
        figures = json.loads((trial / "polished.json").read_text())
        assert [row[name] for name in POLISHED_RETURNS] == [figures[name] for name in RETURNS]
        assert row["polished_return"] >= row["return"]
        assert (row.polish, row.polished_certificate) == ("ok", "certified")
        assert row.polish_steps is not None
        assert 0 < row.polish_steps <= STEPS
        fold = read_fold(trial / "polished.fold")
        assert verify(trial / "polished.fold").verdict == "certified"
        assert fold.metadata["driving_angle"] == row.polished_driving_angle == pytest.approx(figures["driving_angle"])
        assert not list(trial.glob("*.html"))
    summary = json.loads((there / "polished/summary.json").read_text())
    values = [row["polished_return"] for row in polished.values()]
    assert summary["returns"]["polished_return"]["mean"] == pytest.approx(np.mean(values), abs=1e-15)
    assert summary["best_polished"]["polished_return"] == max(values)
    assert origami_lab.load(there / "polished").trials["polished_return"].tolist() == values


def test_a_run_that_is_resumed_polishes_what_has_none(there: Path) -> None:
    """The same bits by one worker as by two; the search is not repeated, and a third time nothing is left to do."""
    before = {file: file.stat().st_mtime_ns for name in OWN for file in (there / "plain").glob(f"seed=*/{name}")}
    resumed = (*QUICK, "seed=0..1", "workers=1", f"polish={STEPS}", "resume=true", "output=plain")
    assert run(there, *resumed) == 0
    for seed in (0, 1):
        one, other = (there / name / f"seed={seed}/polished.fold" for name in ("plain", "polished"))
        assert one.read_bytes() == other.read_bytes()
    polished = rows_of(there / "polished")
    assert {s: without_timings(row) for s, row in rows_of(there / "plain").items()} == {
        seed: without_timings(row) for seed, row in polished.items()
    }
    assert {file: file.stat().st_mtime_ns for file in before} == before
    made = (there / "plain/seed=0/polished.fold").stat().st_mtime_ns
    assert run(there, *resumed) == 0
    without = [word for word in resumed if not word.startswith("polish")]
    assert run(there, *without) == 0  # nothing is lost
    assert (there / "plain/seed=0/polished.fold").stat().st_mtime_ns == made
    assert rows_of(there / "plain")[0].polish == "ok"


def begun(folder: Path, *words: str) -> tuple[Settings, RunFolder]:
    folder.mkdir(exist_ok=True)
    return compose_settings([*QUICK, *words]), RunFolder(folder)


def test_a_time_limit_is_recorded(tmp_path: Path) -> None:
    settings, folder = begun(tmp_path, f"polish={10**9}", "polish_seconds=0.001")
    row, warnings = run_trial(settings, 0, folder)
    assert (row.polish, row.polished_certificate, warnings) == ("time limit", "certified", [])
    assert row.polish_steps is not None
    assert row.polish_steps < 10**9
    assert is_done(row, settings)


def test_a_stopped_polish_keeps_its_best_and_is_gone_on_with(tmp_path: Path) -> None:
    settings, folder = begun(tmp_path, "polish=400", "polish_simplify=0.01")
    said: list[Progress | Polishing] = []
    stop = lambda: isinstance(said[-1], Polishing)  # noqa: E731
    row, _ = run_trial(settings, 3, folder, said.append, stop)
    assert (row.status, row.polish) == ("ok", "stopped")
    assert (tmp_path / "seed=3/polished.fold").is_file()
    assert not is_done(row, settings)
    said.clear()
    again, _ = run_trial(settings, 3, folder, said.append)
    assert {type(event) for event in said} == {Polishing}
    assert (again.polish, again.seconds) == ("ok", row.seconds)
    assert again["polished_return"] >= again["return"] - 0.01
    assert "simplified" in json.loads((tmp_path / "seed=3/polished.json").read_text())


class AtOnce:
    """Ends the game as soon as its start pattern is placed."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        positions = problem.new_positions(1)
        legal = problem.clear(positions, 0)
        while len(legal):
            legal = problem.play(positions, 0, int(legal[-1] if len(legal) > 1 else legal[0]))
            legal = legal[legal == 3 * problem.game.rules.points] if len(legal) else legal
        problem.finish(positions, 0)


def test_a_polish_that_fails_costs_no_more_than_itself(tmp_path: Path) -> None:
    """The start pattern alone has nothing to move."""
    own = f"search._target_={__name__}.AtOnce"
    settings, folder = begun(tmp_path, own, "polish=400", "certify=none")
    row, warnings = run_trial(settings, 0, folder)
    assert row.status == "ok"
    assert row.polish is not None
    assert row.polish.startswith("failed: design=the start pattern alone")
    assert len(warnings) == 1
    assert is_done(row, settings)
    assert folder.rows()[0] == row
    assert not list(tmp_path.glob("seed=0/polished*"))


def test_a_folder_that_cannot_be_written_keeps_what_the_search_found(tmp_path: Path) -> None:
    settings, folder = begun(tmp_path, "polish=400")

    def in_the_way(event: Progress | Polishing) -> None:
        if isinstance(event, Polishing):
            (tmp_path / "seed=0/polished.fold/x").mkdir(parents=True, exist_ok=True)

    with pytest.raises(FolderError):
        run_trial(settings, 0, folder, in_the_way)
    row = folder.rows()[0]
    assert (row.status, row.polish) == ("ok", None)
    assert not list(tmp_path.glob(".seed*"))


def test_settings_that_do_nothing_are_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = [word for word in QUICK if word != "verbosity=quiet"]
    assert run(tmp_path, *words, "polish=0", "polish_seconds=5", "seed=0", "output=out") == 0
    assert "warning: polish_seconds without polish=N: nothing is polished" in capfd.readouterr().err
    assert rows_of(tmp_path / "out")[0].polish is None
