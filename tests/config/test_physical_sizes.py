"""Lengths in settings: what a cell is on paper, what a return in a unit is, and which distance leads."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import build_objective, build_parts
from origami_lab.config.physical_size import aimed_return, millimetres_per_cell, thickness_in_cells
from origami_lab.config.resumed_settings import like_begun
from origami_lab.config.warnings import remarks
from origami_lab.errors import InputError
from origami_lab.lengths import millimetres, split_amount


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A box of 40 × 30 × 20 units, closed."""
    file = tmp_path_factory.mktemp("part") / "part.stl"
    trimesh.creation.box((40.0, 30.0, 20.0)).export(file)
    return file


AS_GIVEN = ("target.scale=1", "board.size=25")
"""A part whose size and board are not chosen for it."""


def settings(*words: str) -> Any:
    return compose_settings(words)


@given(st.floats(1e-6, 1e4), st.sampled_from([("", 1.0), ("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4)]))
def test_lengths_have_the_units_of_the_world(number: float, unit: tuple[str, float]) -> None:
    word, factor = unit
    expected = number * factor
    assert millimetres(f"{number!r}{word}") == (pytest.approx(expected) if 0 < expected <= 10_000 else None)
    assert millimetres(f" {number!r} {word} ") == millimetres(f"{number!r}{word}")


@pytest.mark.parametrize(
    "text",
    ["", "mm", "-5mm", "0", "5 5mm", "5mm5", "nan", "inf", "1e999", "5yd", None, True, [5], "٥mm", "9" * 99, 10**400],
)
def test_what_is_no_length(text: Any) -> None:
    assert millimetres(text) is None


def test_underscores_and_exponents_are_read() -> None:
    assert split_amount("1_000mm") == (1000.0, "mm")
    assert split_amount("2e-1cm") == (0.2, "cm")
    assert split_amount("-.5%") == (-0.5, "%")


@pytest.mark.parametrize(
    ("words", "cell"),
    [
        (("cell=5mm",), 5.0),
        (("cell=0.5cm",), 5.0),
        (("cell=5",), 5.0),
        # 24 cells and 20 mm of margins on 210 mm
        (("sheet=A4",), 7.91),
        # 24 × 12 cells: the long side lies along the sheet's
        (("sheet=A4", "board.height=13", "symmetry=xy"), 11.54),
        (("sheet=200x140mm", "board.height=13", "symmetry=xy"), 7.5),
        (("sheet=a4", "cell=7.9"), 7.9),
    ],
)
def test_a_cell_on_paper(words: tuple[str, ...], cell: float) -> None:
    found = settings("target=bowl", *words)
    assert found.cell == pytest.approx(cell)
    # what the run writes down makes the same again
    assert math.isclose(millimetres(found.config["cell"]) or 0.0, cell)


def test_a_mesh_is_as_large_as_its_file_says(part: Path) -> None:
    for words, cells in ((("cell=2.5mm",), 16.0), (("cell=5mm", "target.scale=2"), 16.0), (("cell=5mm",), 8.0)):
        found = settings("target=mesh", f"target.path={part}", *words)
        target, _ = build_objective(found)
        assert target is not None
        assert np.ptp(target.vertices[:, 0]) == pytest.approx(cells)
        assert target.units_per_cell == pytest.approx(40 / cells)


def test_a_sheet_decides_how_large_a_part_is_folded(part: Path) -> None:
    """The largest cell at which its board fits; on the board it lies as without a sheet."""
    words = ("target=mesh", f"target.path={part}")
    found, plain = settings(*words, "sheet=150x150mm"), settings(*words)
    sides = found.game.width - 1, found.game.height - 1
    assert found.cell == pytest.approx(130 / max(sides), abs=0.01)
    assert found.cell * max(sides) <= 130
    targets = [build_objective(one)[0] for one in (found, plain)]
    assert targets[0] is not None
    assert targets[1] is not None
    np.testing.assert_allclose(targets[0].vertices, targets[1].vertices, rtol=0, atol=1e-9)


def test_gltf_is_in_metres(tmp_path: Path) -> None:
    file = tmp_path / "part.glb"
    trimesh.creation.box((0.04, 0.03, 0.02)).export(file)
    target, _ = build_objective(settings("target=mesh", f"target.path={file}", "cell=2.5mm"))
    assert target is not None
    assert np.ptp(target.vertices[:, 0]) == pytest.approx(16.0, rel=1e-5)


def test_a_mesh_that_fits_the_board_is_printed_at_any_size(part: Path) -> None:
    words = ("target=mesh", f"target.path={part}", "target.fit=board")
    plain, printed = settings(*words), settings(*words, "cell=5mm")
    targets = [build_objective(found)[0] for found in (plain, printed)]
    assert targets[0] is not None
    assert targets[1] is not None
    np.testing.assert_array_equal(targets[0].vertices, targets[1].vertices)
    assert millimetres_per_cell(plain, targets[0]) == targets[0].units_per_cell
    assert millimetres_per_cell(printed, targets[1]) == 5.0
    assert any("5 mm on paper" in line for line in remarks(printed, build_parts(printed)))


def test_a_mesh_too_large_for_its_cell_is_said_by_the_cell(part: Path) -> None:
    with pytest.raises(InputError, match=r"^cell=0\.5mm: makes the mesh 80 cells large"):
        build_objective(settings("target=mesh", f"target.path={part}", "cell=0.5mm", *AS_GIVEN))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("0.4", -0.4),
        ("-0.4", -0.4),
        ("0.4cells", -0.4),
        # the box is 40 units long and 16 cells
        ("10%", -1.6),
        ("3units", -1.2),
        ("3mm", -1.2),
        ("0.3cm", -1.2),
    ],
)
def test_a_return_that_is_good_enough(part: Path, said: str, expected: float) -> None:
    found = settings("target=mesh", f"target.path={part}", "target.scale=0.4", f"target_return={said}")
    target, objective = build_objective(found)
    assert aimed_return(found.target_return, found, objective, target) == pytest.approx(expected)


def test_a_return_on_paper_is_one_of_the_paper_s(part: Path) -> None:
    words = ("target=mesh", f"target.path={part}", "target.fit=board", "cell=8mm", "target_return=2mm")
    found = settings(*words)
    target, objective = build_objective(found)
    assert aimed_return(found.target_return, found, objective, target) == pytest.approx(-0.25)


def test_a_return_of_an_objective_without_a_target_is_itself() -> None:
    found = settings("objective=bucket", "target_return=3")
    target, objective = build_objective(found)
    assert aimed_return(found.target_return, found, objective, target) == 3.0


def test_thickness_is_handed_on_in_cells(part: Path) -> None:
    found = settings("target=bowl", "cell=5mm", "thickness=0.3mm")
    assert thickness_in_cells(found, None) == pytest.approx(0.06)
    assert thickness_in_cells(settings("target=bowl"), None) == 0.0
    natural = settings("target=mesh", f"target.path={part}", "target.scale=0.4", "thickness=0.5")
    assert thickness_in_cells(natural, build_objective(natural)[0]) == pytest.approx(0.2)


# --- which distance leads ---


def test_the_surface_leads_for_meshes_and_vertices_for_all_else(part: Path) -> None:
    mesh = ("target=mesh", f"target.path={part}", "target.scale=0.4")
    for words, distance in (
        (mesh, "surface"),
        (("target=bowl",), "vertex"),
        (("+experiment=paper/face",), "vertex"),
        ((*mesh, "objective.distance=vertex"), "vertex"),
        (("target=cube", "objective.distance=surface"), "surface"),
    ):
        found = settings(*words)
        assert found.config["objective"]["distance"] == distance
        assert build_objective(found)[1].distance == distance


def test_a_run_that_goes_on_keeps_its_distance(part: Path) -> None:
    mesh = ("target=mesh", f"target.path={part}", "target.scale=0.4")
    begun = settings(*mesh, "objective.distance=vertex").config
    assert like_begun(settings(*mesh), begun).config["objective"]["distance"] == "vertex"
    assert like_begun(settings(*mesh), begun).objective["distance"] == "vertex"
    # what is said is said, and refused later
    said = like_begun(settings(*mesh, "objective.distance=surface"), begun)
    assert said.config["objective"]["distance"] == "surface"
