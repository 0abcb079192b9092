"""The dashboard's first page: the view of ours in MLflow's own pages, descriptions, and the curve of a run."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks.dashboard import dashboard
from origami_lab.runs.trial_row import Spread
from origami_lab.tracking.descriptions import (
    Artifacts,
    experiment_note,
    plain,
    run_name,
    run_note,
    study_note,
    study_run_note,
    trial_note,
)
from origami_lab.tracking.experiment_runs import ExperimentRuns
from origami_lab.tracking.learning_curve import mean_curve
from origami_lab.tracking.mlflow_limits import LONGEST_TAG
from origami_lab.tracking.mlflow_server import newest_page
from origami_lab.tracking.shown_view import NOTE, TAG, address, experiment_view, study_view
from tests.drawing.test_viewer import CHROMIUM, FLAGS, in_chromium
from tests.small_runs import tracked, trial_row
from tests.tracking.stores_in_memory import Store, add_trial, begin_run, store

__all__ = ["store", "tracked"]


@in_chromium
@pytest.mark.slow
def test_mlflow_shows_the_view_of_ours(tracked: Path, tmp_path: Path) -> None:
    """In Chromium, as the table and as charts; where its key is unknown the plain list of runs."""
    assert CHROMIUM is not None
    with dashboard(f"sqlite:///{tracked / 'results/mlflow.db'}") as base:
        first = newest_page(base)
        experiment = re.findall(r"/#/experiments/(\d+)/runs", first)[0]
        assert first == address(experiment)
        pages = {
            first: ("return_mean", "return_std", "best_seed", "certificate", "pyramid rdm", "Runs of origami-lab"),
            address(experiment, charts=True): ("Learning curves", "mean_return_so_far"),
            f"/#/experiments/{experiment}/runs": ("pyramid rdm",),
        }
        for page, words in pages.items():
            for _ in range(6):  # on a busy machine its scripts may not have come to their end
                command = [CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path}/profile", "--window-size=1800,1200"]
                command += ["--virtual-time-budget=30000", "--dump-dom", base + page]
                dom = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False).stdout
                missing = [word for word in words if word not in dom]
                if not missing:
                    break
            assert not missing, page


def test_the_views_fit_into_a_tag_and_are_the_same_each_time() -> None:
    many = [f"search.parameter_{number}" for number in range(60)]
    for view in (experiment_view(), study_view(many)):
        assert len(view) <= min(LONGEST_TAG, 20_000)
        state = json.loads(view)
        sections = {section["uuid"] for section in state["compareRunSections"]}
        assert {card["metricSectionId"] for card in state["compareRunCharts"]} == sections
        assert set(state["selectedColumns"]) == set(state["columnOrder"])
    assert experiment_view() == experiment_view()


def test_a_run_is_named_by_what_differs_and_described(tmp_path: Path, store: Store) -> None:
    folder = tmp_path / "run"
    begin_run(folder, "0..1")
    runs = ExperimentRuns(folder, "http://store")
    for seed in range(2):
        add_trial(folder, seed)
        (folder / f"seed={seed}/folded.png").touch()
        runs.push(live=True, numbers={seed})
    assert store.tags[TAG] == experiment_view()
    assert store.tags[NOTE] == experiment_note("pyramid", "pyramid")
    summary = {"command": "origami-lab target=pyramid search=rdm seed=0..1 symmetry=y search.x=[1,2] output='a b'"}
    (folder / "summary.json").write_text(json.dumps(summary))
    store.tags[NOTE] = "mine"
    runs.push(live=False)
    [root] = [run for run in store.runs.values() if "mlflow.parentRunId" not in run.data.tags]
    assert root.info.run_name == "pyramid rdm · symmetry=y search.x=[1,2] · 2 seeds"
    note = root.data.tags[NOTE]
    assert "return −1.5 ± 0.7 over 2 trials; best −1.0000 (seed 0)" in note
    assert f"get-artifact?path=best%2Ffolded.png&run_uuid={root.info.run_id}" in note
    curve = [(step, value) for key, step, value in root.data.metrics if key == "mean_return_so_far"]
    # by hand: -1/(i+seed) at i = 1 and 8, of seeds 0 and 1
    assert curve[0] == (1, pytest.approx((-1 / 1 - 1 / 2) / 2))
    assert curve[-1] == (8, pytest.approx((-1 / 8 - 1 / 9) / 2))
    assert store.tags[NOTE] == "mine"
    notes = [run.data.tags[NOTE] for run in store.runs.values() if run is not root]
    assert sorted(note.splitlines()[0] for note in notes) == [
        "seed 0: return −1.0000, ok",
        "seed 1: return −2.0000, ok",
    ]


@pytest.mark.parametrize(
    ("command", "seeds", "name"),
    [
        ("origami-lab target=bowl search=bfts seed=0..9", 10, "bowl bfts · 10 seeds"),
        ("origami-lab -m target=bowl budget=5 output=x workers=2", 1, "bowl bfts · budget=5"),
        ("origami-lab +experiment=paper/bowl tracking.uri=x", 2, "bowl bfts · experiment=paper/bowl · 2 seeds"),
        ("origami-lab 'unended", 1, "bowl bfts"),
        ("", 1, "bowl bfts"),
    ],
)
def test_names_of_runs(command: str, seeds: int, name: str) -> None:
    assert run_name("bowl", "bfts", command, seeds) == name


def test_names_of_strangers_are_no_markup() -> None:
    nasty = "<b>[x](http://a) `c` *d*\n# e"
    for text in (
        experiment_note(nasty, "1"),
        study_note(nasty, "1"),
        study_run_note(nasty, {}),
        run_note(nasty, Spread(-1.0, None, 1), None, {}, Artifacts("1", "2"), []),
        trial_note(trial_row(0, None, f"failed: {nasty}"), Artifacts("1", "2"), []),
    ):
        assert plain(nasty) in text
        assert not re.search(r"(?<!\\)[<]", text)
        assert "](http" not in text
        assert "\n# e" not in text


def test_the_mean_curve_is_that_of_steps(tmp_path: Path) -> None:
    texts = ["interactions,return\n2,-4\n10,-2\n100,-2\n", "interactions,return\n5,-3\n50,-1\n100,-1\n"]
    files = [tmp_path / f"{number}.csv" for number in range(2)]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    curve = dict(mean_curve(files))
    assert (min(curve), max(curve)) == (5, 100)
    expected: Any = {step: (-4 if step < 10 else -2) / 2 + (-3 if step < 50 else -1) / 2 for step in curve}
    assert curve == pytest.approx(expected)
    assert len(curve) > 10
    assert mean_curve([*files, tmp_path / "none.csv"]) == []
    assert mean_curve([]) == []
