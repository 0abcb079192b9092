"""Run folders say which format they have; one of a later version is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

import origami_lab
from tests.old_runs.conftest import command
from tests.old_runs.make_fixtures import QUICK

WORDS = ("target=pyramid", "search=rdm", "budget=100", *QUICK, "output=run")


def make_newer(run: Path) -> None:
    """Raise the format version by one, in whatever file of the run folder's it stands."""
    found = []
    for file in [run / "config.yaml", *run.glob("*.json")]:
        content: dict[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))
        for key in [key for key in content if "format" in key]:
            content[key] += 1
            found.append(file)
            text = json.dumps(content) if file.suffix == ".json" else yaml.safe_dump(content)
            file.write_text(text, encoding="utf-8")
    assert found, "no format version is written"


def test_newer_folder_is_refused_in_one_line(here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert command(*WORDS) == 0
    assert command(*WORDS, "resume=true") == 0
    make_newer(here / "run")
    before = {file: file.read_bytes() for file in (here / "run").rglob("*") if file.is_file()}
    with pytest.raises(origami_lab.InputError, match=r"version|format"):
        origami_lab.load("run")
    for words in ((*WORDS, "resume=true"), ("run/config.yaml", "output=again")):
        capfd.readouterr()
        assert command(*words) == 2
        assert len(capfd.readouterr().err.splitlines()) == 1
    assert not (here / "again").exists()
    assert {file: file.read_bytes() for file in (here / "run").rglob("*") if file.is_file()} == before
