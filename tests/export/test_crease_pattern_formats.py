"""Crease patterns in other formats, read back by readers that are not ours."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from origami_lab.export.cp import write_cp
from origami_lab.export.dxf import write_dxf
from origami_lab.export.svg import write_svg
from origami_lab.fold_format.writer import as_fold_file
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs
from tests.known_designs.pattern_forms import Segment, normal_form, true_form


def half_flat() -> CreasePattern:
    """The asymmetric vertex with one crease that does not fold."""
    design = designs.degree_four()
    angles = design.fold_angles.copy()
    angles[:, np.flatnonzero(~design.boundary)[1]] = 0.0
    return dataclasses.replace(design, fold_angles=angles, metadata={"title": "a < b & c"})


# the degree-4 vertex has no symmetry: a mirror or a turn would show
DESIGNS: dict[str, Callable[[], CreasePattern]] = {
    "asymmetric": designs.degree_four,
    "mode B": lambda: designs.degree_four(mode="B", best=9),
    "flat crease": half_flat,
    "pyramid": designs.pyramid,
}
every_design = pytest.mark.parametrize("make", DESIGNS.values(), ids=DESIGNS)


def test_the_comparison_sees_mirrors() -> None:
    design = designs.degree_four()
    for x, y in ((-1, 1), (1, -1), (-1, -1)):
        assert true_form(dataclasses.replace(design, vertices=design.vertices * [x, y])) != true_form(design)
    assert true_form(dataclasses.replace(design, vertices=design.vertices * 7.5 + 3)) == true_form(design)


@every_design
def test_svg_is_what_origami_simulator_reads(make: Callable[[], CreasePattern], tmp_path: Path) -> None:
    """Its import tips: strokes, opacity = fold angle / 180°, vertices closer than 3 units merge.

    It takes all lines, paths, rectangles and polygons that are children of the root, and nothing in groups; an SVG
    unit is a unit of length if nothing is transformed. Valleys are positive there, too.
    """
    design = make()
    fold = as_fold_file(design)
    write_svg(fold, fold.best, tmp_path / "a.svg")
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert root.tag == space + "svg"
    assert {child.tag for child in root} == {space + "title", space + "line"}
    assert root[0].text == fold.title
    kinds = {"#ff0000": "M", "#0000ff": "V", "#000000": "B", "#ffff00": "F"}
    segments: list[Segment] = []
    for edge, line in enumerate(root.iter(space + "line")):
        assert "transform" not in line.attrib
        assert "style" not in line.attrib
        letter = kinds[line.attrib["stroke"]]
        x1, y1, x2, y2 = (float(line.attrib[key]) for key in ("x1", "y1", "x2", "y2"))
        segments.append((letter, x1, -y1, x2, -y2))  # y runs down in SVG
        sign = {"M": -1, "V": 1}.get(letter, 0)
        angle = sign * np.pi * float(line.attrib.get("opacity", 1))
        assert angle == pytest.approx(design.fold_angles[design.best, edge], abs=1e-9)
    assert normal_form(segments) == true_form(design)
    points = np.unique(np.array([s[1:] for s in segments]).reshape(-1, 2).round(6), axis=0)
    assert len(points) == len(design.vertices)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    true = np.linalg.norm(design.vertices[:, None] - design.vertices[None], axis=2)
    assert apart.max() / true.max() == pytest.approx(40)  # units a cell
    assert apart[apart > 0].min() > 3
    box = [float(number) for number in root.attrib["viewBox"].split()]
    assert all(0 < x < box[2] and 0 < -y < box[3] for x, y in points)


def test_svg_of_a_small_pattern(tmp_path: Path) -> None:
    """A foreign pattern within a unit square is scaled so that no vertices merge."""
    fold = as_fold_file(designs.pyramid())
    small = dataclasses.replace(fold, vertices=fold.vertices / 400)
    write_svg(small, small.best, tmp_path / "a.svg")
    lines = list(ElementTree.parse(tmp_path / "a.svg").getroot())[1:]
    ends = np.array([[float(line.attrib[key]) for key in ("x1", "y1", "x2", "y2")] for line in lines]).reshape(-1, 2, 2)
    assert np.linalg.norm(np.diff(ends, axis=1), axis=2).min() == pytest.approx(10)


@every_design
@pytest.mark.parametrize("palette", ["simulator", "oripa"])
def test_dxf(make: Callable[[], CreasePattern], palette: str, tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf", reason="the reader of DXF is not installed")
    design = make()
    fold = as_fold_file(design)
    write_dxf(fold, fold.best, tmp_path / "a.dxf", scale=2.5, palette=palette)
    document = ezdxf.readfile(tmp_path / "a.dxf")
    assert document.dxfversion == "AC1009"
    auditor = document.audit()
    assert not auditor.errors
    kinds = {"CutLine": "B", "MountainLine": "M", "ValleyLine": "V", "FlatLine": "F"}
    lines = list(document.modelspace())
    assert {line.dxftype() for line in lines} == {"LINE"}
    segments = [
        (kinds[line.dxf.layer], line.dxf.start.x, line.dxf.start.y, line.dxf.end.x, line.dxf.end.y) for line in lines
    ]
    assert normal_form(segments) == true_form(design)
    ends = np.array([segment[1:] for segment in segments]).reshape(-1, 2, 2)
    assert np.allclose(ends, 2.5 * design.vertices[design.edges], atol=1e-12)
    colours = {line.dxf.layer: line.dxf.color for line in lines}
    mountain, valley = (1, 5) if palette == "simulator" else (5, 1)
    assert colours.get("MountainLine", mountain) == mountain
    assert colours.get("ValleyLine", valley) == valley
    assert all(document.layers.get(name).dxf.color == colour for name, colour in colours.items())


@every_design
def test_cp(make: Callable[[], CreasePattern], tmp_path: Path) -> None:
    design = make()
    fold = as_fold_file(design)
    write_cp(fold, fold.best, tmp_path / "a.cp")
    kinds = {"1": "B", "2": "M", "3": "V", "4": "F"}
    segments: list[Segment] = []
    for line in (tmp_path / "a.cp").read_text().splitlines():
        kind, *ends = line.split(" ")
        x1, y1, x2, y2 = (float(number) for number in ends)
        segments.append((kinds[kind], x1, -y1, x2, -y2))  # ORIPA and Oriedita draw y downwards
    assert normal_form(segments) == true_form(design)
    points = np.array([segment[1:] for segment in segments]).reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    assert low + high == pytest.approx([0, 0], abs=1e-9)
    assert max(high - low) == pytest.approx(400)


def test_creases_of_another_state(tmp_path: Path) -> None:
    """Letters and opacities are those of the state that is asked for."""
    fold = as_fold_file(designs.single_valley())
    for frame, stroke, opacity in ((fold.frames[0], "#0000ff", 0.314 / np.pi), (fold.flat, "#ffff00", 1.0)):
        write_svg(fold, frame, tmp_path / "a.svg")
        lines = [line.attrib for line in ElementTree.parse(tmp_path / "a.svg").getroot()[1:]]
        (crease,) = (line for line in lines if line["stroke"] != "#000000")
        assert crease["stroke"] == stroke
        assert float(crease.get("opacity", 1)) == pytest.approx(opacity)
