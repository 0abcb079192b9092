"""`origami-lab export` and `origami_lab.export_design`: files, choices, refusals."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

import origami_lab
from origami_lab.cli import main
from origami_lab.export.formats import FORMATS
from origami_lab.fold_format.writer import as_fold_file, read_fold, write_fold
from tests.known_designs import closed_forms as designs

QUICK = ("fold", "svg", "dxf", "cp", "obj", "stl", "ply", "glb", "cut")


@pytest.fixture
def trial(tmp_path: Path) -> Path:
    """A trial's folder in a run's, with a target."""
    folder = tmp_path / "run" / "seed=0"
    folder.mkdir(parents=True)
    write_fold(folder / "best.fold", designs.single_valley())
    trimesh.Trimesh(*designs.pyramid_mesh(), process=False).export(tmp_path / "run" / "target.ply")
    return folder


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, list[str], list[str]]:
    code = main(["export", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out.splitlines(), err.splitlines()


def test_all_quick_formats_at_once(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, notes = run(capsys, trial, *(word for name in QUICK for word in ("--to", name)), "--angle", 50)
    assert code == 0
    names = ["full.fold", "svg", "dxf", "cp", "obj", "stl", "ply", "glb", "cut.svg", "cut.pdf"]
    assert out == [str(trial / f"best.{name}") for name in names]
    assert all(Path(file).stat().st_size for file in out)
    degrees = math.degrees(3 * 0.314)
    assert f"note: angle: the nearest stored state to 50° is that at {degrees:.2f}°" in notes
    assert "note: cut: 63.33 mm a cell on 297 × 210 mm" in notes  # 4 × 3 cells on A4 turned: (210 − 20) / 3
    expected = 2 * np.sin(3 * 0.314)
    assert trimesh.load(trial / "best.stl").vertices[:, 2].max() == pytest.approx(expected, abs=1e-6)


def test_output(trial: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, notes = run(capsys, trial / "best.fold", "--to", "cut", "--output", tmp_path / "a.pdf", "--cell", 10)
    assert (code, out, len(notes)) == (0, [str(tmp_path / "a.pdf")], 1)
    assert not (tmp_path / "a.svg").exists()
    code, out, notes = run(capsys, trial, "--to", "stl", "--output", tmp_path, "--thickness", 0.5, "--cell", 2)
    assert (code, out, notes) == (0, [str(tmp_path / "best.stl")], [])
    assert trimesh.load(out[0]).volume == pytest.approx(4 * 3 * 2**2 * 0.5, rel=1e-5)


def test_from_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    design = designs.single_valley()
    done = origami_lab.export_design(design, ["svg", "cp"])
    assert [str(file) for file in done.files] == ["design.svg", "design.cp"]
    assert done.driving_angle == pytest.approx(math.degrees(1.57))
    assert done.notes == ()
    again = origami_lab.export_design(as_fold_file(design), "svg", "b.svg")
    assert again.files[0].read_bytes() == done.files[0].read_bytes()
    origami_lab.export_design(design, "fold", "c.fold")
    assert np.array_equal(read_fold("c.fold").best.coords, design.folded[4])


def test_gif_has_the_target_of_the_run(trial: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, trial, "--to", "gif")[0] == 0
    with Image.open(trial / "best.gif") as picture:
        assert picture.n_frames == 2 * 6 - 2  # flat, five steps up to the best one, and back
        green = np.array(picture.convert("RGB")).reshape(-1, 3)
    assert (green == (199, 233, 219)).all(axis=1).any()  # the key of the target's colour


def test_film(trial: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """What is handed to ffmpeg: as many bytes as frames of the size that it is told."""
    tools = tmp_path / "tools"
    tools.mkdir()
    fake = tools / "ffmpeg"
    fake.write_text(
        f"#!{sys.executable}\nimport sys\n"
        "size = sys.argv[sys.argv.index('-s') + 1]\n"
        "open(sys.argv[-1], 'w').write(f'{size} {len(sys.stdin.buffer.read())}')\n"
    )
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", str(tools))
    assert run(capsys, trial, "--to", "mp4")[0] == 0
    size, count = (trial / "best.mp4").read_text().split()
    width, height = map(int, size.split("x"))
    held = round(700 / 60) + round(1600 / 60)  # flat and best are shown longer, as in the GIF
    assert int(count) == width * height * 3 * (held + 2 * 4)
    assert width == 720
    fake.write_text("#!/bin/sh\necho no such codec >&2\nexit 3\n")
    code, _, said = run(capsys, trial, "--to", "mp4")
    assert (code, said) == (2, ["error: to=mp4: ffmpeg made no film: no such codec"])
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    code, _, said = run(capsys, trial, "--to", "mp4")
    assert (code, said) == (2, ["error: to=mp4: needs ffmpeg, which is not on the PATH; gif needs nothing"])
    assert not list(trial.glob("*.tmp"))


REFUSED: list[tuple[list[str], str]] = [
    (["--to", "pdf"], "to=pdf: must be one of fold, svg,"),
    (["--to", "svg", "--angle", "many"], "angle=many: must be a number"),
    (["--to", "svg", "--angle", "nan"], "angle=nan: must be a number from 0 to 180"),
    (["--to", "svg", "--angle", "-5"], "angle=-5.0: must be a number from 0 to 180"),
    (["--to", "svg", "--angle", "179.95"], "angle=179.95: must be from 0 to 179.91 degrees"),
    (["--to", "svg", "--thickness", "1"], "thickness=1.0: means nothing to svg, only to obj, stl, ply, glb"),
    (["--to", "stl", "--thickness", "0"], "thickness=0.0: must be a number above 0"),
    (["--to", "cut", "--cell", "0"], "cell=0.0: must be a number above 0"),
    (["--to", "cut", "--cell", "80", "--sheet", "A4"], "cell=80: must be at most 63.33"),
    (["--to", "cut", "--sheet", "foolscap"], "sheet=foolscap: must be "),
    (["--to", "cut", "--margin", "110"], "margin=110: must leave room"),
    (["--to", "dxf", "--palette", "blue"], "palette=blue: must be simulator or oripa"),
    (["--to", "gif", "--target", "none.stl"], "none.stl=missing: must be a mesh file"),
    (["--to", "svg", "--output", "no/such/a.svg"], "output=no/such/a.svg: must be in a folder that exists"),
    (["--to", "svg", "--output", "a.png"], "output=a.png: must end in .svg"),
    (["--to", "svg", "--to", "cp", "--output", "a.svg"], "output=a.svg: must be an existing folder"),
]


@pytest.mark.parametrize(("arguments", "line"), REFUSED, ids=[" ".join(a) for a, _ in REFUSED])
def test_refused_in_one_line(
    arguments: list[str], line: str, trial: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(trial)
    code, out, said = run(capsys, "best.fold", *arguments)
    assert (code, out, len(said)) == (2, [], 1)
    assert said[0].startswith("error: " + line)
    assert list(trial.iterdir()) == [trial / "best.fold"]


def test_wrong_files(trial: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad: dict[str, Callable[[], object]] = {
        "none.fold": lambda: None,
        "text.fold": lambda: (tmp_path / "text.fold").write_text("{"),
        "run": lambda: None,  # a folder that is not a trial's
    }
    for name, make in bad.items():
        make()
        code, out, said = run(capsys, tmp_path / name, "--to", "svg")
        assert (code, out, len(said)) == (2, [], 1)
        assert said[0].startswith(f"error: {tmp_path / name}=")
    code, _, said = run(capsys, trial / "best.fold", "--to", "fold", "--output", trial / "best.fold")
    assert (code, len(said)) == (2, 1)
    assert "must not be the file that is read" in said[0]
    (trial / "best.svg").mkdir()
    code, _, said = run(capsys, trial, "--to", "svg")
    assert (code, len(said)) == (2, 1)


def test_usage(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "--help")
    assert code == 0
    assert all(any(line.startswith(f"  {name} ") for line in out) for name in FORMATS)
    assert run(capsys, "a.fold")[0] == 2
