"""A run that knows its paper: its files, its table and its certificates are in millimetres, and thick."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from origami_lab.fold_format.reader import read_fold
from origami_lab.runs.run_folder import RunFolder
from tests.small_runs import run

pytestmark = pytest.mark.slow

WORDS = ("target=pyramid", "search=dfts", "budget=3000", "tracking=none", "workers=1", "verbosity=quiet")


def test_from_start_to_end(tmp_path: Path) -> None:
    paper = ("cell=5mm", "sheet=A3", "thickness=0.01mm", "polish=20")
    assert run(tmp_path, *WORDS, *paper, "output=out") == 0
    trial = tmp_path / "out/seed=0"
    row = RunFolder(tmp_path / "out").rows()[0]
    fold = read_fold(trial / "best.fold")
    assert fold.cell == 5.0
    assert fold.sheet == (297.0, 420.0)
    assert (row.cell_mm, row.return_mm) == (5.0, pytest.approx(5 * row.return_))
    np.testing.assert_allclose([row.width_mm, row.height_mm], 5 * np.ptp(fold.vertices, axis=0))
    assert {"pattern.dxf", "pattern.cut.svg", "pattern.cut.pdf"} <= {file.name for file in trial.iterdir()}
    assert " 5 mm a cell</title>" in (trial / "pattern.svg").read_text()
    assert "<dt>board cell</dt><dd>5 mm</dd>" in (trial / "best.html").read_text()
    # 0.01 mm are 0.002 cells
    for name in ("certificate.json", "polished.certificate.json"):
        said = [check["text"] for check in json.loads((trial / name).read_text())["checks"]]
        assert any(text.endswith("all keep 0.002 apart") for text in said), name
    assert read_fold(trial / "polished.fold").cell == 5.0
    assert row.polished_likeness is not None


def test_what_is_too_thick_to_fold_is_refuted(tmp_path: Path) -> None:
    """The pyramid's flaps meet along its edges: half a cell cannot be kept between them."""
    assert run(tmp_path, *WORDS, "cell=5mm", "thickness=2.5mm", "output=out") == 0
    row = RunFolder(tmp_path / "out").rows()[0]
    result = json.loads((tmp_path / "out/seed=0/result.json").read_text())
    assert row.certificate == "refuted" or result["passed_over"]


def test_without_paper_there_is_no_cut_sheet(tmp_path: Path) -> None:
    assert run(tmp_path, *WORDS, "output=out") == 0
    row = RunFolder(tmp_path / "out").rows()[0]
    assert row.cell_mm is row.return_mm is row.width_mm is row.height_mm is None
    assert not list((tmp_path / "out/seed=0").glob("pattern.cut.*"))
