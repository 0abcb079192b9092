"""Learning curves against values that were worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from origami_lab.report.learning_curves import learning_figure, read_curves, solved_figure, threshold_of
from origami_lab.report.run_reader import Note
from tests.report.runs import gather, trial, write_run

CURVES = {0: [(10, -4.0), (30, -2.0)], 1: [(20, -6.0), (30, -5.0), (40, -1.0)], 2: [(5, -3.0)]}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rows = [trial(-2.0), trial(-1.0), trial(-3.0), trial(-8.0, status="no design"), trial(-1.0, status="stopped")]
    return write_run(tmp_path / "a", "cube", "rdm", rows, curves=CURVES)


def test_the_best_so_far(folder: Path) -> None:
    _, groups, _ = gather(folder)
    [curve] = read_curves(groups, []).values()
    assert curve.steps.tolist() == [0, 5, 10, 20, 30, 40, 1000]
    n = math.nan
    expected = [[n, n, -4, -4, -2, -2, -2], [n, n, n, -6, -5, -1, -1], [n, -3, -3, -3, -3, -3, -3], [-8.0] * 7]
    np.testing.assert_array_equal(curve.values, expected)
    np.testing.assert_allclose(curve.mean, [n, n, n, -21 / 4, -18 / 4, -14 / 4, -14 / 4])
    deviations = np.array([-2, -1, -3, -8]) + 14 / 4
    assert curve.std[-1] == pytest.approx(math.sqrt(np.sum(deviations**2) / 3))
    assert np.isnan(curve.std[:3]).all()
    np.testing.assert_allclose(curve.solved(-2.0), [0, 0, 0, 0, 0.25, 0.5, 0.5])


def test_solved_is_nearly_the_best_of_the_task(folder: Path, tmp_path: Path) -> None:
    write_run(tmp_path / "b", "cube", "evo", [trial(-0.5)])
    write_run(tmp_path / "c", "bowl", "evo", [trial(-0.01), trial(-0.02)])
    write_run(tmp_path / "d", "face", "evo", [trial(-9.0, status="no design")])
    _, groups, _ = gather(tmp_path)
    curves = read_curves(groups, [])
    found = {column.label: threshold_of(groups, column, curves) for column in groups.columns}
    assert found["cube"] == pytest.approx(-0.505)  # 1 %
    assert found["bowl"] == pytest.approx(-0.011)  # 0.001
    assert found["face"] is None


def test_what_every_first_design_is_worth_is_not_solved(tmp_path: Path) -> None:
    none = trial(-8.0, status="no design")
    write_run(tmp_path / "a", "bucket", "rdm", [trial(0.0), trial(0.0), none])
    write_run(tmp_path / "b", "shelf", "rdm", [trial(0.0), trial(4.0), none])  # one found something
    write_run(tmp_path / "c", "cube", "rdm", [trial(-0.07)], curves={0: [(10, -4.0), (30, -0.07)]})  # it rose
    write_run(tmp_path / "d", "table", "rdm", [trial(-0.05)], curves={0: [(10, -0.0505), (30, -0.05)]})
    _, groups, _ = gather(tmp_path)
    curves = read_curves(groups, [])
    found = {column.label: threshold_of(groups, column, curves) for column in groups.columns}
    assert found == {"bucket": None, "shelf": pytest.approx(3.96), "cube": pytest.approx(-0.071), "table": None}


def test_the_band_ends_where_the_trials_do(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "cube", "rdm", [trial(-0.1), trial(-0.1), trial(-4.1)])
    _, groups, _ = gather(tmp_path)
    [curve] = read_curves(groups, []).values()
    mean, std = -4.3 / 3, 4 / math.sqrt(3)  # of 0, 0 and 4: a third of 4, and the root of 32 / 3 / 2
    assert mean + std > -0.1 > -4.1 + std
    low, high = curve.band
    np.testing.assert_allclose(high, -0.1)
    np.testing.assert_allclose(low, mean - std)
    [column] = groups.columns
    [axes] = learning_figure(groups, column, {next(iter(groups.cells)): curve}).axes
    [band] = axes.collections
    assert band.get_datalim(axes.transData).y1 == pytest.approx(-0.1)


def test_figures_show_the_curves(folder: Path, tmp_path: Path) -> None:
    write_run(tmp_path / "b", "cube", "evo", [trial(-1.0, 50), trial(-3.0, 60)])
    _, groups, _ = gather(tmp_path)
    curves = read_curves(groups, [])
    [column] = groups.columns
    [axes] = learning_figure(groups, column, curves).axes
    lines = {str(line.get_label()): line for line in axes.get_lines()}
    assert lines.keys() == {"rdm", "evo"}
    np.testing.assert_allclose(lines["evo"].get_xydata(), [[60, -2], [1000, -2]])
    assert len(axes.collections) == 2  # the bands
    [axes] = solved_figure(groups, column, curves, -1.0).axes
    lines = {str(line.get_label()): line for line in axes.get_lines()}
    np.testing.assert_allclose(lines["evo"].get_xydata(), [[50, 0.5], [60, 0.5], [1000, 0.5]])
    assert lines["evo"].get_color() != lines["rdm"].get_color()


def test_a_curve_that_cannot_be_read_is_named(folder: Path) -> None:
    (folder / "seed=0/curve.csv").unlink()
    (folder / "seed=1/curve.csv").write_bytes(b"\xff\xfe\x00")
    (folder / "seed=2/curve.csv").write_text("interactions,return\n1,nan\n", encoding="utf-8")
    _, groups, _ = gather(folder)
    notes: list[Note] = []
    [curve] = read_curves(groups, notes).values()
    assert len(curve.values) == 1
    assert [note.folders[0].name for note in notes] == ["seed=0", "seed=1", "seed=2"]
