"""Runs of version 0.1.0 in MLflow: pushed for the first time, and finished where they were pushed before."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import mlflow
import pytest
from mlflow.entities import Run
from mlflow.tracking import MlflowClient

from tests.old_runs.conftest import assert_found, command, recorded, unpack

MADE_WITH = "3.17.2"
"""The version of MLflow whose store results/mlflow.sql is."""


def runs_in(store: Path) -> tuple[Run, dict[int, Run]]:
    """The one experiment's run in a store, and those nested in it, by seed."""
    client = MlflowClient(f"sqlite:///{store}")
    found = client.search_runs([experiment.experiment_id for experiment in client.search_experiments()])
    nested = {int(run.data.tags["seed"]): run for run in found if "mlflow.parentRunId" in run.data.tags}
    [parent] = [run for run in found if "mlflow.parentRunId" not in run.data.tags]
    assert {run.data.tags["mlflow.parentRunId"] for run in nested.values()} == {parent.info.run_id}
    assert len(nested) == len(found) - 1
    return parent, nested


def returns(runs: dict[int, Run]) -> dict[int, Any]:
    return {seed: pytest.approx(run.data.metrics["return"], abs=1e-9) for seed, run in runs.items()}


def test_run_that_no_store_has_seen_is_pushed_once(here: Path) -> None:
    """Its server was down while it ran."""
    unpack(here, "unpushed")
    rows = recorded(here / "unpushed/trials.csv")
    for _ in range(2):
        assert command("dashboard", "--sync", "unpushed", "--uri", f"sqlite:///{here}/store.db") == 0
        parent, nested = runs_in(here / "store.db")
        assert returns(nested) == {seed: float(row["return"]) for seed, row in rows.items()}
        assert {run.info.status for run in (parent, *nested.values())} == {"FINISHED"}
        assert parent.data.metrics["return_mean"] == pytest.approx(
            sum(float(row["return"]) for row in rows.values()) / len(rows), abs=1e-9
        )


@pytest.fixture
def stopped(here: Path) -> Path:
    """A run that was ended by Ctrl-C in its third seed, beside the store that it was pushed to; returns the store."""
    unpack(here, "pushed", "results")
    store = here / "results/mlflow.db"
    with sqlite3.connect(store) as database:
        database.executescript(store.with_suffix(".sql").read_text(encoding="utf-8"))
    database.close()
    if mlflow.__version__ != MADE_WITH:
        from mlflow.store.db.utils import _upgrade_db, create_sqlalchemy_engine

        _upgrade_db(create_sqlalchemy_engine(f"sqlite:///{store}"))
    return store


def test_stopped_run_is_finished_where_it_was_tracked(here: Path, stopped: Path) -> None:
    """Two trials stay as they were pushed; the one that was stopped is made anew."""
    parent, before = runs_in(stopped)
    assert parent.info.status == "KILLED"
    command_again = ("target=cube", "search=rdm", "budget=100000", "seed=0..2", "files=designs", "workers=1")
    assert command(*command_again, "verbosity=quiet", "output=pushed", "resume=true") == 0
    rows = recorded(here / "expected/pushed.csv")
    assert_found(here / "pushed", rows, range(3))
    now, nested = runs_in(stopped)
    assert now.info.run_id == parent.info.run_id
    assert now.info.status == "FINISHED"
    assert returns(nested) == {seed: float(row["return"]) for seed, row in rows.items()}
    for seed in (0, 1):
        assert nested[seed].info.run_id == before[seed].info.run_id
        assert nested[seed].info.end_time == before[seed].info.end_time
    assert {run.info.status for run in nested.values()} == {"FINISHED"}


def test_nothing_is_pushed_twice(here: Path, stopped: Path) -> None:
    _, before = runs_in(stopped)
    assert command("dashboard", "--sync", "pushed") == 0
    _, after = runs_in(stopped)
    assert {seed: run.to_dictionary() for seed, run in after.items()} == {
        seed: run.to_dictionary() for seed, run in before.items()
    }
