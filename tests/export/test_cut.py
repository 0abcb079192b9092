"""Cut sheets: millimetres, layers and dashes, as an SVG parser and the PDF's own page say."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.export.cut_sheet import CutSheet, chains, dashes, lay_out, parse_sheet, write_cut
from origami_lab.fold_format.writer import as_fold_file
from tests.known_designs import closed_forms as designs
from tests.known_designs.pattern_forms import Segment, normal_form, true_form

COLOURS = {"#000000": "cut", "#ff0000": "mountain", "#0000ff": "valley"}
Layers = dict[str, list[np.ndarray]]


def sheet_of(**settings: object) -> CutSheet:
    fold = as_fold_file(designs.degree_four())
    return lay_out(fold, fold.best, **settings)  # type: ignore[arg-type]


def from_svg(path: Path) -> tuple[list[str], Layers]:
    root = ElementTree.parse(path).getroot()
    space = "{http://www.w3.org/2000/svg}"
    layers: Layers = {}
    for group in root.iter(space + "g"):
        assert COLOURS[group.attrib["stroke"]] == group.attrib["id"]
        layers[group.attrib["id"]] = [numbers(element.attrib["d"]) for element in group.iter(space + "path")]
    box = root.attrib["viewBox"].split()
    assert [box[2] + "mm", box[3] + "mm"] == [root.attrib["width"], root.attrib["height"]]
    return box[2:], layers


def numbers(path: str) -> np.ndarray:
    """The polyline of an absolute path of straight lines."""
    assert re.fullmatch(r"M[-\d.,]+(L[-\d.,]+)+Z?", path)
    points = [tuple(map(float, pair.split(","))) for pair in re.split("[ML]", path.rstrip("Z"))[1:]]
    return np.array(points + points[:1] * path.endswith("Z"))


def from_pdf(path: Path) -> tuple[list[float], Layers]:
    """By the rules of ISO 32000-1: the offsets of the table lead to objects, the page's operators draw."""
    data = path.read_bytes()
    table = int(re.findall(rb"startxref\n(\d+)\n%%EOF", data)[0])
    rows = re.findall(rb"(\d{10}) 00000 n \n", data[table:])
    objects = [data[int(row) :].split(b"endobj")[0] for row in rows]
    assert all(body.startswith(b"%d 0 obj\n" % number) for number, body in enumerate(objects, start=1))
    page = next(body for body in objects if b"/Type /Page " in body)
    box = [float(n) for n in re.findall(rb"MediaBox \[([^]]*)\]", page)[0].split()]
    names = {}
    for key, reference in re.findall(rb"/(L\d) (\d) 0 R", page):
        group = objects[int(reference) - 1]
        names[key.decode()] = bytes.fromhex(re.findall(rb"/Name <feff(\w+)>", group)[0].decode()).decode("utf-16-be")
    content = next(body for body in objects if b"stream\n" in body)
    length = int(re.findall(rb"/Length (\d+)", content)[0])
    drawing = content.split(b"stream\n")[1][:length].decode()
    assert content.split(b"stream\n", 1)[1][length:] == b"\nendstream\n"
    layers: Layers = {}
    for key, body in re.findall(r"/OC /(L\d) BDC\n(.*?)EMC", drawing, re.DOTALL):
        lines = []
        for line in body.splitlines()[1:]:
            points = [tuple(map(float, pair)) for pair in re.findall(r"(\S+) (\S+) [ml]", line)]
            lines.append(np.array(points + points[:1] * line.endswith(" s")))
        layers[names[key]] = lines
    return box, layers


def test_both_files_draw_the_same_millimetres(tmp_path: Path) -> None:
    sheet = sheet_of(cell=20.0, sheet=(150.0, 200.0))
    for name in ("a.svg", "a.pdf"):
        write_cut(sheet, tmp_path / name)
    size, in_svg = from_svg(tmp_path / "a.svg")
    box, in_pdf = from_pdf(tmp_path / "a.pdf")
    assert [float(n) for n in size] == [150, 200]
    assert box == pytest.approx([0, 0, 150 / 25.4 * 72, 200 / 25.4 * 72], abs=1e-4)
    assert list(in_svg) == list(in_pdf) == ["cut", "mountain", "valley"]
    for name, lines in in_svg.items():
        assert len(lines) == len(in_pdf[name]) > 0
        for line, other in zip(lines, in_pdf[name], strict=True):
            turned = other * 25.4 / 72 * [1, -1] + [0, 200]  # its y runs up
            assert np.allclose(line, turned, atol=1e-3)


def test_creases_are_where_they_belong(tmp_path: Path) -> None:
    """The dashes of a crease, joined, are the crease; nothing is mirrored, a cell is 20 mm."""
    design = designs.degree_four()
    write_cut(sheet_of(cell=20.0), tmp_path / "a.svg")
    size, layers = from_svg(tmp_path / "a.svg")
    extent = np.ptp(design.vertices, axis=0)
    assert [float(n) for n in size] == pytest.approx(extent * 20 + 20)
    (outline,) = layers["cut"]  # one path, without a stop
    assert np.array_equal(outline[0], outline[-1])
    assert len(outline) == 5
    segments: list[Segment] = [("B", a[0], -a[1], b[0], -b[1]) for a, b in pairwise(outline)]
    assert normal_form(segments) == true_form(design, "B")
    tips = {}
    corner = outline.min(axis=0) + np.array([-design.vertices[:, 0].min() * 20, design.vertices[:, 1].max() * 20])
    for name, letter in (("mountain", "M"), ("valley", "V")):
        for dash in layers[name]:
            flat = (dash - corner) / 20 * [1, -1]
            along = flat / np.linalg.norm(flat, axis=1, keepdims=True)
            assert np.allclose(along[0], along[1], atol=1e-3)  # all four creases begin at the origin
            tips.setdefault((letter, *np.round(along[0], 2)), []).extend(np.linalg.norm(flat, axis=1))
    lengths = {}
    for (u, v), letter in zip(design.edges, design.assignments, strict=True):
        if u == 0:
            tip = design.vertices[v]
            lengths[(letter, *np.round(tip / np.linalg.norm(tip), 2))] = float(np.linalg.norm(tip))
    assert set(tips) == set(lengths)
    for key, ends in tips.items():
        assert min(ends) * 20 == pytest.approx(1.5, abs=1e-3)
        assert max(ends) * 20 == pytest.approx(lengths[key] * 20 - 1.5, abs=1e-3)


@pytest.mark.parametrize("length", [0.3, 2.0, 3.0, 4.4, 5.6, 8.0, 20.0, 137.0])
def test_dashes(length: float) -> None:
    start, end = np.array([1.0, 2.0]), np.array([1.0, 2.0]) + length * np.array([0.6, -0.8])
    pieces = dashes(start, end, 2.5, 2.5)
    along = (np.array(pieces) - start) @ [0.6, -0.8]
    assert np.allclose((np.array(pieces) - start) @ [0.8, 0.6], 0, atol=1e-12)
    flat = along.ravel()
    assert np.all(np.diff(flat) > 0)
    assert flat[0] > 0
    assert flat[0] == pytest.approx(length - flat[-1])
    assert np.ptp(along[:, 1] - along[:, 0]) == pytest.approx(0, abs=1e-9)
    if length >= 5.6:
        assert flat[0] == pytest.approx(1.5)
        gaps = along[1:, 0] - along[:-1, 1]
        assert np.allclose(gaps, along[0, 1] - along[0, 0])
        assert along[0, 1] - along[0, 0] == pytest.approx(2.5, rel=0.5)
    else:
        assert len(pieces) == 1


def test_chains() -> None:
    square = [(0, 1), (2, 1), (2, 3), (3, 0)]
    (path,) = chains(square)
    assert path[0] == path[-1]
    assert {frozenset(pair) for pair in pairwise(path)} == {frozenset(edge) for edge in square}
    touching = [*square, (1, 4), (4, 5), (5, 1), (7, 8), (8, 9)]  # two loops in one vertex, and an open path
    paths = chains(touching)
    steps = [frozenset(pair) for path in paths for pair in pairwise(path)]
    assert sorted(map(sorted, steps)) == sorted(map(sorted, touching))
    assert len(paths) == 2


def test_fitting() -> None:
    extent = np.ptp(designs.degree_four().vertices, axis=0)
    a4 = sheet_of()
    assert {a4.width, a4.height} == {210, 297}
    both = [min((210 - 20) / extent[0], (297 - 20) / extent[1]), min((297 - 20) / extent[0], (210 - 20) / extent[1])]
    assert a4.cell == pytest.approx(max(both))
    points = np.vstack([line for lines in a4.layers.values() for line in lines])
    room = np.array([a4.width, a4.height]) - 10
    assert np.all(points >= 10 - 1e-9)
    assert np.all(points <= room + 1e-9)
    assert points.min(axis=0) + points.max(axis=0) == pytest.approx([a4.width, a4.height])  # in the middle
    wide = sheet_of(sheet=(100.0, 1000.0), margin=0.0)
    assert wide.cell == pytest.approx(
        max(min(100 / extent[0], 1000 / extent[1]), min(1000 / extent[0], 100 / extent[1]))
    )
    assert sheet_of(cell=float(a4.cell)).cell == a4.cell
    with pytest.raises(InputError, match=r"cell=100: must be at most .* (190 × 277|277 × 190) mm"):
        sheet_of(cell=100.0, sheet=(210.0, 297.0))
    with pytest.raises(InputError, match="margin=110: must leave room"):
        sheet_of(margin=110.0)


def test_sheet_sizes() -> None:
    assert parse_sheet("a4") == (210, 297)
    assert parse_sheet("A3") == (297, 420)
    assert parse_sheet("300x200.5") == (300, 200.5)
    for text in ("A9", "300", "300x", "0x5", "-1x5", "nanx5", "1x2x3", "infx5", ""):
        with pytest.raises(InputError, match="sheet="):
            parse_sheet(text)
