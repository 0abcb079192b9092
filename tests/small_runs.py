"""Runs that several tests look at, and how to compose a configuration in a test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from origami_lab.cli import main
from origami_lab.config.checked_values import ReportOrder
from origami_lab.config.settings import Settings
from origami_lab.runs.trial_row import TrialRow


def trial_row(seed: int, value: float | None = -1.0, status: str = "ok", **more: Any) -> TrialRow:
    """A row with so much in it as it must have."""
    if status.startswith("failed"):
        return TrialRow(seed=seed, status=status, **more)
    found: dict[str, Any] = {"return_": value, "interactions_to_best": 10, "interactions": 10, "status": status}
    return TrialRow(seed=seed, **(found | more))


TIMINGS = ("seconds", "interactions_per_second")
"""Columns that differ from run to run."""
SMALL = ("target=pyramid", "search=rdm", "budget=400", "verbosity=quiet")
"""A run of seconds: most of them importing and drawing."""


def bare_settings(**changes: Any) -> Settings:
    """Settings of a run whose trials nobody plays."""
    nothing: dict[str, Any] = {}
    plain = Settings(
        task="pyramid",
        method="rdm",
        game=nothing,
        start=nothing,
        target=None,
        objective=nothing,
        search=nothing,
        tracking=nothing,
        report_order=ReportOrder(),
        seeds=(0,),
        seeds_given=True,
        budget=10,
        certify=True,
        workers=1,
        files="all",
        polish=None,
        polish_seconds=None,
        polish_simplify=None,
        objective_seconds=None,
        output=None,
        resume=False,
        verbosity="quiet",
        config={"budget": 10, "seed": 0},
    )
    return replace(plain, **changes)


@contextmanager
def inside(folder: Path) -> Iterator[Path]:
    """Work in a folder for a while."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield folder


def run(folder: Path, *arguments: str) -> int:
    """The command's exit code, run in a folder."""
    with inside(folder):
        return main(arguments)


@pytest.fixture(scope="session")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which three seeds were run by one worker, with tracking, and results in DIR/out."""
    folder = tmp_path_factory.mktemp("tracked")
    assert run(folder, *SMALL, "seed=0..2", "workers=1", "output=out") == 0
    return folder


@pytest.fixture(scope="session")
def composed() -> Sequence[str]:
    """Keys of the default configuration, dotted."""
    from origami_lab.config.compose import known_keys

    return known_keys()
