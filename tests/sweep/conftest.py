"""Sweeps of seconds."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import optuna
import yaml
from optuna.trial import FrozenTrial, TrialState

from origami_lab.sweep.play_trials import Player
from origami_lab.sweep.storage import JournalFile, open_storage
from origami_lab.sweep.studies import SearchJob
from origami_lab.sweep.sweep_config import Declaration, read_declaration
from origami_lab.sweep.trial_queue import Slot
from origami_lab.sweep.worker_identity import Worker

ROOT = Path(__file__).parents[2]

SMALL: dict[str, Any] = {
    "task": ["target=pyramid"],
    "searcher": "evo",
    "budget": 300,
    "seeds": "0..1",
    "trials": 5,
    "space": {
        "search.population": {"low": 6, "high": 24, "log": True},
        "search.rescale": {"choices": [True, False]},
        "search.sigma_1": {"low": 0.01, "high": 1.0, "log": True, "when": {"search.rescale": True}},
    },
    "sampler": {"name": "random", "seed": 3},
    "pruner": "none",
    "held_out": {"seeds": "50..52"},
    "tracking": "none",
}


def declare(folder: Path, **changes: Any) -> Declaration:
    """The small sweep with other values, its file in a folder."""
    return read_declaration(write_file(folder, **changes))


def write_file(folder: Path, **changes: Any) -> Path:
    file = folder / "small.yaml"
    file.write_text(yaml.safe_dump({**SMALL, "output": str(folder / "out"), **changes}, sort_keys=False))
    return file


def play_here(declaration: Declaration, stop_after: int = 10**9) -> list[Slot]:
    """Play the trials in this process, or so many seeds of them."""
    limit = seeds_in(declaration.folder) + stop_after
    job = SearchJob(declaration)
    queue = job.queue(open_storage(declaration), Worker.this())
    Player(lambda: seeds_in(declaration.folder) >= limit).work(job, queue)
    return queue.look()


def seeds_in(folder: Path) -> int:
    """How many seeds were played to their ends."""
    files = folder.glob("trials/*/seed=*/result.json")
    return sum(json.loads(file.read_text())["status"] == "ok" for file in files)


def values(slots: list[Slot]) -> list[tuple[str, Any, Any]]:
    """What each slot found: its state, its parameters, and its value, to the last bit."""
    return [(p.state, p.trial.params, p.trial.value) for p in slots if p.trial is not None]


def trials_in(journal: Path) -> list[FrozenTrial]:
    """All of Optuna's trials of the small study, read anew."""
    storage = optuna.storages.JournalStorage(JournalFile(str(journal)))
    return trials_of(storage)


def trials_of(storage: optuna.storages.BaseStorage) -> list[FrozenTrial]:
    studies = [study for study in storage.get_all_studies() if study.study_name == "small"]
    return storage.get_all_trials(studies[0]._study_id) if studies else []


def running_workers(trials: list[FrozenTrial]) -> list[int]:
    """Process numbers of those who play now."""
    running = [trial for trial in trials if trial.state == TrialState.RUNNING and "lease" in trial.user_attrs]
    return [trial.user_attrs["lease"]["worker"]["pid"] for trial in running]


def start_command(folder: Path, *arguments: str, **environment: str) -> subprocess.Popen[str]:
    """`origami-lab sweep` in a process of its own, which leads a group."""
    return subprocess.Popen(
        [sys.executable, "-m", "origami_lab", "sweep", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


def wait_for(what: Any, seconds: float = 120.0) -> Any:
    """The first true answer of a function; fails if there is none in time."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if answer := what():
            return answer
        time.sleep(0.02)
    raise AssertionError("nothing happened in time")
