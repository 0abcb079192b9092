"""A sweep and a multirun of version 0.1.0 that were killed: the same commands finish them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.old_runs.conftest import actions, assert_found, command, recorded, recorded_trial, unpack
from tests.old_runs.make_fixtures import JOBS, QUICK


def trials_of(record: Path) -> list[tuple[Any, ...]]:
    """What a study's record says of each trial that ended: its number, state and parameters, and its returns."""
    ended = json.loads(record.read_text(encoding="utf-8"))["ended"]
    return [(one["trial"], one["state"], one["point"], [*one["returns"].values(), one["value"]]) for one in ended]


def test_killed_sweep_is_finished(here: Path) -> None:
    unpack(here, "sweep")
    played = sorted((here / "sweep/trials").glob("*/seed=*/result.json"))
    assert len(played) == 5
    before = [file.read_bytes() for file in played]
    assert command("sweep", "small.yaml", "output=sweep") == 0
    found, expected = trials_of(here / "sweep/study.json"), trials_of(here / "expected/sweep.json")
    assert [trial[:3] for trial in found] == [trial[:3] for trial in expected]
    np.testing.assert_allclose([trial[3] for trial in found], [trial[3] for trial in expected], rtol=0, atol=1e-9)
    assert len(found) == 4
    assert [file.read_bytes() for file in played] == before
    assert "table" in (here / "sweep/summary.md").read_text(encoding="utf-8")


def test_trial_of_a_sweep_runs_again(here: Path) -> None:
    unpack(here, "sweep")
    assert command("sweep/trials/0001/config.yaml", "output=again") == 0
    assert_found(here / "again", recorded(here / "sweep/trials/0001/trials.csv"), [0, 1])


def test_killed_multirun_is_finished(here: Path) -> None:
    """Each job keeps its folder, what was found stays, what is missing runs."""
    unpack(here, "jobs")
    index = json.loads((here / "jobs/multirun.json").read_text(encoding="utf-8"))
    found = [recorded_trial(here / "jobs" / trial) for trial in ("bucket/seed=0", "bucket/seed=1", "packaging/seed=0")]
    assert command(*JOBS, *QUICK, "output=jobs", "resume=true") == 0
    for job in ("bucket", "packaging"):
        assert_found(here / "jobs" / job, recorded(here / f"expected/jobs-{job}.csv"), [0, 1])
    after = [recorded_trial(here / "jobs" / trial) for trial in ("bucket/seed=0", "bucket/seed=1", "packaging/seed=0")]
    assert after == found
    now = json.loads((here / "jobs/multirun.json").read_text(encoding="utf-8"))
    assert now["id"] == index["id"]
    assert [job["folder"] for job in now["jobs"]] == ["bucket", "packaging"]
    table = (here / "jobs/multirun.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == 3
    assert all(",ok,2,2," in line for line in table[1:])


def test_job_of_a_multirun_runs_again(here: Path) -> None:
    unpack(here, "jobs")
    assert command("jobs/packaging/config.yaml", "seed=0", "output=again") == 0
    assert_found(here / "again", {0: recorded_trial(here / "jobs/packaging/seed=0")}, [0])
    assert actions(here / "again/seed=0")["actions"] == actions(here / "jobs/packaging/seed=0")["actions"]


def test_job_of_a_multirun_resumes_by_itself(here: Path) -> None:
    unpack(here, "jobs")
    assert command("jobs/bucket/config.yaml", "output=jobs/bucket", "resume=true") == 0
    assert_found(here / "jobs/bucket", recorded(here / "jobs/bucket/trials.csv"), [0, 1])


def test_old_config_runs_as_a_multirun(here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Hydra's callback that checks all jobs before the first one starts is found."""
    unpack(here, "jobs")
    assert command("jobs/bucket/config.yaml", "-m", "seed=0,1", "budget=10,-1", "output=grid") == 2
    [line] = capfd.readouterr().err.splitlines()
    assert "budget=-1" in line
    assert not (here / "grid").exists()
