"""MLflow runs, read back with client code; trackers that fail; the dashboard's store."""

from __future__ import annotations

import csv
import json
import multiprocessing
import os
import shutil
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from origami_lab.errors import InputError
from origami_lab.runs.trial_row import read_trials
from origami_lab.tracking.mlflow_server import find_store
from origami_lab.tracking.store import create_database, open_client
from tests.experiment.test_runner import OWN_OBJECTIVE, ROOT, background, wait_for
from tests.small_runs import SMALL, run

pytestmark = pytest.mark.slow


def runs_of(folder: Path, experiment: str = "pyramid") -> list[Any]:
    client = open_client(f"sqlite:///{folder}/results/mlflow.db")
    found = client.get_experiment_by_name(experiment)
    assert found is not None
    return sorted(client.search_runs([found.experiment_id]), key=lambda run: str(run.info.run_name))


def parents(runs: list[Any]) -> list[Any]:
    return [run for run in runs if "mlflow.parentRunId" not in run.data.tags]


def test_one_parent_and_a_child_for_each_seed_with_its_curve(tracked: Path) -> None:
    client = open_client(f"sqlite:///{tracked}/results/mlflow.db")
    runs = runs_of(tracked)
    (parent,) = parents(runs)
    children = [run for run in runs if run is not parent]
    assert [run.info.run_name for run in children] == ["seed 0", "seed 1", "seed 2"]
    assert {run.data.tags["mlflow.parentRunId"] for run in children} == {parent.info.run_id}
    assert {run.info.status for run in runs} == {"FINISHED"}
    for child, row in zip(children, read_trials(tracked / "out/trials.csv"), strict=True):
        history = client.get_metric_history(child.info.run_id, "best_return")
        with (tracked / f"out/seed={row.seed}/curve.csv").open() as file:
            curve = [(int(point["interactions"]), float(point["return"])) for point in csv.DictReader(file)]
        assert [(point.step, point.value) for point in history] == curve
        for name in ("return", "return_surface", "driving_angle", "vertices", "interactions_to_best"):
            assert child.data.metrics[name] == row[name]
        assert child.data.params["seed"] == str(row.seed)
        assert child.data.params["search._target_"].endswith("RandomSearch")
        assert child.data.params["board.size"] == "9"
        artifacts = {file.path for file in client.list_artifacts(child.info.run_id)}
        assert artifacts >= {"pattern.png", "folded.png", "motion.gif", "best.fold", "best.fold.json", "curve.csv"}
        assert artifacts >= {"best.html", "pattern.svg", "certificate.json"}
        assert child.data.tags["certificate"] == row.certificate


def test_ten_seeds_are_one_experiment(tmp_path: Path) -> None:
    assert run(tmp_path, "target=pyramid", "search=bfts", "budget=2000", "seed=0..9", "output=out") == 0
    client, runs = open_client(f"sqlite:///{tmp_path}/results/mlflow.db"), runs_of(tmp_path)
    (parent,) = parents(runs)
    children = [run for run in runs if run.data.tags.get("mlflow.parentRunId") == parent.info.run_id]
    assert len(runs) == 11
    assert {child.data.params["seed"] for child in children} == {str(seed) for seed in range(10)}
    for child in children:
        values = [point.value for point in client.get_metric_history(child.info.run_id, "best_return")]
        assert values
        assert values == sorted(values)


def test_the_parent_shows_the_summary(tracked: Path) -> None:
    client = open_client(f"sqlite:///{tracked}/results/mlflow.db")
    (parent,) = parents(runs_of(tracked))
    summary = json.loads((tracked / "out/summary.json").read_text())
    assert parent.data.metrics["return_mean"] == summary["returns"]["return"]["mean"]
    assert parent.data.metrics["return_std"] == summary["returns"]["return"]["std"]
    assert parent.data.metrics["best_return"] == summary["best"]["return"]
    assert parent.data.tags["task"] == "pyramid"
    artifacts = {file.path for file in client.list_artifacts(parent.info.run_id)}
    assert artifacts == {"config.yaml", "trials.csv", "summary.json", "best"}
    best = {Path(file.path).name for file in client.list_artifacts(parent.info.run_id, "best")}
    assert best == {"pattern.png", "folded.png", "motion.gif", "best.html", "pattern.svg", "certificate.json"}
    certified = parent.data.metrics["designs_certified"]
    assert certified == summary["certificates"]["certified"]
    assert certified + sum(parent.data.metrics[f"designs_{name}"] for name in ("refuted", "not_certifiable")) == 3
    assert parent.data.tags["certificate"] in summary["certificates"]
    # beside the store, so that the folder results/ is all there is to keep
    assert (tracked / "results/mlartifacts").is_dir()
    assert {file.name for file in tracked.iterdir()} == {"out", "results"}


NAME = "pyramid rdm · budget=400 · {} seeds"


def test_resume_adds_to_the_same_runs(tracked: Path, tmp_path: Path) -> None:
    shutil.copytree(tracked / "out", tmp_path / "out")
    (tmp_path / "out/tracking.json").unlink()
    more = (*SMALL, "output=out", "resume=true")
    # what no tracker heard of is pushed, once
    assert run(tmp_path, *more, "seed=0..2") == 0
    assert [r.info.run_name for r in runs_of(tmp_path)] == [NAME.format(3), *(f"seed {seed}" for seed in range(3))]
    assert run(tmp_path, *more, "seed=0..3") == 0
    runs = runs_of(tmp_path)
    assert [r.info.run_name for r in runs] == [NAME.format(4), *(f"seed {seed}" for seed in range(4))]
    assert parents(runs)[0].data.metrics["trials_ok"] == 4


def test_a_dead_server_costs_a_warning_and_no_result(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    assert run(tmp_path, *SMALL, "tracking.uri=http://127.0.0.1:9", "output=out") == 0
    err = capfd.readouterr().err
    assert err.count("warning: tracking:") == 1
    assert "Traceback" not in err
    assert [row.status for row in read_trials(tmp_path / "out/trials.csv")] == ["ok"]
    assert (tmp_path / "out/summary.json").is_file()


def test_a_store_that_cannot_be_made_costs_a_warning(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results").write_text("a file where the folder should be")
    assert run(tmp_path, *SMALL, "output=out") == 0
    assert capfd.readouterr().err.count("warning: tracking:") == 1
    assert (tmp_path / "out/seed=0/best.fold").is_file()


def test_processes_may_create_the_store_at_once(tmp_path: Path) -> None:
    database = tmp_path / "deep/mlflow.db"
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=create_database, args=(database,)) for _ in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(120)
    assert [process.exitcode for process in processes] == [0, 0, 0]
    assert [file.name for file in database.parent.iterdir()] == ["mlflow.db"]
    client = open_client(f"sqlite:///{database}")
    assert [experiment.name for experiment in client.search_experiments()] == ["Default"]


def test_the_dashboard_finds_the_store_from_anywhere_below(tracked: Path, tmp_path: Path) -> None:
    store = f"sqlite:///{tracked}/results/mlflow.db"
    assert find_store(None, tracked) == store
    assert find_store(None, tracked / "results") == store
    assert find_store(None, tracked / "out/seed=0") == store
    assert find_store(store, tmp_path) == store
    assert find_store("http://localhost:5000", tmp_path) == "http://localhost:5000"
    with pytest.raises(InputError, match="directory="):
        find_store(None, tmp_path)


def test_a_batch_system_that_signals_every_process(tmp_path: Path) -> None:
    """The pusher has a session of its own, but a container's end reaches it, too."""
    arguments = ("objective=beacon", f"objective.file={tmp_path}/on", "budget=1e9", "seed=0", "workers=1")
    tracked = tuple(text for text in OWN_OBJECTIVE if text != "tracking=none")
    store = (f"output={tmp_path}/out", f"tracking.uri=sqlite:///{tmp_path}/results/mlflow.db")
    process = background(ROOT, *tracked, *arguments, *store, "tracking.experiment=batch")
    wait_for((tmp_path / "out/tracking.json").exists, process)
    time.sleep(1.0)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert any(b"tracking.push_process" in Path(f"/proc/{child}/cmdline").read_bytes() for child in children)
    for child in (*children, process.pid):
        os.kill(int(child), signal.SIGTERM)
    assert process.wait(120) == 130
    assert {run.info.status for run in runs_of(tmp_path, "batch")} == {"KILLED"}
