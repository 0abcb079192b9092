"""Designs of a run that knows how long a cell is: exports and pages in millimetres, unless told otherwise."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from origami_lab.drawing.viewer import viewer_page
from origami_lab.export.formats import export_design
from origami_lab.fold_format.reader import read_fold
from origami_lab.fold_format.writer import to_fold
from tests.known_designs import closed_forms as designs


def written(tmp_path: Path, **facts: object) -> Path:
    """A FOLD file of a design with such facts."""
    fold = to_fold(designs.degree_four())
    fold["origami_lab:metadata"] = {"return": -0.25, **facts}
    file = tmp_path / "design.fold"
    file.write_text(json.dumps(fold))
    return file


def box_of(svg: Path) -> tuple[list[str], np.ndarray]:
    """The size that an SVG has on paper, and the extent of its lines in its own units."""
    root = ElementTree.parse(svg).getroot()
    names = ("x1", "y1", "x2", "y2")
    ends = np.array([[float(line.attrib[n]) for n in names] for line in root.iter("{http://www.w3.org/2000/svg}line")])
    return [root.attrib["width"], root.attrib["height"]], np.ptp(ends.reshape(-1, 2), axis=0)


def test_flat_formats_are_in_millimetres(tmp_path: Path) -> None:
    file = written(tmp_path, cell_mm=5.0)
    extent = np.ptp(read_fold(file).vertices, axis=0)
    export_design(file, "svg,dxf,cut")
    (wide, high), drawn = box_of(tmp_path / "design.svg")
    # a unit of the drawing is an eighth of a millimetre: 40 units a cell; 20 more at each side
    assert wide.endswith("mm")
    assert high.endswith("mm")
    np.testing.assert_allclose([float(wide[:-2]), float(high[:-2])], extent * 5 + 2 * 20 / 8)
    np.testing.assert_allclose(drawn / 8, extent * 5)
    numbers = [line.strip() for line in (tmp_path / "design.dxf").read_text().splitlines()]
    x = [float(value) for code, value in zip(numbers[::2], numbers[1::2], strict=True) if code in ("10", "11")]
    assert np.ptp(x) == pytest.approx(extent[0] * 5)
    root = ElementTree.parse(tmp_path / "design.cut.svg").getroot()
    # without a sheet it is as large as need be, with a margin of 10
    assert float(root.attrib["width"][:-2]) == pytest.approx(extent[0] * 5 + 20)


def test_the_sheet_of_the_run_is_the_cut_sheet_s(tmp_path: Path) -> None:
    file = written(tmp_path, cell_mm=5.0, sheet_mm=[297.0, 420.0])
    done = export_design(file, "cut")
    assert any("5 mm a cell on 297 × 420 mm" in note for note in done.notes)
    done = export_design(file, "cut", cell=7.0)
    assert any("7 mm a cell" in note for note in done.notes)


def test_meshes_are_in_millimetres(tmp_path: Path) -> None:
    sizes = []
    for facts in ({}, {"cell_mm": 5.0}):
        file = written(tmp_path, **facts)
        export_design(file, "stl")
        sizes.append(trimesh.load(tmp_path / "design.stl").extents)
    np.testing.assert_allclose(sizes[1], 5 * sizes[0], rtol=1e-6)


def test_the_page_says_millimetres(tmp_path: Path) -> None:
    page = viewer_page(read_fold(written(tmp_path, cell_mm=5.0, return_in="cells")))
    assert "<dt>board cell</dt><dd>5 mm</dd>" in page
    assert "<dt>distance</dt><dd>1.25 mm</dd>" in page
    assert " mm</dd>" not in viewer_page(read_fold(written(tmp_path)))
    # of a return that is no distance
    assert "<dt>distance</dt>" not in viewer_page(read_fold(written(tmp_path, cell_mm=5.0)))


@pytest.mark.parametrize("cell", [0, -1, "5mm", None, True, [5, 5], 1e9, {}])
def test_a_stranger_s_cell_is_none(tmp_path: Path, cell: object) -> None:
    fold = read_fold(written(tmp_path, cell_mm=cell, sheet_mm=[1, "2"]))
    assert fold.cell is None
    assert fold.sheet is None
