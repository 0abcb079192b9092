"""Workers that are killed while they play: on one journal, and on a PostgreSQL server with an MLflow server."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import optuna
import pytest
from optuna.trial import FrozenTrial, TrialState

from origami_lab.sweep.jobs import best_place
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

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not hasattr(os, "killpg"), reason="kills process groups")]

SLOW: dict[str, Any] = {
    "searcher": "napper",
    "config_dir": str(ROOT / "tests/sweep/conf"),
    "space": {"search.skip": {"low": 0, "high": 1000}},
    "trials": 10,
}
"""A sweep whose trials can be caught while they run, and whose returns do not depend on how slow they are."""
POSTGRES = Path("/usr/lib/postgresql")


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """What one worker finds that nobody disturbs."""
    return play_here(declare(tmp_path_factory.mktemp("alone"), **SLOW))


def assert_all_played_once(trials: list[FrozenTrial], alone: list[Any]) -> None:
    """Each place has been played to its end once, and found what it does when nobody is killed."""
    ended = [trial for trial in trials if trial.state in (TrialState.COMPLETE, TrialState.PRUNED)]
    others = [trial for trial in trials if trial not in ended]
    assert sorted(trial.user_attrs["place"] for trial in ended) == list(range(SLOW["trials"]))
    assert {trial.state for trial in others} <= {TrialState.FAIL}
    assert {trial.user_attrs["end"] for trial in others} <= {"lost", "stopped", "surplus"}
    found = {trial.user_attrs["place"]: ("complete", trial.params, trial.value) for trial in ended}
    assert [found[place] for place in sorted(found)] == values(alone)
    best, expected = max(ended, key=lambda trial: trial.value or -99), best_place(alone)
    assert expected is not None
    assert (best.params, best.value) == (expected.trial.params, expected.trial.value)


def lost(trials: list[FrozenTrial]) -> int:
    return sum(trial.user_attrs.get("end") == "lost" for trial in trials)


def test_four_workers_on_one_journal_killed_twice_then_stopped(tmp_path: Path, alone: list[Any]) -> None:
    write_file(tmp_path, **SLOW, output="out", held_out={"seeds": "50..51"})
    journal = tmp_path / "out" / "study.journal"
    process = start_command(tmp_path, "small.yaml", "workers=4", NAP="1.5")
    wait_for(journal.is_file)
    first = wait_for(lambda: len(four := running_workers(trials_in(journal))) == 4 and four)
    kill(first[0])
    # another one takes its place, and is killed in its turn
    second = wait_for(lambda: [pid for pid in running_workers(trials_in(journal)) if pid not in first])
    kill(second[0])
    wait_for(lambda: lost(trials_in(journal)) == 2)
    process.send_signal(signal.SIGINT)
    output = process.communicate(timeout=60)[0]
    assert process.returncode == 130, output
    assert "a worker died (killed by signal 9)" in output
    assert "stopping" in output
    assert "Traceback" not in output
    assert not running_workers(trials_in(journal))
    assert "stopped" in {trial.user_attrs.get("end") for trial in trials_in(journal)}

    resumed = start_command(tmp_path, "small.yaml", "workers=2")
    output = resumed.communicate(timeout=300)[0]
    assert resumed.returncode == 0, output
    assert_all_played_once(trials_in(journal), alone)
    assert lost(trials_in(journal)) == 2
    table = (tmp_path / "out" / "trials.csv").read_text().splitlines()
    assert [line.partition(",")[0] for line in table[1:]] == [str(number) for number in range(SLOW["trials"])]
    best = best_place(alone)
    assert best is not None
    assert f"Best: trial {best.number}, mean return {best.trial.value:.4f}" in output


@pytest.fixture
def postgres() -> Iterator[str]:
    """The address of a database server on loopback that is gone afterwards."""
    programs = sorted(POSTGRES.glob("*/bin"))
    pytest.importorskip("psycopg")
    if not programs or (os.getuid() == 0 and shutil.which("setpriv") is None):
        pytest.skip("PostgreSQL is not installed")
    # it refuses to run as root
    other = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"] if os.getuid() == 0 else []
    folder = Path(tempfile.mkdtemp(prefix="postgres"))
    if other:
        shutil.chown(folder, "nobody", "nogroup")
    data, port = folder / "data", free_port()

    def run(program: str, *arguments: str) -> None:
        subprocess.run([*other, str(programs[-1] / program), *arguments], cwd=folder, check=True, capture_output=True)

    run("initdb", "-D", str(data), "-U", "sweeper", "--auth=trust", "--no-sync")
    options = f"-c listen_addresses=127.0.0.1 -c port={port} -c unix_socket_directories={folder} -c fsync=off"
    run("pg_ctl", "-D", str(data), "-w", "-l", str(folder / "log"), "-o", options, "start")
    try:
        yield f"postgresql://sweeper@127.0.0.1:{port}/postgres"
    finally:
        run("pg_ctl", "-D", str(data), "-m", "immediate", "stop")
        shutil.rmtree(folder)


@pytest.fixture
def mlflow_server(tmp_path: Path) -> Iterator[str]:
    """The address of an MLflow server on loopback."""
    port = free_port()
    store = ["--backend-store-uri", f"sqlite:///{tmp_path}/server.db", "--artifacts-destination", str(tmp_path / "art")]
    command = [sys.executable, "-m", "mlflow", "server", *store, "--host", "127.0.0.1", "--port", str(port)]
    process = subprocess.Popen(
        [*command, "--workers", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, "MLFLOW_DISABLE_TELEMETRY": "true", "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"},
    )
    address = f"http://127.0.0.1:{port}"
    try:
        wait_for(lambda: answers(address))
        yield address
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def answers(address: str) -> bool:
    try:
        urlopen(f"{address}/health", timeout=2).close()
    except OSError:
        return False
    return True


def test_two_machines_on_one_database_one_killed(
    tmp_path: Path, alone: list[Any], postgres: str, mlflow_server: str
) -> None:
    """Two folders that know nothing of each other stand for two machines."""
    shared = {
        "storage": postgres,
        "tracking": {"kind": "mlflow", "uri": mlflow_server},
        "held_out": {"seeds": "50..51"},
    }
    machines = []
    for name, workers in (("one", 2), ("two", 1)):
        (tmp_path / name).mkdir()
        write_file(tmp_path / name, **SLOW, **shared, output="out")
        machines.append(start_command(tmp_path / name, "small.yaml", f"workers={workers}", NAP="0.5"))
    storage = optuna.storages.get_storage(postgres.replace("postgresql:", "postgresql+psycopg:"))
    first, second = machines
    wait_for(lambda: any(os.getpgid(pid) == first.pid for pid in running_workers(trials_of(storage))))
    os.killpg(first.pid, signal.SIGKILL)
    first.communicate()
    output = second.communicate(timeout=300)[0]
    assert second.returncode == 0, output
    trials = trials_of(storage)
    assert_all_played_once(trials, alone)
    assert lost(trials) >= 1
    hosts = {trial.user_attrs["folder"].split("/out/")[0] for trial in trials if trial.state == TrialState.COMPLETE}
    assert str(tmp_path / "two") in hosts

    from origami_lab.experiment.stores import open_client

    client = open_client(mlflow_server)
    found = client.get_experiment_by_name("sweep small")
    assert found is not None
    runs = client.search_runs([found.experiment_id])
    (study,) = [run for run in runs if "mlflow.parentRunId" not in run.data.tags]
    nested = [run for run in runs if run is not study]
    assert sorted(int(run.data.tags["trial"]) for run in nested) == list(range(SLOW["trials"]))
    assert {run.data.tags["mlflow.parentRunId"] for run in nested} == {study.info.run_id}
    best = best_place(alone)
    assert best is not None
    assert study.data.metrics["best_mean_return"] == best.trial.value
    assert study.info.status == "FINISHED"
    assert {file.path for file in client.list_artifacts(study.info.run_id)} >= {
        "best.yaml",
        "summary.md",
        "history.png",
    }
