"""The analysis of parts whose answer is known by hand, and that it does not depend on how a part is given."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.parts import shapes
from origami_lab.config.part_settings import settings_of
from origami_lab.lengths import MARGIN, SHEETS
from origami_lab.parts import PartAnalysis, analyse_part
from origami_lab.parts.corners import tucked_reach
from origami_lab.parts.words import facts, warnings
from origami_lab.targets import mesh

Array = NDArray[np.float64]

FLAT = ("l_bracket", "gutter", "gutter_caps", "box_lid", "flared_tray", "box_with_flaps", "corner_guard", "closed_box",
        "asymmetric_tray", "gable_roof")  # fmt: skip
CURVED = ("shallow_dome", "half_vault", "saddle", "hyperbolic_canopy", "lampshade", "car_seat")


def analysed(folder: Path, triangles: Array) -> PartAnalysis:
    file = folder / "part.stl"
    file.write_bytes(shapes.stl(triangles))
    return analyse_part(file)


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, PartAnalysis]:
    folder = tmp_path_factory.mktemp("parts")
    return {file.stem: analyse_part(file) for file in shapes.write_parts(folder)}


@pytest.mark.parametrize(
    ("name", "area", "bodies", "rims", "faces"),
    [
        ("l_bracket", 80 * 90, 1, 1, 2),
        ("gutter", 200 * 160, 1, 1, 3),
        ("box_lid", 120 * 80 + 2 * 200 * 20, 1, 1, 5),
        ("corner_guard", 3 * 60**2, 1, 1, 3),
        ("gable_roof", 2 * 120 * 50, 1, 1, 2),
        ("closed_box", 2 * (80 * 60 + 80 * 40 + 60 * 40), 1, 0, 6),
        ("lampshade", None, 1, 2, None),
    ],
)
def test_what_the_mesh_holds(
    parts: dict[str, PartAnalysis], name: str, area: float | None, bodies: int, rims: int, faces: int | None
) -> None:
    surface = parts[name].surface
    assert (surface.bodies, surface.rims) == (bodies, rims)
    if area is not None:
        assert surface.area == pytest.approx(area, rel=1e-6)
    if faces is not None:
        assert len(parts[name].regions) == faces
        assert parts[name].is_flat_faced
        assert sum(region.area for region in parts[name].regions) == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "symmetry"),
    [
        *(("l_bracket", "y"), ("gutter", "xy"), ("box_lid", "xy"), ("asymmetric_tray", "none"), ("gable_roof", "y")),
        *(("shallow_dome", "xyd"), ("half_vault", "xy"), ("saddle", "xy"), ("hyperbolic_canopy", "xy")),
        *(("lampshade", "xyd"), ("car_seat", "y")),
    ],
)
def test_symmetry_is_the_parts_own(parts: dict[str, PartAnalysis], name: str, symmetry: str) -> None:
    assert parts[name].setup.symmetry == symmetry


@pytest.mark.parametrize(
    ("name", "angle"),
    [
        *(("l_bracket", 90.0), ("gutter", 90.0), ("box_lid", 90.0), ("closed_box", 90.0 - 1e-4)),
        ("flared_tray", math.degrees(math.atan2(40, 30))),
        ("gable_roof", 2 * math.degrees(math.atan2(30, 40))),
    ],
)
def test_the_dihedral_angle_is_a_driving_angle(parts: dict[str, PartAnalysis], name: str, angle: float) -> None:
    setup = parts[name].setup
    tried = [setup.driving_angle_max * k / setup.driving_angle_count for k in range(1, setup.driving_angle_count + 1)]
    assert min(abs(one - angle) for one in tried) < 2e-5


@pytest.mark.parametrize("name", FLAT)
def test_floor_and_walls_lie_on_board_points(parts: dict[str, PartAnalysis], name: str) -> None:
    """The corners of the floor are those of the placed part in the plane of the sheet."""
    part = parts[name]
    assert part.layout is not None
    assert part.layout.is_exact
    target = part.target()
    floor = target.vertices[np.abs(target.vertices[:, 2]) < 1e-4]
    assert len(floor) >= 4
    np.testing.assert_allclose(floor, np.rint(floor), atol=1e-4)
    corners = np.array(part.setup.start.get("corners", part.setup.start.get("ends")))
    low, high = floor[:, :2].min(axis=0), floor[:, :2].max(axis=0)
    assert (corners >= low - 1e-4).all()
    assert (corners <= high + 1e-4).all()
    half = (np.array(part.setup.board) - 1) // 2
    assert (np.abs(corners) < half).all()


@pytest.mark.parametrize("name", [*FLAT, *CURVED])
def test_the_settings_place_the_part_as_the_analysis_says(
    parts: dict[str, PartAnalysis], name: str, tmp_path: Path
) -> None:
    file = tmp_path / "part.stl"
    file.write_bytes(shapes.stl(shapes.PARTS[name]()))
    setup = parts[name].setup
    wide, high = setup.board
    target = mesh(file, setup.scale, setup.rotate, setup.translate, board_width=wide, board_height=high)
    ours = parts[name].target()
    assert target.area == pytest.approx(ours.area, rel=1e-6)
    for points in (target.vertices, ours.vertices):
        assert np.abs(points[:, :2]).max() < max(wide, high)
    np.testing.assert_allclose(
        np.sort(target.vertices, axis=0)[[0, -1]], np.sort(ours.vertices, axis=0)[[0, -1]], atol=1e-5
    )


@pytest.mark.parametrize(
    ("ahead", "up", "reach"),
    [(0, 2, 6), (0, 3, 6), (0, 10, 15), (0, 1, math.inf), (1, 1, 0)],
)
def test_paper_between_walls_is_tucked_on_board_points(ahead: float, up: float, reach: float) -> None:
    """A wall's crease moved in by θ: the tucked paper reaches h·tan(45° + θ) where both ends are board points."""
    assert tucked_reach(ahead, up, 30.0) == pytest.approx(reach)


def test_a_square_box_is_not_mirrored_in_its_diagonals(tmp_path: Path) -> None:
    """There the paper at a corner would have to be tucked behind both walls alike, which stands out."""
    part = analysed(tmp_path, shapes._box(60, 60, 20))
    assert part.frame.symmetry == "xyd"
    assert part.setup.symmetry == "xy"


def test_warnings_are_true(parts: dict[str, PartAnalysis]) -> None:
    said = {name: " ".join(warnings(part)) for name, part in parts.items()}
    assert "closed solid" in said["closed_box"]
    assert "no surface in its middle" in said["lampshade"]
    assert "1 hole" in said["lampshade"]
    assert said["l_bracket"] == said["box_lid"] == said["gutter"] == ""


def test_a_part_in_two_pieces_is_said(tmp_path: Path) -> None:
    part = analysed(tmp_path, np.concatenate([shapes.l_bracket(), shapes.l_bracket() + 500.0]))
    assert part.surface.bodies == 2
    assert any("2 pieces" in line for line in warnings(part))


def test_what_lies_under_an_overhang_is_covered(tmp_path: Path) -> None:
    """A pipe open at the top for a quarter of the way round: what hangs over covers as much on each side."""

    def pipe(u: Array, v: Array) -> tuple[Array, Array, Array]:
        angle = math.radians(270) * (v - 0.5)
        return 120 * u, 40 * np.sin(angle), -40 * np.cos(angle)

    part = analysed(tmp_path, shapes.patch(pipe, 6, 60))
    assert part.covered == pytest.approx(90 / 270, abs=0.03)
    assert any("33 %" in line or "34 %" in line or "32 %" in line for line in warnings(part))


def test_a_clip_begins_with_the_wall_that_holds_both_ends(tmp_path: Path) -> None:
    clip = np.concatenate([shapes.l_bracket(), shapes.flat([(0, 0, 40), (80, 0, 40), (80, 50, 40), (0, 50, 40)])])
    part = analysed(tmp_path, clip)
    assert part.frame.base is not None
    assert part.regions[part.frame.base].area == pytest.approx(80 * 40)
    assert part.setup.start["signs"].count(0) == 2


def test_faces_turned_over_in_the_file_are_no_matter(parts: dict[str, PartAnalysis], tmp_path: Path) -> None:
    triangles = shapes.shallow_dome()
    triangles[::3] = triangles[::3, ::-1]
    found, known = settings_of(analysed(tmp_path, triangles)), settings_of(parts["shallow_dome"])
    assert found["target.scale"] == pytest.approx(known["target.scale"])
    assert {**found, "target.scale": 0.0} == {**known, "target.scale": 0.0}


moved = st.fixed_dictionaries(
    {
        "turn": st.tuples(*[st.floats(-180, 180)] * 3),
        "shift": st.tuples(*[st.floats(-3, 3)] * 3),
        "unit": st.sampled_from([1.0, 0.001, 0.1, 1 / 25.4, 1000.0]),
    }
)


def _rough(part: PartAnalysis) -> tuple[object, ...]:
    """What does not depend on the unit: symmetry, board, start pattern, angles, creases."""
    setup = replace(part.setup, scale=0.0, rotate=(0, 0, 0), translate=(0, 0, 0))
    return (setup.symmetry, setup.start, setup.board, setup.max_crease_length, round(setup.driving_angle_max, 3))


@pytest.mark.parametrize("name", [*FLAT, *CURVED])
@settings(max_examples=2, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(change=moved)
def test_a_moved_part_is_set_up_alike(
    parts: dict[str, PartAnalysis], tmp_path: Path, name: str, change: dict[str, tuple[float, ...]]
) -> None:
    """Turned, shifted, in other units, and rounded to float32 by the file."""
    triangles = shapes.PARTS[name]()
    size = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    turned = Rotation.from_euler("xyz", change["turn"], degrees=True).apply(triangles.reshape(-1, 3))
    unit = float(change["unit"])  # type: ignore[arg-type]
    given_part = ((turned + size * np.array(change["shift"])) * unit).reshape(-1, 3, 3)
    part, known = analysed(tmp_path, given_part), parts[name]
    assert _rough(part) == _rough(known)
    assert part.setup.scale * unit == pytest.approx(known.setup.scale, rel=1e-4)
    placed, before = part.target(), known.target()
    assert placed.area == pytest.approx(before.area, rel=1e-4)
    for axis in range(3):
        ends = [np.sort(target.vertices[:, axis])[[0, -1]] for target in (placed, before)]
        np.testing.assert_allclose(ends[0], ends[1], atol=2e-3)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("l_bracket", "floor and walls met exactly"),
        ("box_lid", "where walls meet"),
        ("box_with_flaps", "what hangs on the walls only nearly"),
        ("bent_bracket", "but for their rounded edges"),
        ("shallow_dome", "near it, not exact"),
    ],
)
def test_what_to_expect_and_what_paper_it_takes(name: str, words: str, tmp_path: Path) -> None:
    (file := tmp_path / f"{name}.stl").write_bytes(shapes.stl(shapes.PARTS[name]()))
    part = analyse_part(file)
    told = dict(facts(part))
    assert words in told["expect"]
    sides = sorted((points - 1) * part.cell for points in part.setup.board)
    size = re.search(r"sheet=(A\d);", told["paper"])
    assert size is not None
    held = [all(a <= b - 2 * MARGIN for a, b in zip(sides, SHEETS[f"A{k}"], strict=True)) for k in range(7)]
    assert held.index(False) - 1 == int(size[1][1]) if False in held else size[1] == "A6"
