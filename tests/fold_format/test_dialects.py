"""One pattern in thirteen dialects: one meaning, one verdict, the same creases in every format."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import origami_lab
from origami_lab.fold_format.reader import read_fold
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import DIALECTS, Dialect, Fold
from tests.known_designs.pattern_forms import Segment, normal_form

CORPUS = corpus()
every_pattern = pytest.mark.parametrize("pattern", CORPUS.values(), ids=CORPUS)
every_dialect = pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
MOVED = {"tilted", "folded alone"}
"""Dialects whose patterns come out turned in their plane."""


def write(tmp_path: Path, fold: Fold) -> Path:
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(fold), encoding="utf-8")
    return path


def lengths_of(pattern: Pattern) -> Counter[tuple[str, float]]:
    """Creases by letter and length: the same however a pattern is turned."""
    return Counter(
        (letter, round(float(np.linalg.norm(pattern.flat[u] - pattern.flat[v])), 6))
        for (u, v), letter in zip(pattern.edges, pattern.letters, strict=True)
    )


@every_pattern
@every_dialect
def test_verdicts(pattern: Pattern, dialect: Dialect, tmp_path: Path) -> None:
    certificate = origami_lab.verify(write(tmp_path, dialect.write(pattern)))
    expected = "certified" if dialect.folds and pattern.one_freedom else "not certifiable"
    assert certificate.verdict == expected, certificate.words()


@every_pattern
@every_dialect
def test_what_is_read(pattern: Pattern, dialect: Dialect, tmp_path: Path) -> None:
    fold = read_fold(write(tmp_path, dialect.write(pattern)))
    count = len(pattern.edges)
    assert [tuple(sorted(edge)) for edge in fold.edges.tolist()[:count]] == [tuple(sorted(e)) for e in pattern.edges]
    assert fold.assignments[:count] == pattern.letters
    flat, n = fold.vertices, len(pattern.flat)
    apart, true = (np.linalg.norm(x[:, None] - x[None], axis=2) for x in (flat[:n], pattern.flat))
    assert np.allclose(apart, true, atol=1e-9)  # the same but for where it lies; and not mirrored:
    for face, known in zip(pattern.faces, pattern.faces, strict=True):
        x, y = flat[list(face)].T
        assert x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0, known
    rings = {frozenset(panel) for panel in fold.panels}
    assert rings == {frozenset(face) for face in pattern.faces}
    if dialect.folds:
        assert fold.assumed is None
        assert np.degrees(fold.fold_angles[:count]) == pytest.approx(pattern.degrees[-1], abs=1e-6)
    else:
        assert fold.assumed is not None
        assert any("180° is assumed" in remark for remark in fold.remarks)


def from_svg(path: Path) -> list[Segment]:
    strokes = {"#ff0000": "M", "#0000ff": "V", "#000000": "B", "#ffff00": "F", "#ff00ff": "U"}
    lines = [child.attrib for child in ElementTree.parse(path).getroot() if child.tag.endswith("line")]
    return [(strokes[a["stroke"]], float(a["x1"]), -float(a["y1"]), float(a["x2"]), -float(a["y2"])) for a in lines]


def from_cp(path: Path) -> list[Segment]:
    rows = [line.split() for line in path.read_text(encoding="ascii").splitlines()]
    return [("?BMVF"[int(k)], float(a), -float(b), float(c), -float(d)) for k, a, b, c, d in rows]


def from_dxf(path: Path) -> list[Segment]:
    """Group codes and values in turns; 8 is the layer, 10 to 21 the ends."""
    rows = path.read_text(encoding="ascii").splitlines()
    tags = list(zip(map(int, rows[::2]), rows[1::2], strict=True))
    layers = {"CutLine": "B", "MountainLine": "M", "ValleyLine": "V", "FlatLine": "F", "UnassignedLine": "U"}
    found = []
    for at, (code, value) in enumerate(tags):
        if (code, value) == (0, "LINE"):
            facts = dict(tags[at + 1 : at + 9])
            found.append((layers[facts[8]], *(float(facts[k]) for k in (10, 20, 11, 21))))
    return found


def from_fold(path: Path) -> list[Segment]:
    fold = json.loads(path.read_text(encoding="utf-8"))
    points = fold["vertices_coords"]
    pairs = zip(fold["edges_vertices"], fold["edges_assignment"], strict=True)
    return [(letter, *points[u], *points[v]) for (u, v), letter in pairs]


READERS = {".svg": from_svg, ".cp": from_cp, ".dxf": from_dxf, ".full.fold": from_fold}


@every_pattern
@every_dialect
def test_the_same_creases_in_every_format(pattern: Pattern, dialect: Dialect, tmp_path: Path) -> None:
    path = write(tmp_path, dialect.write(pattern))
    origami_lab.export_design(path, "svg,dxf,cp,fold", tmp_path)
    true = [
        (letter, *pattern.flat[u], *pattern.flat[v])
        for (u, v), letter in zip(pattern.edges, pattern.letters, strict=True)
    ]
    turned = any(DIALECTS[name] is dialect for name in MOVED)
    for suffix, reader in READERS.items():
        segments = [s for s in reader(path.with_name("a" + suffix)) if s[0] in "BMV"]
        if turned:
            sizes = np.array([np.hypot(s[3] - s[1], s[4] - s[2]) for s in segments])
            wanted = np.array([np.hypot(s[3] - s[1], s[4] - s[2]) for s in true])
            assert Counter(s[0] for s in segments) == Counter(s[0] for s in true)
            assert np.allclose(sizes / sizes.sum(), wanted / wanted.sum(), atol=1e-6)
        else:
            assert normal_form(segments) == normal_form(true), suffix


@every_pattern
@every_dialect
def test_the_same_folded_sheet(pattern: Pattern, dialect: Dialect, tmp_path: Path) -> None:
    """Distances between folded vertices are those of the last state, whether read or folded by the solver."""
    path = write(tmp_path, dialect.write(pattern))
    if not dialect.folds:
        with pytest.raises(origami_lab.InputError, match="no fold angles"):
            origami_lab.export_design(path, "obj", tmp_path)
        return
    origami_lab.export_design(path, "obj", tmp_path)
    rows = [line.split() for line in path.with_suffix(".obj").read_text().splitlines() if line.startswith("v ")]
    coords = np.array([[float(number) for number in row[1:4]] for row in rows])[: len(pattern.flat)]
    apart, true = (np.linalg.norm(x[:, None] - x[None], axis=2) for x in (coords, pattern.folded[-1]))
    assert np.allclose(apart, true, atol=1e-7)
