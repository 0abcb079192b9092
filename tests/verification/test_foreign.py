"""Files of other programs: what they leave out, what they write in another way, and what cannot be decided."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import origami_lab
from origami_lab.verification.certificate import Certificate
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import foreign, known_design, miura_sheet, strip, write


def verified(tmp_path: Path, fold: dict[str, Any]) -> Certificate:
    return origami_lab.verify(write(tmp_path / "foreign.fold", fold))


MIURA = foreign(designs.miura())


def folded_only(fold: dict[str, Any], frame: int) -> dict[str, Any]:
    """One folded state as the only frame of the file."""
    state = fold["file_frames"][frame]
    alone = {key: value for key, value in fold.items() if key != "file_frames" and key != "edges_foldAngle"}
    return alone | {"frame_classes": ["foldedForm"], "vertices_coords": state["vertices_coords"]}


def test_several_frames(tmp_path: Path) -> None:
    certificate = verified(tmp_path, MIURA)
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["degrees of freedom"].numbers["freedoms"] == 1


@pytest.mark.parametrize("frame", [2, 5])
def test_one_folded_frame_is_unfolded_and_followed(tmp_path: Path, frame: int) -> None:
    certificate = verified(tmp_path, folded_only(MIURA, frame))
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["sheet valid"].numbers["panels"] == 4


def test_fold_angles_only(tmp_path: Path) -> None:
    fold = {key: value for key, value in MIURA.items() if key not in ("file_frames", "faces_vertices", "edges_faces")}
    certificate = verified(tmp_path, fold)
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["sheet valid"].numbers["panels"] == 4  # found between the edges
    assert certificate["motion"].numbers["to"] == pytest.approx(max(map(abs, MIURA["edges_foldAngle"])), rel=1e-9)


def test_a_miura_sheet_has_one_freedom(tmp_path: Path) -> None:
    """More loops than unknowns: 25 vertices, 60 creases, and yet it moves."""
    certificate = verified(tmp_path, miura_sheet(6, 6, 60.0, 60.0))
    assert certificate.exit_code == 0, certificate.words()
    numbers = certificate["degrees of freedom"].numbers
    assert (numbers["creases"], numbers["freedoms"], numbers["freedoms_when_driven"]) == (60, 1, 0)
    assert certificate["flat-foldable"].numbers == {"vertices": 25, "kawasaki_fails": [], "maekawa_fails": []}
    skewed = miura_sheet(6, 6, 60.0, 60.0)
    skewed["edges_foldAngle"] = [0.99 * angle for angle in skewed["edges_foldAngle"]]
    assert verified(tmp_path, skewed).reason.startswith("loops close")


def test_frames_inherit_from_frames(tmp_path: Path) -> None:
    fold = copy.deepcopy(MIURA)
    later = fold["file_frames"][4]
    later["frame_parent"] = 1  # all that it takes over is what frame 0 says, too
    del later["edges_foldAngle"]
    own = {key: fold[key] for key in ("edges_vertices", "edges_assignment", "faces_vertices")}
    fold["file_frames"][2] |= own | {"frame_inherit": False}
    assert verified(tmp_path, fold).exit_code == 0
    fold["file_frames"][4]["vertices_coords"][2][2] += 0.01
    assert verified(tmp_path, fold).exit_code == 1


def test_other_numbering(tmp_path: Path) -> None:
    """Clockwise faces, edges the other way round, no assignments, z = 0 written out."""
    fold = copy.deepcopy(MIURA)
    fold["faces_vertices"] = [face[::-1] for face in fold["faces_vertices"]]
    fold["edges_vertices"] = [edge[::-1] for edge in fold["edges_vertices"]]
    fold["vertices_coords"] = [[*point, 0] for point in fold["vertices_coords"]]
    for frame in (fold, *fold["file_frames"]):
        frame.pop("edges_assignment", None)
    fold.pop("edges_faces")
    assert verified(tmp_path, fold).exit_code == 0


def test_turned_and_moved(tmp_path: Path) -> None:
    fold = copy.deepcopy(MIURA)
    rng = np.random.default_rng(0)
    for frame in fold["file_frames"]:
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
        frame["vertices_coords"] = (np.array(frame["vertices_coords"]) @ turn + rng.normal(size=3)).tolist()
    assert verified(tmp_path, fold).exit_code == 0


def test_six_digits(tmp_path: Path) -> None:
    fold = copy.deepcopy(MIURA)
    for frame in (fold, *fold["file_frames"]):
        for key in ("vertices_coords", "edges_foldAngle"):
            frame[key] = np.round(frame[key], 6 if key == "vertices_coords" else 3).tolist()
    assert verified(tmp_path, fold).exit_code == 0


def undecided(certificate: Certificate, why: str) -> None:
    assert certificate.verdict == "not certifiable", certificate.words()
    assert why in certificate.reason
    assert certificate.exit_code == 3


@pytest.mark.parametrize("angles", ["none", "zero", "null"])
def test_a_flat_sheet_alone(tmp_path: Path, angles: str) -> None:
    fold = {key: value for key, value in MIURA.items() if key != "file_frames"}
    count = len(fold["edges_vertices"])
    fold["edges_foldAngle"] = {"zero": [0] * count, "null": [None] * count}.get(angles)
    if angles == "none":
        del fold["edges_foldAngle"]
    undecided(verified(tmp_path, fold), "at the flat one motions branch")


def test_more_freedoms_than_one(tmp_path: Path) -> None:
    undecided(verified(tmp_path, foreign(known_design("pyramid"))), "does not say which creases are driven")


def test_cuts_and_holes(tmp_path: Path) -> None:
    fold = copy.deepcopy(MIURA)
    fold["edges_assignment"][0] = "C"
    undecided(verified(tmp_path, fold), "cut")
    outer, inner = [(-3, -3), (3, -3), (3, 3), (-3, 3)], [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    ring = [(i, (i + 1) % 4) for i in range(4)]
    edges = ring + [(4 + i, 4 + j) for i, j in ring] + [(i, 4 + i) for i in range(4)]
    frame = {
        "vertices_coords": [*outer, *inner],
        "edges_vertices": edges,
        "edges_assignment": ["B"] * 8 + ["V"] * 4,
        "edges_foldAngle": [0] * 8 + [10] * 4,
    }
    certificate = verified(tmp_path, frame)
    assert certificate["sheet valid"].numbers["panels"] == 4
    assert [set(hole) for hole in certificate["sheet valid"].numbers["holes"]] == [{4, 5, 6, 7}]
    undecided(certificate, "hole")


def test_a_dead_point_is_not_passed() -> None:
    """A parallelogram of collinear creases folded flat: the last state lies where motions branch."""
    certificate = origami_lab.verify(strip((1.0, 2.0, 1.0), (1, -1), [60.0, 180.0]))
    assert certificate.exit_code in (0, 3)  # three panels in two directions: touching at 180° is contact
    assert certificate["coplanar contact"].numbers["pairs"]


def test_one_state_beyond_a_crossing_is_refuted_by_the_state(tmp_path: Path) -> None:
    fold = foreign(strip((1.0, 1.0, 1.0, 1.5), (1, 1, 1), [100.0]))
    certificate = verified(tmp_path, fold)
    assert certificate.exit_code == 1
    assert certificate.panels == (0, 3)


def test_flat_edges_of_a_triangulation_are_held(tmp_path: Path) -> None:
    """A facet line across a panel, marked F, is no hinge."""
    fold = copy.deepcopy(foreign(designs.single_valley()))
    fold["edges_vertices"].append([0, 4])
    fold["edges_assignment"].append("F")
    fold["faces_vertices"] = [[0, 1, 4], [0, 4, 5], [1, 2, 3, 4]]
    fold.pop("edges_faces")
    for frame in (fold, *fold["file_frames"]):
        frame["edges_foldAngle"].append(0.0)
        if frame is not fold:
            frame.pop("edges_assignment", None)
    certificate = verified(tmp_path, fold)
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["degrees of freedom"].numbers["flat_edges_held"] == 1
