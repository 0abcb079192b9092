"""``auto``: chosen by the part before a run, written as values, given up for what is said."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import pytest
import yaml

from benchmarks.parts import shapes
from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import build_objective, build_parts
from origami_lab.config.node import flatten
from origami_lab.config.physical_size import millimetres_per_cell
from origami_lab.config.settings import Settings
from origami_lab.config.warnings import remarks
from origami_lab.errors import InputError
from origami_lab.targets import Target


@pytest.fixture
def bracket(tmp_path: Path) -> Path:
    file = tmp_path / "bracket.stl"
    file.write_bytes(shapes.stl(shapes.l_bracket()))
    return file


def settings(file: Path, *overrides: str) -> Settings:
    return compose_settings(["target=mesh", f"target.path={file}", *overrides])


def test_nothing_is_auto_in_what_is_written(bracket: Path) -> None:
    """Scale: 80, 50 and 40 are multiples of 10, and six cells or more across; the wall's crease lies along x."""
    found = settings(bracket)
    undecided = {key for key, value in flatten(found.config).items() if value == "auto"}
    assert undecided == {"workers", "target.closed", "objective.target.closed"}
    assert found.config["target"]["scale"] == found.config["objective"]["target"]["scale"] == pytest.approx(0.1)
    assert found.config["start"]["ends"] == [[-3, 0], [3, 0]]
    assert (found.game.width, found.game.height, found.game.symmetry) == (9, 11, "y")
    assert (found.game.driving_angle_max, found.game.max_crease_length) == (90.0, None)
    parts = build_parts(found)
    assert parts.target is not None
    assert parts.target.vertices.min(axis=0) == pytest.approx([-4, -5, 0], abs=1e-5)
    assert parts.target.vertices.max(axis=0) == pytest.approx([4, 0, 4], abs=1e-5)
    assert any("1 board cell = 10 units" in line for line in remarks(found, parts))
    assert not any("is not symmetric" in line for line in remarks(found, parts))


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("target.scale=0.2", "target.scale", 0.2),
        ("target.rotate=[0,0,90]", "target.rotate", [0, 0, 90]),
        ("board.size=31", "board.size", 31),
        ("board=25x25", "board.size", 25),
        ("board.width=41", "board.width", 41),
        ("symmetry=none", "symmetry.name", "none"),
        ("start=square", "start.size", "choose"),
        ("start.size=2", "start.size", 2),
        ("start=crease", "start.position", "choose"),
        ("max_crease_length=3.5", "max_crease_length", 3.5),
        ("driving_angle.max=120", "driving_angle.max", 120),
        ("driving_angle.count=7", "driving_angle.count", 7),
        ("source_action=boundary", "source_action", "boundary"),
    ],
)
def test_what_is_said_counts_and_the_rest_is_chosen(bracket: Path, override: str, key: str, value: object) -> None:
    found = settings(bracket, override)
    assert flatten(found.config)[key] == value
    build_parts(found)
    plain = settings(bracket)
    if not key.startswith(("target.", "driving_angle.")):
        assert found.config["target"]["scale"] == plain.config["target"]["scale"]
        assert found.game.driving_angle_max == 90.0


@pytest.mark.parametrize("override", ["target.fit=board", "target.translate=[0,0,0]", "target.align_z=true"])
def test_a_part_that_is_placed_by_hand_is_as_before(bracket: Path, override: str) -> None:
    found = settings(bracket, "target.scale=0.1", override)
    assert found.part_lines == ()
    assert (found.game.board_size, found.game.symmetry, found.game.max_crease_length) == (25, "none", 2.9)
    assert dict(found.start) == {"_target_": "origami_lab.game.Square", "size": "choose", "position": None}
    assert found.config["target"]["rotate"] == [0, 0, 0]


def test_a_symmetry_that_the_start_pattern_does_not_have_is_not_chosen(tmp_path: Path) -> None:
    """The lid has both mirrors; a single crease along x can have the one across it only."""
    file = tmp_path / "lid.stl"
    file.write_bytes(shapes.stl(shapes.box_lid()))
    assert settings(file).game.symmetry == "xy"
    assert settings(file, "start=crease", "start.position=0").game.symmetry == "y"


@pytest.mark.parametrize("words", [["symmetry=auto"], ["start=auto"], ["board=auto"], ["max_crease_length=auto"]])
def test_without_a_part_nothing_can_be_chosen(words: list[str]) -> None:
    with pytest.raises(InputError, match=r"=auto: is chosen by a part, which needs target=mesh"):
        compose_settings(["target=bowl", *words])


def test_a_run_that_goes_on_keeps_what_was_chosen(bracket: Path, tmp_path: Path) -> None:
    """Also if the analysis came to another answer today, as it would for this other part under the same name."""
    begun = settings(bracket)
    (tmp_path / "run").mkdir()
    (tmp_path / "run/config.yaml").write_text(yaml.safe_dump(dict(begun.config)))
    bracket.write_bytes(shapes.stl(shapes.box_lid()))
    assert settings(bracket).config["start"] != begun.config["start"]
    resumed = settings(bracket, f"output={tmp_path / 'run'}", "resume=true")
    kept = {key: value for key, value in resumed.config.items() if key not in ("output", "resume")}
    assert kept == {key: begun.config[key] for key in kept}


@pytest.mark.parametrize(
    ("override", "field"), [("target.scale=0", "target.scale"), ("target.rotate=[1]", "target.rotate")]
)
def test_wrong_values_are_refused_in_one_line(bracket: Path, override: str, field: str) -> None:
    with pytest.raises(InputError, match=f"^{field}="):
        settings(bracket, override)


def laid(bracket: Path, *words: str) -> tuple[Settings, Target]:
    found = settings(bracket, *words)
    target, _ = build_objective(found)
    assert target is not None
    return found, target


def test_a_cell_gives_a_part_its_true_size(bracket: Path) -> None:
    """Whatever its length: the part is as many cells long as its millimetres say."""
    _, free = laid(bracket)
    assert free.units_per_cell is not None
    size = free.size * free.units_per_cell
    for cell in (0.15 * size, 0.1 * size, 0.07 * size):
        found, target = laid(bracket, f"cell={cell}mm")
        assert target.size == pytest.approx(size / cell, rel=1e-9)
        assert found.config["target"]["scale"] == 1.0


@pytest.mark.parametrize(
    ("unit", "length", "words"),
    [
        ("mm", 1.0, ()),
        ("mm", 1.0, ("target.unit=mm",)),
        ("cm", 10.0, ("target.unit=cm",)),
        ("in", 25.4, ("target.unit=in",)),
        ("m", 1000.0, ("target.unit=m",)),
        ("m", 1000.0, ()),  # what would be smaller than a fingernail is in metres
    ],
)
def test_a_cell_gives_a_part_its_true_size_in_any_unit(
    unit: str, length: float, words: tuple[str, ...], tmp_path: Path
) -> None:
    """The same part, 80 mm wide, in other units: as many cells, and as many millimetres a cell."""
    (file := tmp_path / "part.stl").write_bytes(shapes.stl(shapes.l_bracket() / length))
    found, target = laid(file, "cell=8mm", *words)
    assert found.config["target"]["unit"] == unit
    assert found.config["target"]["scale"] == 1.0
    assert target.vertices[:, 0].max() - target.vertices[:, 0].min() == pytest.approx(80.0 / 8.0, rel=1e-5)
    assert millimetres_per_cell(found, target) == 8.0
    free, as_file = laid(file, *words)
    assert millimetres_per_cell(free, as_file) == pytest.approx(10.0, rel=1e-5)


def test_a_solid_that_is_said_to_be_one_is_taken_whole(tmp_path: Path) -> None:
    (file := tmp_path / "lid.stl").write_bytes(shapes.stl(shapes.thick_lid()))
    for words, skin in (((), "outer"), (("target.skin=inner",), "inner"), (("target.closed=true",), None)):
        found, target = laid(file, *words)
        assert found.config["target"]["skin"] == skin
        assert target.closed == (skin is None)


def test_a_unit_that_there_is_not_is_refused(bracket: Path) -> None:
    for words in ([], ["target.fit=board"], ["cell=5mm"]):
        with pytest.raises(InputError, match=r"^target\.unit=foot: must be auto, mm, cm, m, in or null"):
            laid(bracket, "target.unit=foot", *words)


def test_a_sheet_makes_the_part_as_large_as_there_is_room(bracket: Path) -> None:
    """The board is the one that is chosen without a sheet, and so are the cells of the part."""
    plain, free = laid(bracket)
    found, target = laid(bracket, "sheet=A4")
    assert found.game == plain.game
    assert target.size == pytest.approx(free.size, rel=1e-12)
    assert found.cell is not None
    assert (found.game.width - 1) * found.cell <= 297
    assert (found.game.height - 1) * found.cell <= 297


def test_the_run_says_how_large_a_part_becomes_on_paper(bracket: Path) -> None:
    """80 × 50 × 40 mm, on a board of 8 × 10 cells: at most 190 of 277 mm wide on A4, upright, so by the height."""

    def said(*words: str) -> list[str]:
        found = settings(bracket, *words)
        return [line for line in remarks(found, build_parts(found)) if "on paper" in line]

    assert said() == said("cell=10mm") == said("cell=10mm", "sheet=A4") == []
    (line,) = said("sheet=A4")
    cell = min(190 / 8, 277 / 10)
    assert line.startswith(f"on paper a cell is {cell:.4g} mm: the part becomes {8 * cell:.4g} × {5 * cell:.4g} × ")
    assert f"{cell / 10:.3g} times its size" in line
    assert "cell=10mm keeps it" in line


def test_a_cell_that_is_larger_than_the_part_is_refused_in_one_line(bracket: Path) -> None:
    with pytest.raises(InputError, match=r"^(cell|target\.scale)="):
        laid(bracket, "cell=9000mm")


@pytest.mark.parametrize("kind", ["pipe", "folder", "bomb"])
def test_a_configuration_that_is_none_is_left_to_the_run_folder_to_refuse(
    bracket: Path, tmp_path: Path, kind: str
) -> None:
    """It is neither waited for nor unfolded here."""
    file = tmp_path / "on/config.yaml"
    file.parent.mkdir()
    if kind == "pipe":
        os.mkfifo(file)
    elif kind == "folder":
        file.mkdir()
    else:
        names = [f"n{k}" for k in range(40)]
        lines = [f"{b}: &{b} [*{a}, *{a}]" for a, b in itertools.pairwise(names)]
        file.write_text("\n".join(["n0: &n0 [1]", *lines]) + "\n")
    found = settings(bracket, "resume=true", f"output={file.parent}")
    assert found.config["target"]["scale"] == pytest.approx(0.1)
