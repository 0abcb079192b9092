"""Runs that version 0.1.0 made, unpacked anew for each test."""

from __future__ import annotations

import csv
import json
import math
import platform
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import origami_lab
from origami_lab.cli import main
from origami_lab.runs.trial_row import NOT_CHECKED

FIXTURES = Path(__file__).parent / "fixtures"
ROOT = Path(__file__).parents[2]
PARTS = ("options", "part.stl", "height.py", "climb.py", "tower.py", "saddle.py", "small.yaml", "expected")
"""What lies beside the runs in their working directory."""
TIMINGS = ("seconds", "interactions_per_second")


def unpack(here: Path, *names: str) -> None:
    """Copy fixtures to a folder and say in them that this is where, and on what machine, they were made."""
    for name in (*PARTS, *names):
        copy = shutil.copytree if (FIXTURES / name).is_dir() else shutil.copyfile
        copy(FIXTURES / name, here / name)
    placeholders = {"/HERE": here.as_posix(), "/PROJECT": ROOT.as_posix(), "@HOST@": _this_host()}
    for file in here.rglob("*"):
        if file.suffix in (".yaml", ".json", ".journal", ".sql"):
            text = file.read_text(encoding="utf-8")
            for placeholder, meant in placeholders.items():
                text = text.replace(placeholder, meant)
            file.write_text(text, encoding="utf-8")


def _this_host() -> str:
    """As a sweep's leases name a machine: workers that died on this one are missed at once, on others in a minute."""
    try:
        space = Path("/proc/self/ns/pid").readlink()
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return platform.node()
    return f"{platform.node()} {boot[:8]} {space}"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def command(*arguments: str) -> int:
    """The exit code of `origami-lab ...` in the working directory."""
    return main(arguments)


def recorded(file: Path) -> dict[int, dict[str, str]]:
    """The rows of a trials.csv, by seed, as they stand there."""
    with file.open(newline="", encoding="utf-8") as stream:
        return {int(row["seed"]): row for row in csv.DictReader(stream)}


def recorded_trial(folder: Path) -> dict[str, Any]:
    """The row in a trial's own folder."""
    row = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert isinstance(row, dict)
    return row


def actions(trial: Path) -> dict[str, Any]:
    saved = json.loads((trial / "actions.json").read_text(encoding="utf-8"))
    assert isinstance(saved, dict)
    return saved


def assert_found(run: Path, rows: Mapping[int, Mapping[str, Any]], seeds: Iterable[int]) -> None:
    """A run has the trials of some seeds, and found in them what the recorded rows say: the same to the last digit."""
    table = origami_lab.load(run).trials
    assert sorted(table.index) == sorted(seeds)
    for seed in table.index:
        for column, said in rows[seed].items():
            if column in ("seed", *TIMINGS):
                continue
            found = table.loc[seed, column]
            if said in ("", None):  # version 0.1.0 left a place empty where now it says that nothing was verified
                assert _is_missing(found) or (column, found) == ("certificate", NOT_CHECKED), (seed, column, found)
            elif isinstance(found, str):
                assert found == said, (seed, column)
            else:
                assert float(found) == pytest.approx(float(said), rel=0, abs=1e-9), (seed, column)


def _is_missing(value: Any) -> bool:
    return value is pd.NA or (isinstance(value, float) and math.isnan(value))
