"""FOLD files: what they say is recomputed from what they draw, and wrong ones are refused in one line."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.fold_format.writer import read_fold, to_fold, write_fold
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs

DESIGNS: dict[str, Callable[[], CreasePattern]] = {
    "valley": designs.single_valley,
    "degree 4 A": designs.degree_four,
    "degree 4 B": lambda: designs.degree_four(mode="B", best=9),
    "miura": designs.miura,
    "pyramid": designs.pyramid,
}
every_design = pytest.mark.parametrize("make", DESIGNS.values(), ids=DESIGNS)


def polygon_area(points: np.ndarray) -> float:
    x, y = points.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


@every_design
def test_key_frame_is_the_flat_pattern(make: Callable[[], CreasePattern]) -> None:
    design = make()
    fold = to_fold(design)
    assert fold["file_spec"] == 1.2
    assert fold["file_classes"] == ["singleModel", "animation"]
    assert fold["frame_classes"] == ["creasePattern"]
    assert fold["frame_attributes"] == ["2D", "manifold", "orientable", "noCuts"]
    # what Origami Simulator requires, and what it would ask for in a dialog
    assert {"vertices_coords", "edges_vertices", "edges_assignment", "faces_vertices", "edges_foldAngle"} <= {*fold}
    assert all(len(point) == 2 for point in fold["vertices_coords"])
    for letter, angle in zip(fold["edges_assignment"], fold["edges_foldAngle"], strict=True):
        assert -180.0 <= angle <= 180.0
        assert np.sign(angle) == {"M": -1, "V": 1, "F": 0, "B": 0}[letter]
    points = np.array(fold["vertices_coords"])
    assert all(polygon_area(points[panel]) > 0 for panel in fold["faces_vertices"])
    assert not any("nonSelfIntersecting" in str(value) for value in fold.values())


@every_design
def test_every_edge_knows_its_panels(make: Callable[[], CreasePattern]) -> None:
    fold = to_fold(make())
    for (u, v), letter, faces in zip(
        fold["edges_vertices"], fold["edges_assignment"], fold["edges_faces"], strict=True
    ):
        assert len(faces) == (1 if letter == "B" else 2)
        for face, side in zip(faces, (1, -1), strict=False):
            ring = fold["faces_vertices"][face]
            step = (ring.index(v) - ring.index(u)) % len(ring)
            assert step in (1, len(ring) - 1)
            if len(faces) == 2:  # the left one runs along the edge, the right one against it
                assert step == (1 if side == 1 else len(ring) - 1)


@every_design
def test_angles_agree_with_the_folded_coordinates(make: Callable[[], CreasePattern]) -> None:
    design = make()
    fold = to_fold(design)
    frames = fold["file_frames"]
    assert len(frames) == 10
    for frame in frames:
        assert frame["frame_parent"] == 0
        assert frame["frame_inherit"] is True
        assert frame["frame_classes"] == ["foldedForm"]
        points = np.array(frame["vertices_coords"])
        assert points.shape == (len(design.vertices), 3)
        letters = frame.get("edges_assignment", fold["edges_assignment"])
        for e, (u, v) in enumerate(fold["edges_vertices"]):
            if letters[e] == "B":
                continue
            left, right = (fold["faces_vertices"][face] for face in fold["edges_faces"][e])
            measured = np.degrees(designs.signed_angle(points, u, v, left, right))
            assert frame["edges_foldAngle"][e] == pytest.approx(measured, abs=1e-6)
            assert letters[e] == ("V" if measured > 0 else "M")
    assert fold["edges_foldAngle"] == frames[-1]["edges_foldAngle"]


def test_the_best_angle_comes_last() -> None:
    fold = to_fold(designs.pyramid(best=5))
    degrees = [frame["origami_lab:driving_angle"] for frame in fold["file_frames"]]
    expected = [np.degrees(3.14 * k / 10) for k in (1, 2, 3, 4, 5, 7, 8, 9, 10, 6)]
    assert degrees == pytest.approx(expected)
    assert fold["origami_lab:actions"] == [3, 1, 4]
    assert fold["vertices_origami_lab:mode"] == [-1] * 4 + [0] * 8
    driven = [edge for edge, d in zip(fold["edges_vertices"], fold["edges_origami_lab:driven"], strict=True) if d]
    assert sorted(driven) == [[0, 1], [0, 3], [1, 2], [2, 3]]


def test_an_asymmetric_vertex_is_not_mirrored(tmp_path: Path) -> None:
    write_fold(tmp_path / "a.fold", designs.degree_four())
    fold = read_fold(tmp_path / "a.fold")
    # Crease 1 leaves at 70° with length 3. Crease 0, along x, is a valley with the fixed panel on its right
    # (y < 0): the panel on its left must come up, towards z > 0, and crease 1 with it.
    assert fold.vertices[2] == pytest.approx([3 * np.cos(np.radians(70)), 3 * np.sin(np.radians(70))])
    rho = 3.14 * 0.4
    lifted = 3 * np.array(
        [np.cos(np.radians(70)), np.sin(np.radians(70)) * np.cos(rho), np.sin(np.radians(70)) * np.sin(rho)]
    )
    assert fold.best.driving_angle == pytest.approx(rho)
    assert fold.best.coords[2] == pytest.approx(lifted)


def test_a_crease_that_changes_sign_has_its_own_letters() -> None:
    design = designs.single_valley()
    turned = design.fold_angles.copy()
    turned[0] *= -1.0
    turned[1] = 0.0
    design = dataclasses.replace(design, fold_angles=turned, folded=np.copy(design.folded))
    fold = to_fold(design)
    crease = [e for e, letter in enumerate(fold["edges_assignment"]) if letter == "V"]
    assert [fold["file_frames"][k]["edges_assignment"][crease[0]] for k in (0, 1)] == ["M", "F"]
    assert fold["file_frames"][1]["edges_foldAngle"][crease[0]] == 0.0
    assert all("edges_assignment" not in frame for frame in fold["file_frames"][2:])


@every_design
def test_round_trip(make: Callable[[], CreasePattern], tmp_path: Path) -> None:
    design = make()
    path = tmp_path / "best.fold"
    write_fold(path, design)
    assert [item.name for item in tmp_path.iterdir()] == ["best.fold"]
    assert json.loads(path.read_text()) == to_fold(design)
    assert "-0.0," not in path.read_text()
    assert max(len(line) for line in path.read_text().splitlines()) <= 110
    fold = read_fold(path)
    order = [k for k in range(10) if k != design.best] + [design.best]
    assert np.array_equal(fold.vertices, design.vertices)
    assert np.array_equal(fold.edges, design.edges)
    assert fold.assignments == design.assignments
    assert fold.panels == design.panels
    assert fold.modes is not None
    assert fold.driven is not None
    assert np.array_equal(fold.modes, design.modes)
    assert np.array_equal(fold.driven, design.driven)
    assert fold.actions == design.actions
    assert fold.metadata == design.metadata
    assert np.array_equal([frame.coords for frame in fold.frames], design.folded[order])
    assert np.allclose([frame.driving_angle for frame in fold.frames], design.driving_angles[order], rtol=1e-15)
    assert np.allclose([frame.fold_angles for frame in fold.frames], design.fold_angles[order], atol=1e-15, rtol=1e-15)
    assert np.allclose(fold.fold_angles, design.fold_angles[design.best], atol=1e-15, rtol=1e-15)
    assert [frame.driving_angle for frame in fold.motion] == sorted(frame.driving_angle or 0 for frame in fold.frames)
    assert fold.best is fold.frames[-1]


@every_design
def test_what_was_read_is_written_the_same(make: Callable[[], CreasePattern], tmp_path: Path) -> None:
    write_fold(tmp_path / "a.fold", make())
    write_fold(tmp_path / "b.fold", read_fold(tmp_path / "a.fold"))
    assert (tmp_path / "b.fold").read_bytes() == (tmp_path / "a.fold").read_bytes()


def test_angles_survive_reading_and_writing(tmp_path: Path) -> None:
    design = designs.single_valley()
    for index, angle in enumerate(np.random.default_rng(0).uniform(-np.pi, np.pi, 200)):
        made = dataclasses.replace(design, fold_angles=np.where(design.boundary, 0.0, np.full((10, 7), angle)))
        write_fold(tmp_path / "a.fold", made)
        write_fold(tmp_path / "b.fold", read_fold(tmp_path / "a.fold"))
        assert (tmp_path / "b.fold").read_bytes() == (tmp_path / "a.fold").read_bytes(), index


def test_metadata_is_plain_json(tmp_path: Path) -> None:
    facts = MappingProxyType(
        {
            "task": "bowl",
            "search": "evo",
            "seed": np.int64(4),
            "return": -np.inf,
            "x": (np.float64(-0.0), None),
        }
    )
    write_fold(tmp_path / "a.fold", dataclasses.replace(designs.single_valley(), metadata=facts))
    fold = read_fold(tmp_path / "a.fold")
    assert fold.title == "bowl, evo, seed 4"
    assert fold.metadata == {"task": "bowl", "search": "evo", "seed": 4, "return": None, "x": [0.0, None]}


def test_a_design_that_is_not_finite_is_not_written(tmp_path: Path) -> None:
    design = designs.single_valley()
    folded = design.folded.copy()
    folded[2, 1, 0] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        write_fold(tmp_path / "a.fold", dataclasses.replace(design, folded=folded))
    assert not list(tmp_path.iterdir())


def change(**changes: Any) -> Callable[[dict[str, Any]], object]:
    return lambda fold: fold.update(changes)


MALFORMED: dict[str, Callable[[dict[str, Any]], object]] = {
    **{f"no {key}": lambda fold, key=key: fold.pop(key) for key in ("edges_vertices",)},
    "no vertices at all": lambda fold: [frame.pop("vertices_coords") for frame in (fold, *fold["file_frames"])],
    "not a list": change(vertices_coords={"0": [1, 2]}),
    "no vertices": change(vertices_coords=[]),
    "scalar vertices": change(vertices_coords=[1, 2, 3, 4, 5, 6]),
    "ragged": lambda fold: fold["vertices_coords"][1].extend([0.0, 0.0]),
    "not flat": lambda fold: fold["vertices_coords"][1].append(1.0),
    "text coordinate": lambda fold: fold["vertices_coords"].__setitem__(0, ["1", 2]),
    "true coordinate": lambda fold: fold["vertices_coords"].__setitem__(0, [True, 2]),
    "nan": lambda fold: fold["vertices_coords"].__setitem__(0, [float("nan"), 2]),
    "infinite angle": lambda fold: fold["edges_foldAngle"].__setitem__(0, float("inf")),
    "huge integer": lambda fold: fold["vertices_coords"].__setitem__(0, [10**400, 2]),
    "angle above 180": lambda fold: fold["edges_foldAngle"].__setitem__(0, 181.0),
    "edge out of range": lambda fold: fold["edges_vertices"].__setitem__(0, [0, 6]),
    "negative vertex": lambda fold: fold["edges_vertices"].__setitem__(0, [0, -1]),
    "fractional vertex": lambda fold: fold["edges_vertices"].__setitem__(0, [0, 1.5]),
    "edge of three": lambda fold: fold["edges_vertices"].__setitem__(0, [0, 1, 2]),
    "loop": lambda fold: fold["edges_vertices"].__setitem__(0, [1, 1]),
    "face out of range": lambda fold: fold["faces_vertices"][0].append(99),
    "face of two": lambda fold: fold["faces_vertices"].__setitem__(0, [0, 1]),
    "face is a number": lambda fold: fold["faces_vertices"].__setitem__(0, 7),
    "wrong letter": lambda fold: fold["edges_assignment"].__setitem__(0, "X"),
    "letter is a list": lambda fold: fold["edges_assignment"].__setitem__(0, ["B"]),
    "too few letters": lambda fold: fold["edges_assignment"].pop(),
    "mode": lambda fold: fold["vertices_origami_lab:mode"].__setitem__(0, 2),
    "driven": lambda fold: fold["edges_origami_lab:driven"].__setitem__(0, 1),
    "actions": change(**{"origami_lab:actions": [0.5]}),
    "metadata": change(**{"origami_lab:metadata": []}),
    "frames": change(file_frames=[1]),
    "frame short": lambda fold: fold["file_frames"][0]["vertices_coords"].pop(),
    "frame nan": lambda fold: fold["file_frames"][0]["vertices_coords"].__setitem__(0, [0, 0, float("nan")]),
    "frame angles": lambda fold: fold["file_frames"][0]["edges_foldAngle"].pop(),
    "frame parent": lambda fold: fold["file_frames"][0].update(frame_parent=33),
    "driving angle": lambda fold: fold["file_frames"][0].update({"origami_lab:driving_angle": "90"}),
}


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_fold(path)
    assert caught.value.field == str(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 250 + len(str(path))
    return message


@pytest.mark.parametrize("spoil", MALFORMED.values(), ids=MALFORMED)
def test_malformed(spoil: Callable[[dict[str, Any]], object], tmp_path: Path) -> None:
    fold = to_fold(designs.single_valley())
    spoil(fold)
    path = tmp_path / "bad.fold"
    path.write_text(json.dumps(fold))
    refused(path)


def test_deep_values_where_flat_ones_belong(tmp_path: Path) -> None:
    for key in ("vertices_coords", "faces_vertices", "edges_assignment", "file_title", "origami_lab:actions"):
        text = json.dumps({**to_fold(designs.single_valley()), key: "@"})
        for depth in (300, 900, 990, 5000):
            path = tmp_path / "deep.fold"
            path.write_text(text.replace('"@"', "[" * depth + "]" * depth))
            if key == "file_title" and depth < 990:
                assert read_fold(path).title == "crease pattern"
            elif key != "file_title":
                refused(path)


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b"3", b"null", b"\xff\xfe\x00\x01", b"[" * 100_000, b'{"a": ' * 100_000, b"1" * 5000],
    ids=["empty", "cut", "list", "number", "null", "binary", "deep list", "deep object", "long number"],
)
def test_not_fold_at_all(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bad.fold"
    path.write_bytes(content)
    refused(path)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert "No such file" in refused(tmp_path / "none.fold")
    refused(tmp_path)


def test_foreign_files(tmp_path: Path) -> None:
    """What other programs leave out or add: no keys of ours, z = 0 written out, other frames, null angles."""
    fold = to_fold(designs.single_valley())
    fold = {key: value for key, value in fold.items() if "origami_lab" not in key and key != "edges_faces"}
    fold["vertices_coords"] = [[*point, 0] for point in fold["vertices_coords"]]
    fold["edges_foldAngle"] = [angle or None for angle in fold["edges_foldAngle"]]
    fold["faces_vertices"][0].reverse()  # clockwise
    folded = fold["file_frames"][-1]
    del folded["edges_foldAngle"], folded["origami_lab:driving_angle"]
    fold["file_frames"] = [{"frame_classes": ["graph"]}, {"frame_classes": 3}, folded]
    path = tmp_path / "foreign.fold"
    path.write_text(json.dumps(fold), encoding="utf-8-sig")
    read = read_fold(path)
    assert read.modes is None
    assert read.driven is None
    assert all(polygon_area(read.vertices[list(panel)]) > 0 for panel in read.panels)
    assert len(read.frames) == 1
    assert read.best.driving_angle is None
    assert read.best.fold_angles == pytest.approx(read.fold_angles, abs=1e-12)  # measured
    assert read.metadata == {}
