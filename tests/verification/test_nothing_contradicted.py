"""Files that claim no more than can be true: not certifiable for want of something, and never refuted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import origami_lab

SQUARE = {
    "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0]],
    "edges_assignment": ["B"] * 4,
}
# the preliminary base: a square of side 2 with eight creases around its middle, Maekawa's five and three
POINTS = [[0, 0], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]]
LETTERS = [*"BBBBBBBB", *"VMVMVVVM"]
BASE = {
    "vertices_coords": POINTS,
    "edges_vertices": [[i, i % 8 + 1] for i in range(1, 9)] + [[0, i] for i in range(1, 9)],
    "edges_assignment": LETTERS,
    "faces_vertices": [[0, i, i % 8 + 1] for i in range(1, 9)],
}
FLAT = {"vertices_coords": [[max(abs(x), abs(y)), min(abs(x), abs(y))] for x, y in POINTS]}
"""Folded: all eight triangles upon one."""
CUBE = [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
PATTERN, FOLDED = {"frame_classes": ["creasePattern"]}, {"frame_classes": ["foldedForm"]}
HEIR = {"frame_parent": 0, "frame_inherit": True}


def without(fold: dict[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in fold.items() if key not in keys}


FILES: dict[str, dict[str, Any]] = {
    "a square": PATTERN | SQUARE,
    "a square of no class": SQUARE,
    "a linkage": {"frame_classes": ["linkage"], "vertices_coords": POINTS[:3], "edges_vertices": [[0, 1], [1, 2]]},
    "a graph in space": {"frame_classes": ["graph"], "vertices_coords": CUBE, "edges_vertices": [[0, 6], [6, 2]]},
    "two squares": PATTERN
    | {
        "vertices_coords": [*SQUARE["vertices_coords"], [3, 0], [4, 0], [4, 1], [3, 1]],
        "edges_vertices": [[i, j] for k in (0, 4) for i, j in ((k, k + 1), (k + 1, k + 2), (k + 2, k + 3), (k + 3, k))],
        "edges_assignment": ["B"] * 8,
    },
    "two panels apart": FOLDED | {"vertices_coords": CUBE, "faces_vertices": [[0, 1, 2, 3], [4, 5, 6, 7]]},
    "folded flat, of no class": BASE | FLAT,
    "folded flat, of no class, no faces": without(BASE | FLAT, "faces_vertices"),
    "folded flat": FOLDED | BASE | FLAT,
    "folded flat, a state": PATTERN | BASE | {"file_frames": [HEIR | FOLDED | FLAT]},
    "folded flat, by angles": PATTERN
    | BASE
    | {"edges_foldAngle": [180 * (x == "V") - 180 * (x == "M") for x in LETTERS]},
    "letters only": PATTERN | BASE,
    "no letters": PATTERN | without(BASE, "edges_assignment"),
    "unassigned": PATTERN | BASE | {"edges_assignment": [*"BBBBBBBBUUUUUUUU"]},
    "cuts": PATTERN | BASE | {"edges_assignment": [*"BBBBBBBBVMVMVVVC"]},
    "a border of cuts": PATTERN | BASE | {"edges_assignment": [*"CCCCCCCC", *LETTERS[8:]]},
    "a border that is not marked": PATTERN | BASE | {"edges_assignment": [*"UUUUFFFF", *LETTERS[8:]]},
    "an empty state": PATTERN | BASE | {"file_frames": [FOLDED]},
    "a state with layers only": PATTERN | BASE | {"file_frames": [HEIR | FOLDED | {"faceOrders": [[0, 1, 1]]}]},
    "half of the angles": PATTERN | BASE | {"edges_foldAngle": [0] * 8 + [90, None] * 4},
    "two patterns": {"file_classes": ["multiModel"], "file_frames": [PATTERN | SQUARE, PATTERN | BASE]},
}


@pytest.mark.parametrize("fold", FILES.values(), ids=FILES)
def test_not_certifiable(fold: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "a.fold").write_text(json.dumps(fold), encoding="utf-8")
    certificate = origami_lab.verify(tmp_path / "a.fold")
    assert certificate.verdict == "not certifiable", certificate.words()
