"""Runs of version 0.1.0 in reports: each in one group with the run that the same command makes today."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml  # type: ignore[import-untyped]

from origami_lab.config.compose import compose_settings, working_directory_importable
from tests.old_runs.conftest import command, recorded_trial, unpack
from tests.old_runs.make_fixtures import COMMANDS, PYRAMID, QUICK

LATER = 100
"""What is added to a seed to make another one of it."""


def cells(report: Path) -> dict[tuple[str, str], tuple[int, float]]:
    """The table of returns, by row and column: the number of trials and their mean."""
    with (report / "returns.csv").open(newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["table"] == "returns" and row["mean"]]
    return {(row["row"], row["column"]): (int(row["trials"]), float(row["mean"])) for row in rows}


def test_old_and_new_trials_are_one_group(here: Path) -> None:
    unpack(here, "killed")
    assert command(*PYRAMID, *QUICK, "straight_sectors=false", "seed=7", "output=new") == 0
    assert command("report", ".", "--output", "report") == 0
    folders = [*(here / "killed").glob("seed=*"), here / "new/seed=7"]
    returns = [recorded_trial(folder)["return"] for folder in folders]
    assert cells(here / "report") == {("bfts", "pyramid"): (3, pytest.approx(sum(returns) / 3, abs=1e-9))}


def test_every_old_name_is_the_new_one(here: Path) -> None:
    """Beside each old run lies the same with other seeds, under the configuration that its command composes today.

    If an old name did not count as the new one, the two would be two groups.
    """
    evolution = ("search.population=24", "search.rescale=true")
    commands = dict(COMMANDS)
    commands |= {f"jobs/{job}": (f"objective={job}", "search=rdm", "budget=12000") for job in ("bucket", "packaging")}
    # whose rules are others today
    commands["part"] += ("target.translate=[0,0,0]", "objective.distance=vertex", "target_return=null")
    commands["jobs/bucket"] += ("objective.norm_of=leaves",)
    commands |= {"sweep/trials/0000": ("objective=table", "search=evo", "budget=1000", *evolution)}
    unpack(here, "killed", "jobs", "sweep", *COMMANDS)
    for name, words in commands.items():
        old, new = here / "old" / name, here / "new" / name
        shutil.copytree(here / name, old)
        for file in [*old.glob("seed=*/best.fold"), *old.glob("seed=*/curve.csv")]:
            file.unlink()  # to draw all of them would take most of the time
        shutil.copytree(old, new)
        change_seeds(new)
        words = tuple(word.replace(".path=", f".path={here}/") for word in words)  # as a run notes it
        folder = here / words[1] if words[0] == "--config-dir" else None
        overrides = [*words[2 if folder else 0 :], *QUICK, "straight_sectors=false", f"seed={LATER}"]
        with working_directory_importable():
            today = compose_settings(overrides, folder).config
        (new / "config.yaml").write_text(yaml.safe_dump(dict(today)), encoding="utf-8")

    assert command("report", "old", "new", "--output", "report") == 0
    runs = [[recorded_trial(trial)["return"] for trial in (here / name).glob("seed=*")] for name in commands]
    expected = sorted((2 * len(returns), sum(returns) / len(returns)) for returns in runs)
    np.testing.assert_allclose(sorted(cells(here / "report").values()), expected, rtol=0, atol=1e-9)


def change_seeds(run: Path) -> None:
    """Let the trials of a run folder be those of other seeds."""
    for trial in list(run.glob("seed=*")):
        row = recorded_trial(trial)
        row["seed"] += LATER
        (trial / "result.json").write_text(json.dumps(row), encoding="utf-8")
        trial.rename(run / f"seed={row['seed']}")
    table = run / "trials.csv"
    if table.is_file():
        text = re.sub(r"^(\d+),", lambda found: f"{int(found[1]) + LATER},", table.read_text(), flags=re.MULTILINE)
        table.write_text(text, encoding="utf-8")
