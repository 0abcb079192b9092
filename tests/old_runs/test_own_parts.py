"""Runs of version 0.1.0 with a user's own objective, target and searcher: the parts of its documentation."""

from __future__ import annotations

from pathlib import Path

import pytest

import origami_lab
from tests.old_runs.conftest import actions, assert_found, command, recorded, unpack
from tests.old_runs.make_fixtures import COMMANDS, QUICK


def test_own_objective_and_searcher_run_again(here: Path) -> None:
    """Neither imports what has moved."""
    unpack(here, "own")
    rows = recorded(here / "own/trials.csv")
    assert command("own/config.yaml", "output=again") == 0
    assert_found(here / "again", rows, [0])
    assert actions(here / "again/seed=0")["actions"] == actions(here / "own/seed=0")["actions"]
    assert command(*COMMANDS["own"], *QUICK, "seed=0", "output=own", "resume=true") == 0
    assert_found(here / "own", rows, [0])


GAME, OBJECTIVES, TARGETS = "origami_lab.game.folded", "origami_lab.objectives.base", "origami_lab.objectives.targets"
MOVED = {
    "tower": ("tower.py", {GAME: "origami_lab.game", OBJECTIVES: "origami_lab.objectives"}),
    "saddle": ("saddle.py", {TARGETS: "origami_lab.targets"}),
}
"""Parts that import old paths: their file, and the paths with the packages that have their names now."""


@pytest.mark.parametrize("name", MOVED)
@pytest.mark.parametrize("again", [True, False], ids=["config", "command"])
def test_own_part_with_an_old_import_is_told_the_new_name(
    here: Path, name: str, again: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    unpack(here, name)
    file, moves = MOVED[name]
    words = [f"{name}/config.yaml"] if again else [*COMMANDS[name], *QUICK]
    assert command(*words, "seed=0", "output=again") == 2
    [line] = capfd.readouterr().err.splitlines()
    assert any(old in line and new in line.replace(old, "") for old, new in moves.items())
    assert file in line
    assert not (here / "again").exists()


@pytest.mark.parametrize("name", MOVED)
def test_what_it_found_is_there_all_the_same(here: Path, name: str) -> None:
    """Its rows, its design, and an export need no import of its parts."""
    unpack(here, name)
    (here / MOVED[name][0]).unlink()
    rows = recorded(here / name / "trials.csv")
    assert_found(here / name, rows, [0])
    assert len(origami_lab.load(name).best.vertices) == int(rows[0]["vertices"])
    assert command("export", f"{name}/seed=0", "--to", "svg") == 0
