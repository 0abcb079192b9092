"""A worker begins before its experiment is known, and makes the parts: the parent needs no game."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import build_parts
from origami_lab.errors import InputError
from origami_lab.experiment.checked_parts import look_at
from origami_lab.experiment.runner import run_experiment
from origami_lab.experiment.trial_pool import TrialPool
from origami_lab.experiment.trial_process import early_process
from origami_lab.runs.trial_row import read_trials

WORDS = ["target=pyramid", "search=rdm", "budget=20", "seed=0", "tracking=none", "files=designs", "verbosity=quiet"]
PARENT = """
import sys
from origami_lab.cli import main
from origami_lab.experiment.trial_process import TrialProcess

give = TrialProcess.give

def watched(self, task):
    print("numba" in sys.modules, "origami_lab.game.game" in sys.modules, "trimesh" in sys.modules)
    give(self, task)

TrialProcess.give = watched
main(sys.argv[1:])
"""


def test_the_parent_imports_no_kernels(tmp_path: Path) -> None:
    """They took it as long as its worker, on the way to the first interaction."""
    said = subprocess.run(
        [sys.executable, "-c", PARENT, *WORDS], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert said.stdout.split()[:3] == ["False"] * 3


def test_a_worker_that_nobody_needs_ends() -> None:
    with early_process() as early:
        assert early.process.is_alive()
    assert not early.process.is_alive()


@pytest.mark.parametrize("words", [["target=pyramid"], ["objective=chair"], ["target=cube", "start.size=choose"]])
def test_the_first_worker_tells_of_its_parts_what_the_parent_would_find(words: list[str]) -> None:
    settings = compose_settings([*WORDS, *words])
    own = look_at(settings, build_parts(settings))
    with TrialPool(settings) as pool:
        told = pool.checked_parts()
    assert told is not None
    assert (told.start, told.remarks) == (own.start, own.remarks)
    assert (told.target is None) == (own.target is None)
    if told.target is not None and own.target is not None:
        assert (told.target.vertices == own.target.vertices).all()
        assert (told.target.faces == own.target.faces).all()


def test_a_run_goes_on_without_the_worker_that_died_early(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    settings = compose_settings([*WORDS, "output=run"])
    with early_process() as early:
        early.kill()
        early.process.join()
        experiment = run_experiment(settings, Console(stderr=True), early=early)
    assert [row.seed for row in experiment.rows] == [0]
    assert experiment.exit_code == 0


def test_what_the_worker_cannot_make_the_parent_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    settings = compose_settings([*WORDS, "start.size=99", "output=run"])
    with pytest.raises(InputError, match="half-width"):
        run_experiment(settings, Console(stderr=True))
    assert not Path("run").exists()


def test_the_table_has_all_trials_however_seldom_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("origami_lab.experiment.runner.TABLE_SECONDS", 1e9)
    run_experiment(compose_settings([*WORDS, "seed=0..3", "output=run"]), Console(stderr=True))
    assert [row.seed for row in read_trials(Path("run/trials.csv"))] == [0, 1, 2, 3]
