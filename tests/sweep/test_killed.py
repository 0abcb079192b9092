"""Workers that are killed while they play: on one journal, and on a PostgreSQL server with an MLflow server."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from optuna.trial import FrozenTrial, TrialState

from origami_lab.sweep.storage import open_storage
from origami_lab.sweep.studies import best_slot
from origami_lab.tracking.store import open_client
from tests.sweep.conftest import (
    ROOT,
    declare,
    kill,
    play_here,
    running_workers,
    start_command,
    trials_in,
    trials_of,
    values,
    wait_for,
    write_file,
)
from tests.sweep.servers import mlflow_server, postgres

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not hasattr(os, "killpg"), reason="kills process groups")]

SLOW: dict[str, Any] = {
    "searcher": "napper",
    "config_dir": str(ROOT / "tests/sweep/conf"),
    "space": {"search.skip": {"low": 0, "high": 1000}},
    "trials": 10,
    "held_out": {"seeds": "50..51"},
}
"""A sweep whose trials can be caught while they run, and whose returns do not depend on how slow they are."""
SECRET = "sEcrEt"
"""A password that must be nowhere but where the user wrote it."""


@dataclass(frozen=True)
class Shared:
    """What the workers of a study share."""

    trials: Callable[[], list[FrozenTrial]]
    """Reads Optuna's trials anew."""
    settings: dict[str, Any] = field(default_factory=dict)
    """Where the study and its runs are, in the sweep's file; none: a journal in the folder, and no tracking."""

    restart: Callable[[], None] = lambda: None
    """Takes the database away, and brings it back."""

    @property
    def tracking_uri(self) -> str | None:
        return self.settings["tracking"]["uri"] if self.settings else None


@pytest.fixture
def journal(tmp_path: Path) -> Shared:
    file = tmp_path / "out" / "study.journal"
    return Shared(lambda: trials_in(file) if file.is_file() else [])


@pytest.fixture
def servers(tmp_path: Path) -> Iterator[Shared]:
    with postgres() as database, mlflow_server(tmp_path) as tracking:
        storage = open_storage(declare(tmp_path, storage=database.url), patience=60.0)
        shown = {"storage": database.url.replace("@", f":{SECRET}@"), "tracking": {"kind": "mlflow", "uri": tracking}}
        yield Shared(lambda: trials_of(storage), shown, database.restart)
        files = [file for file in tmp_path.rglob("*") if file.is_file()]
        assert {file.name for file in files if SECRET.encode() in file.read_bytes()} == {"small.yaml"}


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """What one worker finds that nobody disturbs."""
    return play_here(declare(tmp_path_factory.mktemp("alone"), **SLOW))


def assert_all_played_once(trials: list[FrozenTrial], alone: list[Any]) -> None:
    """Each slot has been played to its end once, and found what it does when nobody is killed."""
    ended = [trial for trial in trials if trial.state in (TrialState.COMPLETE, TrialState.PRUNED)]
    others = [trial for trial in trials if trial not in ended]
    assert sorted(trial.user_attrs["place"] for trial in ended) == list(range(SLOW["trials"]))
    assert {trial.state for trial in others} <= {TrialState.FAIL}
    assert {trial.user_attrs["end"] for trial in others} <= {"lost", "stopped", "surplus"}
    found = {trial.user_attrs["place"]: ("complete", trial.params, trial.value) for trial in ended}
    assert [found[slot] for slot in sorted(found)] == values(alone)
    best = max(ended, key=lambda trial: (trial.value or -99, -trial.user_attrs["place"]))  # of equals the first slot's
    expected = best_slot(alone)
    assert expected is not None
    assert (best.params, best.value) == (expected.trial.params, expected.trial.value)


def assert_tracked_once(address: str, alone: list[Any]) -> None:
    """The server has one run of the study, finished, and one nested in it for each trial."""
    client = open_client(address)
    experiment = client.get_experiment_by_name("sweep small")
    assert experiment is not None
    runs = client.search_runs([experiment.experiment_id])
    (study,) = [run for run in runs if "mlflow.parentRunId" not in run.data.tags]
    nested = [run for run in runs if "trial" in run.data.tags]
    assert sorted(int(run.data.tags["trial"]) for run in nested) == list(range(SLOW["trials"]))
    assert {run.data.tags["mlflow.parentRunId"] for run in nested} == {study.info.run_id}
    assert {run.info.status for run in runs} == {"FINISHED"}
    seeds = [(run.data.tags["mlflow.parentRunId"], run.data.tags["seed"]) for run in runs if "seed" in run.data.tags]
    trials = [run.info.run_id for run in nested]
    assert sorted(seeds) == sorted((trial, str(seed)) for trial in trials for seed in (0, 1))
    assert len(runs) == 1 + len(nested) + len(seeds)
    returns = {int(run.data.tags["trial"]): run.data.metrics["mean_return"] for run in nested}
    assert returns == {slot.number: slot.trial.value for slot in alone}
    best = best_slot(alone)
    assert best is not None
    assert study.data.metrics["best_mean_return"] == best.trial.value
    files = {file.path for file in client.list_artifacts(study.info.run_id)}
    assert files >= {"best.yaml", "summary.md", "history.png"}


def lost(trials: list[FrozenTrial]) -> int:
    return sum(trial.user_attrs.get("end") == "lost" for trial in trials)


@pytest.mark.parametrize("where", ["journal", "servers"])
def test_four_workers_one_killed_twice_then_stopped_and_resumed(
    where: str, tmp_path: Path, alone: list[Any], request: pytest.FixtureRequest
) -> None:
    shared: Shared = request.getfixturevalue(where)
    write_file(tmp_path, **SLOW, **shared.settings)
    process = start_command(ROOT, f"{tmp_path}/small.yaml", "workers=4", NAP="1.5")
    first = wait_for(lambda: len(four := running_workers(shared.trials())) == 4 and four)
    kill(first[0])
    # another one takes its place, and is killed in its turn
    second = wait_for(lambda: [pid for pid in running_workers(shared.trials()) if pid not in first])
    kill(second[0])
    wait_for(lambda: lost(shared.trials()) == 2)
    process.send_signal(signal.SIGINT)
    output = process.communicate(timeout=60)[0]
    assert process.returncode == 130, output
    assert "a worker died (killed by signal 9)" in output
    assert "stopping" in output
    assert "Traceback" not in output
    assert not running_workers(shared.trials())
    assert "stopped" in {trial.user_attrs.get("end") for trial in shared.trials()}

    resumed = start_command(ROOT, f"{tmp_path}/small.yaml", "workers=4")
    output = resumed.communicate(timeout=300)[0]
    assert resumed.returncode == 0, output
    assert_all_played_once(shared.trials(), alone)
    assert lost(shared.trials()) == 2
    table = (tmp_path / "out" / "trials.csv").read_text().splitlines()
    assert [line.partition(",")[0] for line in table[1:]] == [str(number) for number in range(SLOW["trials"])]
    best = best_slot(alone)
    assert best is not None
    assert f"best: trial {best.number}, " in output
    if shared.tracking_uri is not None:
        assert_tracked_once(shared.tracking_uri, alone)


def test_two_machines_on_one_database_one_killed(tmp_path: Path, alone: list[Any], servers: Shared) -> None:
    """Two folders that know nothing of each other stand for two machines."""
    machines = []
    for name, workers in (("one", 2), ("two", 1)):
        (tmp_path / name).mkdir()
        write_file(tmp_path / name, **SLOW, **servers.settings)
        machines.append(start_command(ROOT, f"{tmp_path}/{name}/small.yaml", f"workers={workers}", NAP="0.5"))
    first, second = machines
    wait_for(lambda: any(os.getpgid(pid) == first.pid for pid in running_workers(servers.trials())))
    os.killpg(first.pid, signal.SIGKILL)
    first.communicate()
    servers.restart()
    output = second.communicate(timeout=300)[0]
    assert second.returncode == 0, output
    trials = servers.trials()
    assert_all_played_once(trials, alone)
    assert lost(trials) >= 1
    hosts = {trial.user_attrs["folder"].split("/out/")[0] for trial in trials if trial.state == TrialState.COMPLETE}
    assert str(tmp_path / "two") in hosts
    assert "Traceback" not in output
    assert SECRET not in output
    assert servers.tracking_uri is not None
    assert_tracked_once(servers.tracking_uri, alone)
