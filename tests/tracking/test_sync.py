"""`dashboard --sync`: what is on disk comes into the store, once, wherever the last push was cut off."""

from __future__ import annotations

import json
import shutil
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import pytest

from origami_lab.errors import InputError
from origami_lab.runs.locks import held
from origami_lab.runs.run_finder import find_runs
from origami_lab.runs.trial_row import TrialRow, format_trials, read_trials
from origami_lab.tracking.experiment_runs import ExperimentRuns
from origami_lab.tracking.store import StoreError, create_database, open_client
from tests.small_runs import run

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def empty_store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("store") / "mlflow.db"
    create_database(file)
    return file


@pytest.fixture
def place(tracked: Path, empty_store: Path, tmp_path: Path) -> Path:
    """A folder with a store without runs, and a finished run that no store knows."""
    (tmp_path / "results").mkdir()
    shutil.copy(empty_store, tmp_path / "results/mlflow.db")
    shutil.copytree(tracked / "out", tmp_path / "out")
    (tmp_path / "out/tracking.json").unlink()
    return tmp_path


def statuses(place: Path) -> list[str]:
    """The runs that a person sees, by the beginning of their names: the parent first, then the children by seed."""
    return [f"{run.info.run_name.partition(' · ')[0]} {run.info.status}" for run in visible(place)]


def visible(place: Path) -> list[Any]:
    client = open_client(f"sqlite:///{place}/results/mlflow.db")
    experiment = client.get_experiment_by_name("pyramid")
    assert experiment is not None
    found: list[Any] = client.search_runs([experiment.experiment_id])
    return sorted(found, key=lambda run: str(run.info.run_name))


def sync(place: Path, capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    capsys.readouterr()
    code = run(place, "dashboard", "--sync", *(arguments or ("out",)))
    said = capsys.readouterr()
    return code, said.out, said.err


def change(place: Path, seed: int, **values: object) -> None:
    file = place / f"out/seed={seed}/result.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | values))


FINISHED = ["pyramid rdm FINISHED", *(f"seed {seed} FINISHED" for seed in range(3))]


def test_what_is_missing_is_pushed_once(place: Path, tracked: Path, capsys: pytest.CaptureFixture[str]) -> None:
    look = "to look at it: origami-lab dashboard\n"
    assert sync(place, capsys) == (0, f"out: 3 trials pushed\n{look}", "")
    assert statuses(place) == FINISHED
    ids = [run.info.run_id for run in visible(place)]
    assert sync(place, capsys) == (0, f"out: already there\n{look}", "")
    assert [run.info.run_id for run in visible(place)] == ids
    # as while the trials run
    for synced, live in zip(visible(place), visible(tracked), strict=True):
        synced.data.metrics.pop("seconds", None)
        live.data.metrics.pop("seconds", None)
        assert synced.data.metrics == live.data.metrics
        assert synced.data.params == live.data.params


def test_a_run_that_the_command_tracked_is_there_already(tracked: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = sync(tracked, capsys, ".")
    assert (code, out.splitlines()[0], err) == (0, "out: already there", "")
    assert statuses(tracked) == FINISHED


@pytest.mark.parametrize("call", ["create_run", "log_batch", "log_artifact", "set_terminated"])
def test_a_push_that_was_cut_off_leaves_nothing_twice(place: Path, call: str, monkeypatch: pytest.MonkeyPatch) -> None:
    uri = f"sqlite:///{place}/results/mlflow.db"
    runs = ExperimentRuns(place / "out", uri)
    whole = getattr(runs.client, call)
    calls = 0

    def lose_the_second_answer(*arguments: Any, **named: Any) -> Any:
        nonlocal calls
        calls += 1
        answer = whole(*arguments, **named)
        if calls == 2:
            raise ConnectionError("Connection refused")
        return answer

    monkeypatch.setattr(runs.client, call, lose_the_second_answer)
    with pytest.raises(StoreError, match="does not answer"):
        runs.push(live=True)
    assert calls == 2
    ExperimentRuns(place / "out", uri).push(live=False)
    assert statuses(place) == FINISHED


def test_failed_and_stopped_trials_have_one_child_each(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(place, 1, status="stopped")
    shutil.move(place / "out/seed=2", place / "kept")
    (place / "out/seed=2.error.txt").write_text("Traceback")
    rows = read_trials(place / "out/trials.csv")
    rows[2] = TrialRow.failed(2, "ValueError")
    (place / "out/trials.csv").write_text(format_trials(rows))
    assert sync(place, capsys)[0] == 0
    before = visible(place)
    assert statuses(place) == ["pyramid rdm KILLED", "seed 0 FINISHED", "seed 1 KILLED", "seed 2 FAILED"]
    assert "already there" in sync(place, capsys)[1]
    assert [run.info.run_id for run in visible(place)] == [run.info.run_id for run in before]
    assert before[0].data.metrics["trials_failed"] == 1
    # then they ran again
    change(place, 1, status="ok")
    shutil.move(place / "kept", place / "out/seed=2")
    assert "2 trials pushed" in sync(place, capsys)[1]
    assert statuses(place) == FINISHED
    assert visible(place)[0].data.metrics["trials_failed"] == 0
    assert visible(place)[0].info.run_id == before[0].info.run_id


def test_a_run_that_was_killed_is_marked_so(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.rmtree(place / "out/seed=2")
    (place / "out/summary.json").unlink()
    uri = f"sqlite:///{place}/results/mlflow.db"
    ExperimentRuns(place / "out", uri).push(live=True)
    assert statuses(place)[0] == "pyramid rdm RUNNING"
    assert "0 trials pushed" in sync(place, capsys)[1]
    assert statuses(place) == ["pyramid rdm KILLED", "seed 0 FINISHED", "seed 1 FINISHED"]


def test_one_folder_that_cannot_be_pushed_costs_the_others_nothing(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / "broken").mkdir()
    (place / "broken/config.yaml").write_text("{")
    (place / "broken/trials.csv").write_text("")
    shutil.copytree(place / "out", place / "elsewhere")
    (place / "elsewhere/tracking.json").write_text('{"key": "k", "uri": "http://127.0.0.1:9"}')
    code, out, err = sync(place, capsys, ".")
    assert code == 1
    assert "out: 3 trials pushed" in out
    lines = err.splitlines()
    assert len(lines) == 2
    assert lines[0].startswith("error: broken: configuration=broken/config.yaml: cannot be read")
    assert lines[1].startswith("error: elsewhere: the server http://127.0.0.1:9 ")
    # a store that is named wins, and is not noted in place of the run's own
    store = f"sqlite:///{place}/results/mlflow.db"
    assert "elsewhere: 3 trials pushed" in sync(place, capsys, "elsewhere", "--uri", store)[1]
    assert json.loads((place / "elsewhere/tracking.json").read_text())["uri"] == "http://127.0.0.1:9"


@pytest.mark.skipif(sys.platform == "win32", reason="no locks there")
def test_a_run_that_is_being_pushed_is_left_alone(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with held(place / "out", wait=False):
        assert sync(place, capsys)[:2] == (0, "out: left alone, another process runs or pushes it\n")


def test_run_folders_are_found_and_mlflow_s_copies_are_not(tmp_path: Path) -> None:
    artifacts = f"results/mlartifacts/pyramid/{'0123456789abcdef' * 2}/artifacts"
    for name in ("results/b/1", "results/a/1", artifacts):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "config.yaml").touch()
        (tmp_path / name / "trials.csv").touch()
    assert list(find_runs(tmp_path, "--sync")) == [tmp_path / "results/a/1", tmp_path / "results/b/1"]
    assert list(find_runs(tmp_path / "results/a/1", "--sync")) == [tmp_path / "results/a/1"]
    for name in ("results/mlartifacts", "nowhere"):
        with pytest.raises(InputError, match=r"--sync=.*no run folder"):
            list(find_runs(tmp_path / name, "--sync"))


def test_the_dashboard_serves_the_store_until_ctrl_c(tracked: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "origami_lab", "dashboard", str(tracked / "out"), "--port", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert process.stdout is not None
    try:
        said = [next(process.stdout), next(process.stdout)]
        assert f"; there is none in {tracked / 'out'}" in said[0]
        assert said[1].startswith(f"http://127.0.0.1:{port}/#/experiments/")  # the newest run's, in our view
        assert said[1].endswith("  (Ctrl-C ends it)\n")
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=60) as page:
            assert b"MLflow" in page.read()
        process.send_signal(signal.SIGINT)
        assert process.stdout.read() == ""
        assert process.wait(30) == 0
    finally:
        process.kill()
    with socket.socket() as probe, pytest.raises(ConnectionRefusedError):
        probe.connect(("127.0.0.1", port))
