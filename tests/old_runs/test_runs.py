"""Single runs of version 0.1.0: run again, finished, extended, loaded, replayed, and gone on from."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import origami_lab
from tests.old_runs.conftest import actions, assert_found, command, recorded, recorded_trial, unpack
from tests.old_runs.make_fixtures import COMMANDS, PYRAMID, QUICK

SINGLE = ("cube", "bowl", "face", "part", "shelf", "chair", "onward", "ppo")
"""Runs of one seed without parts of the user's own."""


def needs(name: str) -> None:
    if name == "ppo":
        pytest.importorskip("sb3_contrib")


@pytest.mark.parametrize("name", SINGLE)
def test_config_runs_again(here: Path, name: str) -> None:
    needs(name)
    unpack(here, name, "killed")
    assert command(f"{name}/config.yaml", "output=again") == 0
    assert_found(here / "again", recorded(here / name / "trials.csv"), [0])
    for key in ("actions", "angle", "moves"):
        assert actions(here / "again/seed=0")[key] == actions(here / name / "seed=0")[key]


@pytest.mark.parametrize("name", SINGLE)
def test_the_same_command_resumes(here: Path, name: str) -> None:
    """What the command composes today is what the folder's configuration, target and start pattern say."""
    needs(name)
    unpack(here, name, "killed")
    before = (here / name / "seed=0/result.json").read_bytes()
    assert command(*COMMANDS[name], *QUICK, "seed=0", f"output={name}", "resume=true") == 0
    assert_found(here / name, recorded(here / name / "trials.csv"), [0])
    assert (here / name / "seed=0/result.json").read_bytes() == before


@pytest.mark.parametrize("name", SINGLE)
def test_other_settings_are_still_refused(here: Path, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    needs(name)
    unpack(here, name, "killed")
    words = (*COMMANDS[name], *QUICK, "seed=0", f"output={name}", "resume=true", "stuck=penalise")
    assert command(*words) == 2
    [line] = capfd.readouterr().err.splitlines()
    assert "stuck was score, is penalise" in line
    assert "_target_" not in line


def test_killed_run_is_finished_and_extended(here: Path) -> None:
    unpack(here, "killed")
    expected = recorded(here / "expected/killed.csv")
    old = {seed: recorded_trial(here / f"killed/seed={seed}") for seed in (0, 1)}
    assert command(*PYRAMID, *QUICK, "seed=0..3", "output=killed", "resume=true") == 0
    assert_found(here / "killed", expected, range(4))
    assert {seed: recorded_trial(here / f"killed/seed={seed}") for seed in (0, 1)} == old  # seconds, too: not run again

    assert command("killed/config.yaml", "seed=0..4", "output=killed", "resume=true") == 0
    assert_found(here / "killed", expected, range(5))


@pytest.mark.parametrize("name", ["part", "onward"])
def test_extended_by_a_seed_whose_files_are_compared(here: Path, name: str) -> None:
    """target.ply and start.json are what they were; the new trial's game can be replayed."""
    unpack(here, name, "killed")
    kept = {file: (here / name / file).read_bytes() for file in ("target.ply", "seed=0/actions.json")}
    assert command(f"{name}/config.yaml", "seed=0..1", f"output={name}", "resume=true") == 0
    result = origami_lab.load(name)
    assert list(result.trials["status"]) == ["ok", "ok"]
    assert {file: (here / name / file).read_bytes() for file in kept} == kept
    assert len(result.designs[1].vertices) == result.trials.loc[1, "vertices"]


@pytest.mark.parametrize("name", [*SINGLE, "own", "tower", "saddle", "killed", "pushed"])
def test_load_replays_the_designs(here: Path, name: str) -> None:
    """The vertices that the replayed actions fold are those in best.fold."""
    unpack(here, name)
    result = origami_lab.load(name)
    rows = {int(file.name.partition("=")[2]): recorded_trial(file) for file in (here / name).glob("seed=*")}
    assert_found(here / name, rows, rows)
    for seed, row in rows.items():
        design, fold = result.designs[seed], json.loads((here / name / f"seed={seed}/best.fold").read_text())
        np.testing.assert_array_equal(design.vertices, np.array(fold["vertices_coords"])[:, :2])
        np.testing.assert_allclose(
            design.folded[design.best], fold["file_frames"][-1]["vertices_coords"], rtol=0, atol=1e-9
        )
        assert np.degrees(design.driving_angles[design.best]) == pytest.approx(row["driving_angle"], abs=1e-9)
    returns = [row["return"] for row in rows.values()]
    assert result.best.metadata["return"] == pytest.approx(max(returns), abs=1e-9)


REPLAY = '''
import json


class Replay:
    """Plays the actions of a saved trial, and nothing else."""

    def __init__(self, actions, **others):
        self.actions = actions

    def search(self, problem, rng):
        positions = problem.new_positions(1)
        problem.clear(positions, 0)
        for action in self.actions:
            problem.play(positions, 0, action)
        problem.finish(positions, 0)
'''


@pytest.mark.parametrize("name", ["cube", "shelf"])
def test_saved_actions_have_their_return(here: Path, name: str) -> None:
    unpack(here, name)
    (here / "replay.py").write_text(REPLAY)
    saved = actions(here / name / "seed=0")
    search = ("search._target_=replay.Replay", f"+search.actions={saved['actions']}".replace(" ", ""))
    budget = f"budget={len(saved['actions'])}"
    assert command(f"{name}/config.yaml", *search, budget, "output=replayed") == 0
    row = origami_lab.load("replayed").trials.loc[0]
    assert row["return"] == pytest.approx(saved["return"], rel=0, abs=1e-9)
    assert row["driving_angle"] == pytest.approx(saved["driving_angle"], rel=0, abs=1e-9)


def test_old_runs_start_others(here: Path) -> None:
    """A search goes on from a design that went on from another one: its moves come first."""
    unpack(here, "onward")
    start = ("start=file", "start.path=onward/seed=0")
    assert command("target=pyramid", *start, "search=rdm", "budget=300", *QUICK, "output=further") == 0
    old, new = actions(here / "onward/seed=0"), actions(here / "further/seed=0")
    moves = [move for move in old["moves"] if move["kind"] != "terminate"]
    assert new["moves"][: len(moves)] == moves
    assert new["game"]["start"]["moves"] == moves
