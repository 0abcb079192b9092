"""The command, from its file to best.yaml, plots, comparison and MLflow runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from PIL import Image

from origami_lab.cli import main
from origami_lab.runs.trial_row import read_trials
from tests.sweep.conftest import ROOT, declare, play_here, values, write_file


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a sweep was run by two workers, with tracking."""
    folder = tmp_path_factory.mktemp("swept")
    against = {"paper": ["search.rescale=false"]}
    write_file(folder, output="out", tracking="mlflow", held_out={"seeds": "50..52", "against": against})
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["sweep", "small.yaml", "workers=2", "--quiet"]) == 0
    return folder


def summary_of(folder: Path) -> dict[str, Any]:
    found = json.loads((folder / "out" / "summary.json").read_text())
    assert isinstance(found, dict)
    return found


def runs_in(folder: Path) -> list[Any]:
    from mlflow import MlflowClient

    client = MlflowClient(f"sqlite:///{folder / 'results' / 'mlflow.db'}")
    experiments = [experiment.experiment_id for experiment in client.search_experiments()]
    return list(client.search_runs(experiments))


@pytest.mark.slow
def test_two_workers_find_what_one_finds(swept: Path, tmp_path: Path) -> None:
    alone = play_here(declare(tmp_path))
    table = (swept / "out" / "trials.csv").read_text().splitlines()
    assert len(table) == 1 + len(alone)
    for line, (state, params, value) in zip(table[1:], values(alone), strict=True):
        cells = line.split(",")
        assert (cells[1], float(cells[2])) == (state, value)
        assert int(cells[6]) == params["search.population"]


@pytest.mark.slow
def test_the_best_runs_again_as_it_is(swept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(swept)
    best = summary_of(swept)["best"]
    config = yaml.safe_load((swept / "out" / "best.yaml").read_text())
    assert config["search"]["population"] == best["point"]["search.population"]
    more = ["files=designs", "tracking=none", "verbosity=quiet", "output=again"]
    assert main(["out/best.yaml", *more]) == 0
    assert {str(row.seed): row.return_ for row in read_trials(Path("again/trials.csv"))} == best["returns"]


def test_the_summary_compares_on_seeds_that_no_trial_played(swept: Path) -> None:
    summary = summary_of(swept)
    held_out = summary["held_out"]
    assert list(held_out["settings"]) == ["best", "defaults", "paper"]
    assert list(held_out["differences"]) == ["defaults", "paper"]
    for name, found in held_out["settings"].items():
        rows = read_trials(swept / "out" / held_out["folder"] / name / "trials.csv")
        assert [row.seed for row in rows] == [50, 51, 52]
        assert [row.return_ for row in rows] == found["returns"]
    assert summary["trials"] == {"complete": 5, "pruned": 0, "failed": 0}
    page = (swept / "out" / "summary.md").read_text()
    assert summary["best"]["command"] in page
    for name in ("history", "importance", "slices", "held_out"):
        assert f"({name}.png)" in page
        with Image.open(swept / "out" / f"{name}.png") as image:
            assert len(set(image.convert("RGB").resize((60, 60)).get_flattened_data())) > 5


def test_mlflow_has_a_run_for_the_study_and_nested_ones_for_trials_and_their_seeds(swept: Path) -> None:
    runs = runs_in(swept)
    (study,) = [run for run in runs if "mlflow.parentRunId" not in run.data.tags]
    nested = {int(run.data.tags["trial"]): run for run in runs if "trial" in run.data.tags}
    seeds = [run for run in runs if "seed" in run.data.tags]
    assert len(runs) == 1 + 5 + 5 * 2 == 1 + len(nested) + len(seeds)
    assert {run.data.tags["mlflow.parentRunId"] for run in nested.values()} == {study.info.run_id}
    assert sorted(nested) == [0, 1, 2, 3, 4]
    summary = summary_of(swept)
    best = summary["best"]
    assert study.data.metrics["best_mean_return"] == best["value"]
    assert study.data.metrics["held_out_best_mean"] == summary["held_out"]["settings"]["best"]["mean"]
    run = nested[best["trial"]]
    assert run.data.metrics["mean_return"] == best["value"]
    assert run.data.params["search.population"] == str(best["point"]["search.population"])
    assert run.data.tags["state"] == "complete"
    below = [seed for seed in seeds if seed.data.tags["mlflow.parentRunId"] == run.info.run_id]
    assert {seed.data.tags["seed"]: seed.data.metrics["return"] for seed in below} == best["returns"]
    assert {seed.info.status for seed in seeds} == {"FINISHED"}


def test_the_same_command_again_adds_nothing_and_a_lost_store_is_filled(
    swept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(swept)
    before = sorted(run.info.run_id for run in runs_in(swept))
    assert main(["dashboard", "--sync", "out"]) == 0
    assert "already there" in capsys.readouterr().out
    assert sorted(run.info.run_id for run in runs_in(swept)) == before
    assert main(["dashboard", "--sync", ".", "--uri", "sqlite:///other.db"]) == 0
    assert "out: 5 trials pushed" in capsys.readouterr().out


def test_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_file(tmp_path, output="out")
    for arguments, begin in (
        (["sweeps/nosuch.yaml"], "sweep=sweeps/nosuch.yaml: there is no such file"),
        (["small.yaml", "storage=redis://localhost"], "storage=redis://localhost: must be a journal file"),
        (["small.yaml", "storage=study.txt"], "storage=study.txt: must be a journal file"),
        (["small.yaml", "output=/proc/nowhere"], "output=/proc/nowhere: must be a folder that can be written"),
        (["small.yaml", "tracking=mlflow", "tracking.uri=ftp://x"], "tracking.uri=ftp://x: must be an MLflow store"),
    ):
        assert main(["sweep", *arguments]) == 2
        err = capsys.readouterr().err
        assert err.startswith(f"error: {begin}"), err
        assert err.count("\n") == 1
    write_file(tmp_path, output="out", space={"search.sigma_9": {"low": 1, "high": 2}})
    assert main(["sweep", "small.yaml"]) == 2
    assert "did you mean search.sigma_" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["small.yaml"]
    assert main(["sweep", "small.yaml", "storage=postgresql://u:secret@127.0.0.1:9/x"]) in (1, 2)
    warning, error = capsys.readouterr().err.splitlines()
    assert "secret" not in warning + error
    assert warning.startswith("warning: the command holds an address with a password")
    assert error.startswith("error: ")


def test_another_declaration_cannot_take_over_a_folder(
    swept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(swept)
    for change, begin in (
        ("budget=301", "budget=301: was 300 when the study small was started"),
        ("study=other", "output=out: holds trials of a study"),
        ("storage=other.journal", "output=out: holds trials of a study that other.journal does not have"),
        ("held_out.against={wrong: [search.scale=1]}", "search.scale=1: there is no such key"),
    ):
        assert main(["sweep", "small.yaml", "tracking=none", change]) == 2
        assert capsys.readouterr().err.startswith(f"error: {begin}")


def test_trials_are_not_taken_back(
    swept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(swept)
    before = (swept / "out" / "trials.csv").read_text()
    assert main(["sweep", "small.yaml", "tracking=none", "trials=3"]) == 0
    assert "was given 5 trials before" in capsys.readouterr().err
    assert (swept / "out" / "trials.csv").read_text() == before
    assert summary_of(swept)["trials"]["complete"] == 5


@pytest.mark.slow
def test_an_objective_that_hangs_fails_its_trial_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)  # where tests/experiment/fakes.py is the user's own
    (tmp_path / "notes").mkdir()
    task = ["objective=broken", "board=9x9", "symmetry=xy", "objective_seconds=1"]
    task += ["objective.ways=[hangs_in_c]", f"objective.notes={tmp_path}/notes"]
    write_file(tmp_path, trials=2, task=task, config_dir=str(ROOT / "tests/experiment/conf"))
    assert main(["sweep", f"{tmp_path}/small.yaml"]) == 1
    lines = (tmp_path / "out" / "trials.csv").read_text().splitlines()
    assert lines[1].startswith("0,failed")
    assert "longer than objective_seconds=1 in one call" in lines[1]
    assert lines[2].startswith("1,complete")
    assert "best: trial 1, " in capsys.readouterr().out
