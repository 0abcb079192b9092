"""Each planted fault is refuted, for what it is."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import origami_lab
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.moves import Extend, Move, Place, Source, Terminate
from origami_lab.game.start_patterns import Square
from origami_lab.geometry.triangles import triangles_cross
from origami_lab.verification.certificate import Certificate
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import changed, foreign, known_design, strip, write

CREASES = [e for e, outer in enumerate(known_design("pyramid").boundary) if not outer]
HAT = ((3.0, 1.0, 1.0, 1.0, 3.0), (1, -1, -1, 1))
"""A strip whose last panel stays level with the first and comes nearer by 2(1 − cos ρ)."""


def verified(tmp_path: Path, fold: dict[str, Any]) -> Certificate:
    return origami_lab.verify(write(tmp_path / "planted.fold", fold))


def refuted(certificate: Certificate, name: str) -> Certificate:
    assert certificate.verdict == "refuted", certificate.words()
    assert certificate.reason.startswith(name), certificate.words()
    assert certificate.exit_code == 1
    return certificate


def test_nothing_planted(tmp_path: Path) -> None:
    assert verified(tmp_path, changed(known_design("pyramid"), lambda fold: None)).exit_code == 0


@pytest.mark.parametrize("frame", [0, 5])
def test_a_panel_bent_by_a_thousandth(tmp_path: Path, frame: int) -> None:
    design = known_design("pyramid")
    (base,) = (index for index, panel in enumerate(design.panels) if len(panel) == 4)

    def bend(fold: dict[str, Any]) -> None:
        fold["file_frames"][frame]["vertices_coords"][design.panels[base][0]][2] += 1e-3

    certificate = refuted(verified(tmp_path, changed(design, bend)), "panels rigid")
    assert design.panels[base][0] in design.panels[certificate["panels rigid"].numbers["panel"]]


@pytest.mark.filterwarnings("error")
def test_a_crease_folded_to_a_point(tmp_path: Path) -> None:
    design = known_design("pyramid")

    def shrink(fold: dict[str, Any]) -> None:
        coords = fold["file_frames"][2]["vertices_coords"]
        u, v = fold["edges_vertices"][CREASES[0]]
        coords[u] = list(coords[v])

    refuted(verified(tmp_path, changed(design, shrink)), "panels rigid")


@pytest.mark.parametrize("edge", CREASES[::3])
@pytest.mark.parametrize("where", ["frame", "key", "only angles"])
def test_a_fold_angle_off_by_a_degree(tmp_path: Path, edge: int, where: str) -> None:
    def turn(fold: dict[str, Any]) -> None:
        target = fold["file_frames"][2] if where == "frame" else fold
        target["edges_foldAngle"][edge] += 1.0
        if where == "only angles":  # then nothing but the loops can tell
            del fold["file_frames"]

    name = "loops close" if where == "only angles" else "fold angles"
    certificate = refuted(verified(tmp_path, changed(known_design("pyramid"), turn)), name)
    if where != "only angles":
        assert certificate[name].numbers["edge"] == edge


def test_a_mountain_called_valley(tmp_path: Path) -> None:
    def swap(fold: dict[str, Any]) -> None:
        fold["edges_assignment"] = [{"M": "V", "V": "M"}.get(x, x) for x in fold["edges_assignment"]]

    refuted(verified(tmp_path, changed(known_design("pyramid"), swap)), "fold angles")


def test_a_vertex_that_does_not_close(tmp_path: Path) -> None:
    fold = foreign(designs.degree_four())
    del fold["file_frames"]
    tilted = fold["edges_vertices"].index([0, 2])
    fold["edges_foldAngle"][tilted] *= 0.9
    certificate = refuted(verified(tmp_path, fold), "loops close")
    assert certificate["loops close"].numbers["vertex"] == 0


def test_edges_that_cross(tmp_path: Path) -> None:
    def cross(fold: dict[str, Any]) -> None:
        fold["vertices_coords"][4] = [0.5, -2.0]  # a flap's tip beyond the square

    assert "cross" in refuted(verified(tmp_path, changed(designs.pyramid(), cross)), "sheet valid").reason


def overlapping(fold: dict[str, Any]) -> None:
    fold["faces_vertices"].append([8, 1, 2, 9])


def twice(fold: dict[str, Any]) -> None:
    del fold["file_frames"]
    for key in [key for key in fold if key.startswith("edges_")]:
        fold[key].append(fold[key][0])


SHEETS = {
    "same vertices": lambda fold: fold["vertices_coords"].__setitem__(8, fold["vertices_coords"][4]),
    "edge twice": twice,
    "vertex on an edge": lambda fold: fold["vertices_coords"].__setitem__(8, [-0.5, 2.5]),
    "panel missing": lambda fold: fold["faces_vertices"].pop(4),
    "panel twice": lambda fold: fold["faces_vertices"].append(fold["faces_vertices"][0]),
    "panel that is none": overlapping,
    "crease called boundary": lambda fold: fold["edges_assignment"].__setitem__(CREASES[0], "B"),
    "boundary called crease": lambda fold: fold.update(
        edges_assignment=["V" if letter == "B" else letter for letter in fold["edges_assignment"]]
    ),
}  # fmt: skip


@pytest.mark.parametrize("spoil", SHEETS.values(), ids=SHEETS)
def test_no_sheet(tmp_path: Path, spoil: Any) -> None:
    refuted(verified(tmp_path, changed(designs.pyramid(best=2), spoil)), "sheet valid")


@pytest.mark.parametrize("name", ["pyramid", "cube"])
def test_a_freedom_that_no_driven_crease_ties(tmp_path: Path, name: str) -> None:
    def loosen(fold: dict[str, Any]) -> None:
        key = "edges_origami_lab:driven"
        fold[key][fold[key].index(True)] = False

    certificate = refuted(verified(tmp_path, changed(known_design(name), loosen)), "degrees of freedom")
    assert certificate["degrees of freedom"].numbers["freedoms_when_driven"] == 1


def test_sliding_into_each_other_in_one_plane() -> None:
    """Coplanar, and no contact: level panels meet edge on, 0.5 nearer than in the flat sheet."""
    certificate = refuted(origami_lab.verify(strip(*HAT, [15.0, 30.0, 45.0, 60.0], tab=(3.5, 0.2))), "crossing")
    assert certificate.panels == (0, 4)
    assert "in one plane" in certificate.reason
    assert certificate.angle == pytest.approx(math.degrees(math.acos(0.75)), abs=0.05)
    before = origami_lab.verify(strip(*HAT, [15.0, 30.0, 41.0], tab=(3.5, 0.2)))
    assert before.exit_code == 0
    assert before["clearance"].numbers["clearance"] == pytest.approx(0.5 - 2 * (1 - math.cos(math.radians(41.0))))


def test_folding_past_half_a_turn() -> None:
    """Two panels pass through each other at their crease where its angle passes 180°, between two states."""
    design = designs.pyramid()
    certificate = refuted(origami_lab.verify(design), "crossing")
    assert certificate.angle == pytest.approx(math.degrees(math.acos(-1 / 3)), abs=1e-3)


TUNNELS = [
    ("xy", 1, 4, 5, [Extend((-1, 1), -1, (-6, 5), (-5, 0), (-4, 2)), Source((-6, 5), "start", -1)]),
    ("x", 2, 3, 4, [Extend((-2, 2), -1, (0, 4), (-4, 3), (-2, 3)), Extend((0, 4), -1, (4, 4), (-3, 5), (-1, 5))]),
]


@pytest.mark.parametrize(("symmetry", "half", "free", "reach", "moves"), TUNNELS, ids=["xy", "x"])
def test_crossing_between_two_of_the_ten_angles_only(
    symmetry: str, half: int, free: int, reach: int, moves: list[Move]
) -> None:
    """The game's ten angles see nothing; a plain check of a thousand states does, in the same place."""
    game = Game(13, symmetry, Square(half))
    actions = game.finished_actions(game.replay_moves([Place(half, 1), *moves, Terminate()]))
    design = game.design(actions)
    assert len(design.driving_angles) == reach
    certificate = refuted(origami_lab.verify(design), "crossing")
    fine = game.motion(actions, np.linspace(0.0, game.angles[reach - 1], 1001)[1:], {})
    seen = [bool(crossing_pairs(fine, k)) for k in range(1000)]
    first = float(np.degrees(fine.driving_angles[seen.index(True)]))
    assert not seen[-1]
    assert np.degrees(game.angles[free - 1]) < first < np.degrees(game.angles[free])
    assert certificate.angle == pytest.approx(first, abs=0.1)
    assert certificate.angle <= first + 1e-3
    assert certificate.panels in crossing_pairs(fine, seen.index(True))


def crossing_pairs(design: CreasePattern, k: int) -> set[tuple[int, int]]:
    """Panels without a common edge that cross at a state, by the game's triangle test."""
    found = set()
    for i, p in enumerate(design.triangles):
        for j, q in enumerate(design.triangles[:i]):
            if len({*p.tolist()} & {*q.tolist()}) < 2 and triangles_cross(
                design.folded[k][p], design.folded[k][q], 1e-9
            ):
                found.add(tuple(sorted((int(design.triangle_panels[i]), int(design.triangle_panels[j])))))
    return found


def test_curling_up() -> None:
    """A strip of equal panels folded by ρ each: the fourth reaches the first where a square closes, 90°."""
    widths, signs = (1.0, 1.0, 1.0, 1.5), (1, 1, 1)
    certificate = refuted(origami_lab.verify(strip(widths, signs, [40.0, 80.0, 100.0])), "crossing")
    assert certificate.panels == (0, 3)
    assert certificate.angle == pytest.approx(90.0, abs=1e-3)
    assert origami_lab.verify(strip(widths, signs, [40.0, 80.0, 89.9])).exit_code == 0


def test_thickness() -> None:
    """The free end of a strip that curls up nearly to a square comes near its other end."""
    design = strip((1.0, 1.0, 1.0, 1.0), (1, 1, 1), [40.0, 80.0])
    gap = origami_lab.verify(design)["clearance"].numbers["clearance"]
    x, _, z = design.folded[-1][8]  # the corner nearest to the first panel, 0 ≤ x ≤ 1 in z = 0
    assert gap == pytest.approx(math.hypot(max(-x, x - 1.0, 0.0), z), rel=1e-9)
    assert origami_lab.verify(design, thickness=0.99 * gap).exit_code == 0
    refuted(origami_lab.verify(design, thickness=1.01 * gap), "clearance")
