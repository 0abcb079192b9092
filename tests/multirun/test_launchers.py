"""Several experiments with ``-m``: one folder, one experiment in MLflow, and the same results in other processes."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path
from typing import Any

import pytest

from origami_lab.config.node import FREE_TO_CHANGE
from origami_lab.multirun.launchers import LAUNCHERS
from origami_lab.runs.trial_row import read_trials
from tests.small_runs import TIMINGS, run

pytestmark = pytest.mark.slow

GRID = ("-m", "target=pyramid", "search=glob([rdm,dfts])", "budget=60", "seed=0", "verbosity=quiet")
NAMES = ["pyramid · dfts", "pyramid · rdm"]
PLAIN = ("-m", "target=pyramid", "tracking=none", "files=designs", "budget=60")


def found(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """The trials of all jobs, without what the clock says."""
    return {
        file.parent.name: [{k: v for k, v in row.values().items() if k not in TIMINGS} for row in read_trials(file)]
        for file in sorted(folder.glob("*/trials.csv"))
    }


def runs(folder: Path) -> dict[str, list[Any]]:
    """What is in the store, by experiment; without MLflow's own empty one."""
    from mlflow import MlflowClient

    client = MlflowClient(f"sqlite:///{folder}/results/mlflow.db")
    there = {kind.name: list(client.search_runs([kind.experiment_id])) for kind in client.search_experiments()}
    return {name: found for name, found in there.items() if found}


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "multirun.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a tracked multirun of two jobs, as the default names it."""
    place = tmp_path_factory.mktemp("multirun")
    assert run(place, *GRID) == 0
    (folder,) = (place / "results/multirun").iterdir()
    return folder


def test_one_folder_and_one_experiment(first: Path) -> None:
    place = first.parents[2]
    names = ["dfts", "index.html", "multirun.csv", "multirun.json", "multirun.yaml", "rdm"]
    assert sorted(file.name for file in first.iterdir()) == names
    assert [file.name for file in place.iterdir()] == ["results"]
    ((experiment, there),) = runs(place).items()
    assert experiment.startswith(f"multirun-{first.name}-")
    parents = {run.info.run_name: run for run in there if "seed" not in run.data.tags}
    children = [run for run in there if "seed" in run.data.tags]
    assert sorted(parents) == NAMES
    assert sorted(run.info.run_name for run in children) == [f"seed 0 · {job}" for job in NAMES]
    for logged in (one.data for one in there):  # a parameter cannot change when the run is resumed
        changing = {name for name in logged.params if name.partition(".")[0] in FREE_TO_CHANGE}
        assert changing == ({"seed"} if "seed" in logged.tags else set())
        assert logged.params["budget"] == "60"
    assert {run.data.tags["multirun"] for run in there} == {experiment.removeprefix("multirun-")}
    for number, (name, method) in enumerate(zip(NAMES, ("dfts", "rdm"), strict=True)):
        tags = parents[name].data.tags
        assert (tags["job"], tags["task"], tags["search"]) == (str(number), "pyramid", method)
        assert tags["differs"] == f"search={method}"
        (own,) = (run for run in children if run.data.tags["mlflow.parentRunId"] == parents[name].info.run_id)
        assert own.data.tags["differs"] == f"search={method}"


def test_the_table_of_all_jobs(first: Path) -> None:
    rows = table(first)
    assert [(row["folder"], row["search"], row["status"]) for row in rows] == [
        ("dfts", "dfts", "ok"),
        ("rdm", "rdm", "ok"),
    ]
    for row in rows:
        (trial,) = found(first)[row["folder"]]
        assert float(row["return_mean"]) == trial["return"]


def test_a_report_on_a_multirun(first: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, "report", str(first), "--output", "report") == 0
    assert "2 trials of 2 runs" in capsys.readouterr().out
    assert "| rdm" in (tmp_path / "report/returns.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("launcher", "tracked"), [("joblib", True), ("submitit_local", False)])
def test_other_processes_find_the_same(first: Path, launcher: str, tracked: bool, tmp_path: Path) -> None:
    pytest.importorskip(LAUNCHERS[launcher].package, reason="the extra cluster is not installed")
    untracked = () if tracked else ("tracking=none",)
    assert run(tmp_path, *GRID, f"hydra/launcher={launcher}", "output=out", *untracked) == 0
    assert found(tmp_path / "out") == {name: trials for name, trials in found(first).items() if name in ("rdm", "dfts")}
    assert {row["status"] for row in table(tmp_path / "out")} == {"ok"}
    if tracked:  # two jobs at once on a store that was not there
        (there,) = runs(tmp_path).values()
        assert sorted(run.info.run_name for run in there if "seed" not in run.data.tags) == NAMES


def test_a_multirun_goes_on_and_grows(first: Path, capfd: pytest.CaptureFixture[str]) -> None:
    place, before = first.parents[2], found(first)
    output = f"output={first.relative_to(place)}"
    assert run(place, *GRID, output) == 2
    assert "resume=true finishes the multirun in it" in capfd.readouterr().err
    # a trial that is gone runs again, what is there stays, a new job gets a folder of its own
    shutil.rmtree(first / "rdm/seed=0")
    kept = (first / "dfts/seed=0/result.json").stat().st_mtime_ns
    longer = ("search=choice(rdm)", "budget=range(60,80,10)", output, "resume=true")
    assert run(place, *GRID, *longer) == 0
    now = found(first)
    assert list(now) == ["dfts", "rdm", "rdm-budget=70"]
    assert {name: now[name] for name in before} == before
    assert (first / "rdm/seed=0/best.fold").is_file()
    assert (first / "dfts/seed=0/result.json").stat().st_mtime_ns == kept
    (there,) = runs(place).values()
    names = [*NAMES, "budget=70 · pyramid · rdm"]
    assert sorted(run.info.run_name for run in there) == sorted([*names, *(f"seed 0 · {name}" for name in names)])
    budgets = {row["folder"]: row["budget"] for row in table(first)}
    assert budgets == {"dfts": "60", "rdm": "60", "rdm-budget=70": "70"}


def test_other_seeds_are_other_jobs_where_jobs_differ_in_seeds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    grid = (*PLAIN, "search=rdm", "output=out")
    assert run(tmp_path, *grid, "seed=0..1,5") == 0
    said = capsys.readouterr()
    begun = [line for line in said.err.splitlines() if line.startswith("job ")]
    assert begun == ["job 1 of 2: seed=0..1 · pyramid · rdm", "job 2 of 2: seed=5 · pyramid · rdm"]
    assert "seed 5: " in said.err
    assert "drawing" not in said.err  # there are no pictures
    assert run(tmp_path, *grid, "seed=7", "resume=true") == 0
    rows = {row["folder"]: row["seed"] for row in table(tmp_path / "out")}
    assert rows == {"seed=0..1": "0..1", "seed=5": "5", "seed=7": "7"}
    held = {name: [row["seed"] for row in trials] for name, trials in found(tmp_path / "out").items()}
    assert held == {"seed=0..1": [0, 1], "seed=5": [5], "seed=7": [7]}


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (("search=glob(zz*)",), "error: search=glob(zz*): names no value, so that there is no job to run\n"),
        (("budget=range(10,5)",), "error: budget=range(10,5): names no value, so that there is no job to run\n"),
        (("search=rdm,dfts,rdm",), "error: search=rdm,dfts,rdm: names rdm more than once; "),
        (("seed=0..1,[0,1]",), "error: seed=[0,1]: makes the same job twice; "),
    ],
)
def test_no_job_or_one_twice_is_refused(
    settings: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place in ((), ("output=out",)):
        assert run(tmp_path, *PLAIN, *settings, *place) == 2
        error = capsys.readouterr().err
        assert error.startswith(said)
        assert error.count("\n") == 1
        assert list(tmp_path.iterdir()) == []


def test_a_value_that_refers_to_another_is_the_job_s_own(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """And the exit code is of all jobs, also those that the command does not name."""
    grid = ("target=pyramid", "search=rdm", "board=9x9,13x13", "budget=${board.size}", "seed=0")
    quick = ("tracking=none", "files=designs", "output=out")
    assert run(tmp_path, "-m", *grid, *quick) == 0
    rows = table(tmp_path / "out")
    assert [(row["board"], row["status"], row["interactions"]) for row in rows] == [
        ("9x9", "ok", "9"),
        ("13x13", "ok", "13"),
    ]
    shutil.rmtree(tmp_path / "out" / rows[0]["folder"])
    grid = ("target=pyramid", "search=rdm", "board=13x13", "budget=${board.size}", "seed=0")
    capfd.readouterr()
    assert run(tmp_path, "-m", *grid, *quick, "resume=true") == 1
    assert "not run" in capfd.readouterr().out
