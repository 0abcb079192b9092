"""Crease patterns without folded frames: their own letters and angles in flat formats, folded in others."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

import origami_lab
from origami_lab.cli import main
from origami_lab.errors import InputError
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import Fold, base, children, heir, letters_only, plain
from tests.fold_format.test_dialects import READERS, from_cp, from_dxf, from_svg

CASES = Path(__file__).parents[1] / "verification" / "cases"
CORPUS = corpus()
FLAT = ("svg", "dxf", "cp", "cut", "fold")
FOLDED = ("obj", "stl", "ply", "glb", "html", "gif")


def write(tmp_path: Path, fold: Fold, name: str = "a.fold") -> Path:
    (tmp_path / name).write_text(json.dumps(fold), encoding="utf-8")
    return tmp_path / name


def letters_in(path: Path, suffix: str) -> Counter[str]:
    return Counter(segment[0] for segment in READERS[suffix](path.with_name(path.stem + suffix)))


@pytest.mark.parametrize("name", ["x_flat_only", "tiny_z", "inherited_classes", "x_folded_form"])
def test_one_valley(name: str, tmp_path: Path) -> None:
    """A square with a valley across: one valley and four sides of the square in every flat format."""
    done = origami_lab.export_design(CASES / f"{name}.fold", ["svg,dxf", "cp", "cut,fold"], tmp_path)
    assert len(done.files) == 6
    for suffix in READERS:
        path = tmp_path / f"{name}.fold"
        assert letters_in(path, suffix) == Counter(B=4, V=1)
        segments = READERS[suffix](path.with_name(path.stem + suffix))
        lengths = sorted(math.hypot(s[3] - s[1], s[4] - s[2]) for s in segments)
        assert np.array(lengths) / lengths[0] == pytest.approx([1, 1, 1, 1, math.sqrt(2)])
    sheet = (tmp_path / f"{name}.cut.svg").read_text()
    assert 'id="valley"' in sheet
    assert 'id="mountain"' not in sheet


def test_ninety_degrees_of_a_square(tmp_path: Path) -> None:
    """The fourth corner of a unit square folded by 90° along its diagonal: √(½ + ½) = 1 from its opposite one."""
    origami_lab.export_design(CASES / "x_flat_only.fold", "obj", tmp_path)
    rows = [line.split() for line in (tmp_path / "x_flat_only.obj").read_text().splitlines() if line[:2] == "v "]
    points = np.array([[float(x) for x in row[1:4]] for row in rows])
    assert np.linalg.norm(points[1] - points[3]) == pytest.approx(1.0)
    assert np.linalg.norm(points[0] - points[2]) == pytest.approx(math.sqrt(2))


@pytest.mark.parametrize("to", FOLDED)
def test_folded_formats_fold(to: str, tmp_path: Path) -> None:
    done = origami_lab.export_design(write(tmp_path, plain(CORPUS["degree four"])), to, tmp_path)
    assert done.files[0].stat().st_size > 100
    assert done.notes == ()


@pytest.mark.parametrize("to", FOLDED)
def test_folded_formats_say_why_they_cannot(to: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, letters_only(CORPUS["degree four"]))
    assert main(["export", str(path), "--to", to]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "states no fold angles" in line
    assert [file.name for file in tmp_path.iterdir()] == ["a.fold"]


def spoiled(p: Pattern, what: str) -> Fold:
    fold = plain(p)
    e = next(e for e, letter in enumerate(fold["edges_assignment"]) if letter != "B")
    if what == "open":
        fold["edges_foldAngle"][e] *= 0.8
    elif what == "null":
        fold["edges_foldAngle"][e] = None
    elif what == "cut":
        fold["edges_assignment"][e] = "C"
    else:
        fold["vertices_coords"][0], fold["vertices_coords"][1] = fold["vertices_coords"][1], fold["vertices_coords"][0]
    return fold


@pytest.mark.parametrize(
    ("what", "why"), [("open", "miss closing"), ("null", "no fold angle"), ("cut", "cut"), ("crossed", "cross")]
)
def test_one_line_says_why(what: str, why: str, tmp_path: Path) -> None:
    path = write(tmp_path, spoiled(CORPUS["huffman (80.0, 95.0, 70.0, 115.0)"], what))
    with pytest.raises(InputError, match=why) as caught:
        origami_lab.export_design(path, "obj", tmp_path)
    assert "\n" not in str(caught.value)
    origami_lab.export_design(path, FLAT, tmp_path)  # lines are lines


def test_assumed_angles_are_not_written_as_facts(tmp_path: Path) -> None:
    path = write(tmp_path, letters_only(CORPUS["degree four"]))
    done = origami_lab.export_design(path, "fold,svg", tmp_path)
    assert any("180° is assumed" in note for note in done.notes)
    written = json.loads((tmp_path / "a.full.fold").read_text())
    pairs = zip(written["edges_assignment"], written["edges_foldAngle"], strict=True)
    assert all((angle is None) == (letter in "MV") for letter, angle in pairs)
    assert 'opacity="1"' in (tmp_path / "a.svg").read_text()


@pytest.mark.parametrize("letter", ["U", "J", "C", "F"])
def test_letters_that_few_files_have(letter: str, tmp_path: Path) -> None:
    """What docs/export.md says becomes of them."""
    fold = plain(CORPUS["valley"])
    e = fold["edges_assignment"].index("V")
    fold["edges_assignment"][e], fold["edges_foldAngle"][e] = letter, 0
    path = write(tmp_path, fold)
    origami_lab.export_design(path, FLAT, tmp_path)
    colours = {"U": "#ff00ff", "J": "#ffff00", "C": "#00ff00", "F": "#ffff00"}
    assert f'stroke="{colours[letter]}"' in (tmp_path / "a.svg").read_text()
    layers = {"U": "U", "J": "F", "C": "B", "F": "F"}
    assert Counter(s[0] for s in from_dxf(tmp_path / "a.dxf"))[layers[letter]] == 1 + 6 * (letter == "C")
    kinds = {"U": "F", "J": "F", "C": "B", "F": "F"}
    assert Counter(s[0] for s in from_cp(tmp_path / "a.cp"))[kinds[letter]] == 1 + 6 * (letter == "C")
    sheet = (tmp_path / "a.cut.svg").read_text()
    assert ('id="unassigned"' in sheet) == (letter == "U")
    assert json.loads((tmp_path / "a.full.fold").read_text())["edges_assignment"][e] == letter


def several(p: Pattern) -> Fold:
    """The sheet, three states, and another sheet of one valley."""
    fold = children(p)
    other = base(CORPUS["valley"])
    fold["file_frames"].append({"frame_classes": ["creasePattern"]} | other)
    return fold


def test_a_frame_by_its_number(tmp_path: Path) -> None:
    pattern = CORPUS["degree four"]
    path = write(tmp_path, several(pattern))
    for k in range(3):
        origami_lab.export_design(path, "svg,obj", tmp_path, frame=k + 1)
        angles = sorted(
            float(line.split('opacity="')[1].split('"')[0]) * 180
            for line in (tmp_path / "a.svg").read_text().splitlines()
            if "opacity" in line
        )
        true = sorted(abs(x) for x, letter in zip(pattern.degrees[k], pattern.letters, strict=True) if letter != "B")
        assert angles == pytest.approx(true, abs=1e-6)
        mesh = trimesh.load(tmp_path / "a.obj", process=False)
        assert np.allclose(np.asarray(mesh.vertices), pattern.folded[k], atol=1e-7)
    origami_lab.export_design(path, "svg", tmp_path, frame=4)
    assert len(from_svg(tmp_path / "a.svg")) == len(CORPUS["valley"].edges)
    origami_lab.export_design(path, "svg", tmp_path, frame=0)
    assert len(from_svg(tmp_path / "a.svg")) == len(pattern.edges)


@pytest.mark.parametrize("frame", ["5", "-1", "x", "1.5", "99999999999999999999"])
def test_no_such_frame(frame: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, several(CORPUS["degree four"]))
    assert main(["export", str(path), "--to", "svg", f"--frame={frame}"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_graph_is_no_frame_to_show(tmp_path: Path) -> None:
    fold = children(CORPUS["valley"])
    fold["file_frames"].append(heir() | {"frame_classes": ["graph"]})
    with pytest.raises(InputError, match="frame"):
        origami_lab.export_design(write(tmp_path, fold), "svg", tmp_path, frame=4)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_a_driving_angle_of_a_pattern_that_is_folded(share: float, tmp_path: Path) -> None:
    """A vertex of degree four stops where its closed form is: tan(ρ₁/2)/tan(ρ₀/2) is constant."""
    pattern = CORPUS["degree four"]
    folds = {round(abs(x), 9) for x in pattern.degrees[-1] if x}
    largest, smallest = max(folds), min(folds)
    path = write(tmp_path, plain(pattern))
    done = origami_lab.export_design(path, "svg,obj", tmp_path, angle=share * largest)
    assert done.driving_angle == pytest.approx(share * largest)
    opacities = [
        line.split('opacity="')[1].split('"')[0]
        for line in (tmp_path / "a.svg").read_text().splitlines()[2:]
        if "opacity" in line
    ]
    angles = sorted({round(180 * float(text), 6) for text in opacities})
    ratio = math.tan(math.radians(smallest) / 2) / math.tan(math.radians(largest) / 2)
    assert math.tan(math.radians(angles[0]) / 2) / math.tan(math.radians(angles[-1]) / 2) == pytest.approx(ratio)
    with pytest.raises(InputError, match="as far as it folds"):
        origami_lab.export_design(path, "obj", tmp_path, angle=1.01 * largest)


def test_lists_and_repeated_options_are_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(write(tmp_path, plain(CORPUS["valley"])))
    said = []
    for words in (
        ["--to", "svg,dxf,cp"],
        ["--to", "svg", "--to", "dxf", "--to", "cp"],
        ["--to=svg, dxf", "--to=cp,svg"],
    ):
        assert main(["export", path, *words]) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1] == said[2]
    assert len(said[0].splitlines()) == 3
    assert main(["export", path, "--to", "svg,dfx"]) == 2
    assert "dfx" in capsys.readouterr().err


def test_remarks_are_said_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = CASES / "auxiliary_line.fold"
    assert main(["verify", str(path), "--json", str(tmp_path / "c.json")]) == 0
    out, err = capsys.readouterr()
    assert "edge 5 is an auxiliary line" in err
    assert "certified" in out
    assert any("edge 5" in remark for remark in json.loads((tmp_path / "c.json").read_text())["remarks"])
    assert main(["export", str(path), "--to", "cp", "--output", str(tmp_path)]) == 0
    assert "edge 5 is an auxiliary line" in capsys.readouterr().err
    assert Counter(s[0] for s in from_cp(tmp_path / "auxiliary_line.cp")) == Counter(B=4, V=1, F=1)


def test_verify_takes_a_trials_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "run" / "seed=3"
    folder.mkdir(parents=True)
    write(folder, children(CORPUS["degree four"]), "best.fold")
    assert main(["verify", str(folder)]) == 0
    said = capsys.readouterr().out
    assert main(["verify", str(folder / "best.fold")]) == 0
    assert capsys.readouterr().out == said
    assert main(["verify", str(tmp_path / "run")]) == 2


def test_the_motion_of_a_pattern_that_is_folded(tmp_path: Path) -> None:
    """Ten states, each a tenth further; of a pattern that may move in many ways only the stated one, and a note."""
    pages = {}
    for name in ("degree four", "pyramid of the game"):
        done = origami_lab.export_design(write(tmp_path, plain(CORPUS[name])), "html", tmp_path)
        page = done.files[0].read_text(encoding="utf-8")
        states = json.loads(page.split('"states":')[1].split(',"unit"')[0])
        pages[name] = [state["at"] for state in states], done.notes
    largest = max(map(abs, CORPUS["degree four"].degrees[-1]))
    assert pages["degree four"][0] == pytest.approx([largest * k / 10 for k in range(11)], abs=1e-5)
    assert len(pages["pyramid of the game"][0]) == 2
    assert any("degrees of freedom" in note for note in pages["pyramid of the game"][1])


@pytest.mark.parametrize("to", ["obj", "stl", "ply", "glb"])
@pytest.mark.parametrize("name", ["miura 3×3", "cube of the game"])
def test_meshes_have_the_sheets_area(name: str, to: str, tmp_path: Path) -> None:
    """Folding keeps areas: those of the flat panels, by Gauss's formula."""
    pattern = CORPUS[name]
    origami_lab.export_design(write(tmp_path, plain(pattern)), to, tmp_path)
    area = 0.0
    for face in pattern.faces:
        x, y = pattern.flat[list(face)].T
        area += (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    mesh = trimesh.load(tmp_path / f"a.{to}", process=False, force="mesh")
    assert mesh.area == pytest.approx(area, rel=1e-5)


def test_a_pattern_without_panels_is_drawn_and_not_folded(tmp_path: Path) -> None:
    fold = {
        "frame_classes": ["creasePattern"],
        "vertices_coords": [[0, 0], [2, 2], [0, 2], [2, 0]],
        "edges_vertices": [[0, 1], [2, 3]],
        "edges_assignment": ["M", "V"],
        "edges_foldAngle": [-90, 90],
    }
    done = origami_lab.export_design(write(tmp_path, fold), "cp", tmp_path)
    assert any("no panels" in note for note in done.notes)
    assert Counter(s[0] for s in from_cp(tmp_path / "a.cp")) == Counter(M=1, V=1)
    with pytest.raises(InputError, match="cannot fold"):
        origami_lab.export_design(tmp_path / "a.fold", "obj", tmp_path)
