"""`origami-lab check`: what it prints is the analysis, its page loads nothing, its command is the one that runs."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from PIL import Image

from benchmarks.parts import shapes
from origami_lab.cli import main
from origami_lab.config.compose import compose_settings


@pytest.fixture
def lid(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "my lid.stl"
    file.write_bytes(shapes.stl(shapes.box_lid()))
    return file


def test_a_part_is_described_and_its_command_runs(lid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", lid.name]) == 0
    said = capsys.readouterr().out
    assert len(said.splitlines()) < 24  # one screen
    for words in ("5 faces", "1 rim", "120 × 80 × 20", "12 × 8 × 2 cells", "10 mm", "25 × 21 points"):
        assert words in said
    line = next(text for text in said.splitlines() if text.strip().startswith("origami-lab target=mesh"))
    found = compose_settings(shlex.split(line)[1:])
    assert (found.game.width, found.game.height, found.game.symmetry) == (25, 21, "xy")
    page = (lid.parent / "my lid-check.html").read_text(encoding="utf-8")
    assert "120 × 80 × 20" in page
    assert not re.search(r"(?:src|href)=\"(?!data:)", page.split("<iframe")[0])
    assert not re.search(r"https?://", page.split("<iframe")[0])
    with Image.open(lid.parent / "my lid-check.png") as picture:
        assert picture.width > picture.height > 300


def test_nothing_is_written_if_only_words_are_asked_for(lid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(lid), "--text"]) == 0
    assert list(lid.parent.iterdir()) == [lid]
    assert main(["check", str(lid), "--output", str(lid)]) == 2
    assert "--output=" in capsys.readouterr().err
