"""Pushes of run folders and studies: as much work for the last trial as for the first, and nothing missing or twice."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from origami_lab.config.settings import Settings
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import TrialRow
from origami_lab.sweep import study_runs
from origami_lab.sweep.study_runs import StudyRuns
from origami_lab.tracking import experiment_runs, mlflow_log
from origami_lab.tracking.experiment_runs import ExperimentRuns
from origami_lab.tracking.mlflow_log import MlflowLog
from origami_lab.tracking.store import RefusedError, StoreError
from tests.tracking.stores_in_memory import Store, add_trial, begin_run, store, write_study

__all__ = ["store"]

URI = "http://store"
TRIALS = 8

_opened: list[str] | None = None


def _note_opening(event: str, arguments: tuple[Any, ...]) -> None:
    if _opened is not None and event in ("open", "os.scandir", "os.listdir") and isinstance(arguments[0], str):
        _opened.append(arguments[0])


sys.addaudithook(_note_opening)


@contextmanager
def openings(folder: Path) -> Iterator[list[str]]:
    """The files and folders inside a folder that this process opens meanwhile."""
    global _opened
    found: list[str] = []
    _opened = []
    try:
        yield found
    finally:
        found += [name for name in _opened if Path(name).is_relative_to(folder)]
        _opened = None


def test_the_last_trial_of_a_run_costs_as_much_as_the_first(tmp_path: Path, store: Store) -> None:
    folder = tmp_path / "run"
    begin_run(folder, "0..29")
    runs = ExperimentRuns(folder, URI)
    assert runs.push(live=True) == 0
    costs = []
    for seed in range(30):
        add_trial(folder, seed)
        store.requests.clear()
        with openings(folder) as opened:
            assert runs.push(live=True, numbers={seed}) == 1
        assert {Path(name).parent.name for name in opened} <= {f"seed={seed}", folder.name}
        costs.append((len(opened), *store.requests))
    assert len(set(costs)) == 1
    # and what nobody was told of, or asks for again, is there all the same in the end
    assert runs.push(live=False) == 0
    assert runs.push(live=False) == -1


def test_the_last_trial_of_a_study_costs_as_much_as_the_first(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "study"
    write_study(folder, 0, 30)
    runs = StudyRuns(folder, URI)
    assert runs.push(live=True) == 0
    digested: list[object] = []
    whole = mlflow_log.digest

    def counted(content: Mapping[Any, Any]) -> str:
        digested.append(content)
        return whole(content)

    monkeypatch.setattr(study_runs, "digest", counted)
    costs: dict[str, set[Any]] = {"complete": set(), "pruned": set(), "failed": set()}
    for number in range(30):
        write_study(folder, number + 1, 30)
        store.requests.clear()
        digested.clear()
        with openings(folder) as opened:
            assert runs.push(live=True, numbers={number}) == 1
        costs[list(costs)[number % 3]].add((len(opened), len(digested), *store.requests))
    assert [len(found) for found in costs.values()] == [1, 1, 1]
    assert runs.push(live=False) == 0
    assert runs.push(live=False) == -1


def test_settings_are_checked_once_and_again_when_they_change(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, read = tmp_path / "run", list[Path]()
    whole = experiment_runs.read_run

    def counted(folder: Path) -> Settings:
        read.append(folder)
        return whole(folder)

    monkeypatch.setattr(experiment_runs, "read_run", counted)
    begin_run(folder, "0..1")
    runs = ExperimentRuns(folder, URI)
    for seed in range(2):
        add_trial(folder, seed)
        runs.push(live=True, numbers={seed})
    assert len(read) == 1
    # a resumed run has one seed more
    config = folder / "config.yaml"
    config.write_text(config.read_text().replace("0..1", "0..2"))
    add_trial(folder, 2)
    runs.push(live=False)
    assert len(read) == 2
    (parent,) = [run for run in store.runs.values() if "mlflow.parentRunId" not in run.data.tags]
    assert parent.info.status == "FINISHED"


def test_a_trial_that_failed_is_found_in_the_table(tmp_path: Path, store: Store) -> None:
    folder = tmp_path / "run"
    begin_run(folder, "0..2")
    runs = ExperimentRuns(folder, URI)
    runs.push(live=True)
    add_trial(folder, 0)
    rows = RunFolder(folder).known_rows() | {1: TrialRow.failed(1, "the worker process died (exit code 1)")}
    RunFolder(folder).write_trials(rows.values())
    assert runs.push(live=True, numbers={1}) == 1
    assert [run.info.status for run in store.runs.values() if run.info.run_name == "seed 1"] == ["FAILED"]
    assert runs.push(live=True, numbers={0, 1}) == 1


def test_after_a_failure_all_trials_are_looked_at(tmp_path: Path, store: Store) -> None:
    folder = tmp_path / "run"
    begin_run(folder, "0..2")
    runs = ExperimentRuns(folder, URI)
    add_trial(folder, 0)
    fold = folder / "seed=0/best.fold"
    fold.rename(folder / "kept")
    add_trial(folder, 1)
    with pytest.raises(RefusedError, match=r"seed 0 could not be added: .*FileNotFoundError"):
        runs.push(live=True)
    (folder / "kept").rename(fold)
    add_trial(folder, 2)
    assert runs.push(live=True, numbers={2}) == 2
    assert sorted(run.info.run_name for run in store.runs.values()) == ["pyramid rdm", "seed 0", "seed 1", "seed 2"]


def push_run(folder: Path) -> Iterator[None]:
    """Push a run as its trials end, trial by trial; stops after each push."""
    runs: MlflowLog | None = None
    for seed in range(3):
        if not (folder / f"seed={seed}").exists():
            add_trial(folder, seed)
        runs = runs or ExperimentRuns(folder, URI)
        runs.push(live=True, numbers={seed})
        yield
    assert runs is not None
    runs.push(live=False)


def push_study(folder: Path) -> Iterator[None]:
    runs: MlflowLog | None = None
    for number in range(3):
        write_study(folder, number + 1, 3)
        runs = runs or StudyRuns(folder, URI)
        runs.push(live=True, numbers={number})
        yield
    assert runs is not None
    runs.push(live=False)


def begin(kind: type[MlflowLog], folder: Path) -> Callable[[Path], Iterator[None]]:
    if kind is StudyRuns:
        return push_study
    begin_run(folder, "0..2")
    return push_run


@pytest.mark.parametrize("kind", [ExperimentRuns, StudyRuns])
@pytest.mark.parametrize("answer_lost", [False, True])
def test_wherever_a_push_was_cut_off_nothing_is_missing_and_nothing_twice(
    kind: type[MlflowLog], answer_lost: bool, tmp_path: Path, store: Store
) -> None:
    folder = tmp_path / "folder"
    push = begin(kind, folder)
    for _ in push(folder):
        pass
    whole, requests = store.contents(), len(store.requests)
    assert len({name for name, *_ in whole}) == len(whole)
    assert {status for _, _, status, *_ in whole} <= {"FINISHED", "KILLED", "FAILED"}
    for broken in range(requests):
        store.runs.clear()
        store.tags.clear()
        store.requests.clear()
        store.break_at, store.answer_lost = broken, answer_lost
        shutil.rmtree(folder)
        push = begin(kind, folder)
        with pytest.raises(StoreError):
            for _ in push(folder):
                pass
        # all trials end without another push, and the run is pushed anew
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(kind, "push", lambda *arguments, **named: 0)
            for _ in push(folder):
                pass
        kind(folder, URI).push(live=False)
        assert store.contents() == whole, f"request {broken}"


def test_a_log_that_failed_goes_on_by_itself(tmp_path: Path, store: Store) -> None:
    """The same object, told of the later trials only, as the process that pushes may be."""
    folder = tmp_path / "run"
    begin_run(folder, "0..2")
    runs = ExperimentRuns(folder, URI)
    for seed in range(3):
        add_trial(folder, seed)
        store.break_at = len(store.requests) + 3 if seed < 2 else None
        if seed < 2:
            with pytest.raises(StoreError):
                runs.push(live=True, numbers={seed})
        else:
            assert runs.push(live=True, numbers={seed}) >= 2
    names = [run.info.run_name for run in store.runs.values()]
    assert sorted(names) == ["pyramid rdm", "seed 0", "seed 1", "seed 2"]


def test_a_polished_design_is_logged_beside_the_search_s_own(tmp_path: Path, store: Store) -> None:
    """The best polished one is of another trial; what was pushed before the polish is made anew."""
    folder = tmp_path / "run"
    begin_run(folder, "0..1")
    for seed in range(2):
        add_trial(folder, seed)
    runs = ExperimentRuns(folder, URI)
    runs.push(live=False)
    run = RunFolder(folder)
    for seed, value in enumerate((-0.9, -0.4)):
        row = replace(run.rows()[seed], polish="ok", polished_return=value, polished_certificate="certified")
        row.write(run.trial(seed) / "result.json")
        (run.trial(seed) / "polished.fold").write_text("{}")
    assert ExperimentRuns(folder, URI).push(live=False) == 2
    assert len(store.runs) == 3
    found = {run.info.run_name: run.data for run in store.runs.values()}
    for seed, value in enumerate((-0.9, -0.4)):
        child = found[f"seed {seed}"]
        metrics = {(name, value) for name, _, value in child.metrics}
        assert {("return", -1.0 - seed), ("polished_return", value)} <= metrics
        assert (child.tags["polish"], child.tags["polished_certificate"]) == ("ok", "certified")
        assert "/polished.fold" in child.files
    [parent] = [run for name, run in found.items() if name.startswith("pyramid rdm")]
    metrics = {(name, value) for name, _, value in parent.metrics}
    assert {("best_seed", 0.0), ("best_polished_seed", 1.0), ("best_polished_return", -0.4)} <= metrics
    assert dict(metrics)["polished_return_mean"] == pytest.approx(-0.65)
    assert "best_polished/polished.fold" in parent.files
