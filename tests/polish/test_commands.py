"""`origami-lab polish` and `simplify` on the folders of runs and on single files."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.fold_format.reader import read_fold
from origami_lab.runs.trial_row import read_trials
from origami_lab.verification.verify_design import verify

DESIGNS = Path(__file__).parents[2] / "results" / "paper" / "designs"
FEW = ["--steps", "150", "--no-pictures"]


@pytest.fixture
def pyramid(tmp_path: Path) -> Path:
    return Path(shutil.copy(DESIGNS / "pyramid-rdm-seed0.fold", tmp_path))


def test_a_file_is_polished_beside_it(pyramid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = pyramid.read_bytes()
    assert main(["polish", str(pyramid), "--steps", "150"]) == 0
    said = capsys.readouterr().out
    made = pyramid.with_name("pyramid-rdm-seed0.polished.fold")
    assert said.startswith(f"{made}: return -0.0799 → -0.0")
    assert "certified, " in said
    assert pyramid.read_bytes() == before
    assert sorted(
        file.name.removeprefix("pyramid-rdm-seed0.polished") for file in pyramid.parent.glob("*polished*")
    ) == [
        ".certificate.json",
        ".fold",
        ".html",
        ".json",
        ".png",
        "_pattern.png",
    ]
    figures = json.loads(made.with_suffix(".json").read_text())
    assert figures["return"] > figures["before"]["return"]
    assert verify(made).verdict == figures["certificate"] == "certified"
    fold = read_fold(made)
    assert fold.metadata["return"] == figures["return"]
    assert fold.metadata["task"] == "pyramid"
    assert not fold.actions


def test_a_run_s_best_are_polished_in_their_trials(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    settings = ["target=cube", "search=rdm", "budget=3000", "seed=0..2", "files=designs", "tracking=none"]
    assert main([*settings, "verbosity=quiet", f"output={run}"]) == 0
    capsys.readouterr()
    rows = {n: json.loads((run / f"seed={n}" / "result.json").read_text())["return"] for n in range(3)}
    assert main(["polish", str(run), "--best", "2", *FEW]) == 0
    lines = capsys.readouterr().out.splitlines()
    ranked = sorted(rows, key=lambda n: (-rows[n], n))
    assert [line.split(":")[0] for line in lines] == [str(run / f"seed={n}" / "polished.fold") for n in ranked[:2]]
    assert not (run / f"seed={ranked[2]}" / "polished.fold").exists()
    trial = run / f"seed={ranked[0]}"
    figures = json.loads((trial / "polished.json").read_text())
    assert figures["before"]["return"] == pytest.approx(rows[ranked[0]])
    # the run's tables say so, too, and those of the trial that was not polished do not
    table = {row.seed: row for row in read_trials(run / "trials.csv")}
    assert table[ranked[0]].polished_return == figures["return"]
    assert table[ranked[0]].polish == "ok"
    assert table[ranked[2]].polish is None
    assert json.loads((run / "summary.json").read_text())["returns"]["polished_return"]["n"] == 2
    assert main(["simplify", str(trial), "--no-pictures"]) == 0
    figures = json.loads((trial / "simplified.json").read_text())
    assert figures["after"]["return"] >= figures["before"]["return"] - figures["tolerance"]
    assert verify(trial / "simplified.fold").verdict == "certified"


def test_polish_and_simplify_in_one(pyramid: Path) -> None:
    assert main(["polish", str(pyramid), "target=pyramid", "--simplify", *FEW]) == 0
    figures = json.loads(pyramid.with_name("pyramid-rdm-seed0.polished.json").read_text())
    assert figures["simplified"]["removed"] == 0
    assert figures["simplified"]["after"]["creases"] == 16


def test_what_is_wrong_is_said_in_one_line(pyramid: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shelf = shutil.copy(DESIGNS / "shelf-mcts-seed4.fold", tmp_path)
    for arguments, said in (
        ([str(shelf)], "only objective=shape with a target can"),
        ([str(tmp_path / "none.fold")], "must be the folder of a run or of a trial"),
        ([str(pyramid), "target=bowl"], "must be 9"),
        ([str(pyramid), "--steps", "many"], "must be a whole number"),
        ([str(pyramid), "--steps", "1.5"], "must be a whole number"),
        ([str(pyramid), "--steps", "0"], "must be a whole number from 1"),
        ([str(pyramid), "--finer", "0"], "the parts of a cell"),
        ([str(pyramid), "--best", "0"], "must be a whole number from 1"),
    ):
        assert main(["polish", *arguments]) == 2, arguments
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
