"""`origami-lab verify`: words, JSON and exit codes; files that are wrong in every way are one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import origami_lab
from origami_lab.cli import main
from origami_lab.fold_format.writer import to_fold, write_fold
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import foreign, known_chair, known_design, strip, write


@pytest.fixture(scope="module")
def pyramid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pyramid") / "best.fold"
    write_fold(path, known_design("pyramid"))
    return path


def test_words(pyramid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(pyramid)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("certified: no panels cross up to 107.9452°")
    assert {line.split("  ")[0] for line in lines[2:]} == {"ok", "fact"}


def test_json(pyramid: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(pyramid), "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["verdict"], document["panels"], document["angle"]) == ("certified", None, None)
    assert main(["verify", str(pyramid), "--json", str(tmp_path / "certificate.json")]) == 0
    assert json.loads((tmp_path / "certificate.json").read_text()) == document
    assert "certified" in capsys.readouterr().out
    assert main(["verify", str(pyramid), "--json", str(tmp_path / "no" / "folder.json")]) == 2


def test_refuted_names_panels_and_angle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_fold(tmp_path / "chair.fold", known_chair())
    assert main(["verify", str(tmp_path / "chair.fold"), "--json", "-"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["verdict"] == "refuted"
    assert len(document["panels"]) == 2
    assert 86.0 < document["angle"] < 87.0


def test_not_certifiable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fold = {key: value for key, value in foreign(designs.miura()).items() if key != "file_frames"}
    del fold["edges_foldAngle"]
    assert main(["verify", str(write(tmp_path / "flat.fold", fold))]) == 3
    assert capsys.readouterr().out.startswith("not certifiable: ")


@pytest.mark.parametrize(
    "arguments",
    [["none.fold"], [".."], ["--thickness=-1", "x.fold"], ["--thickness=nan", "x.fold"], []],
    ids=["missing", "folder", "negative", "nan", "nothing"],
)
def test_wrong_input(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["verify", *arguments]) == 2
    assert "Traceback" not in capsys.readouterr().err


HOSTILE = {
    "huge": lambda fold: fold.update(vertices_coords=[[i, i * i] for i in range(5000)]),
    "many edges": lambda fold: fold.update(edges_vertices=[[0, 1]] * 7000),
    "long face": lambda fold: fold.update(faces_vertices=[[0, 1, 2] * 9000]),
    "many frames": lambda fold: fold.update(file_frames=[{}] * 5000),
    "inherits from itself": lambda fold: fold["file_frames"][0].update(frame_parent=1),
    "parent is text": lambda fold: fold["file_frames"][0].update(frame_parent="0"),
    "frame is a number": lambda fold: fold.update(file_frames=[3]),
    "no edges": lambda fold: fold.pop("edges_vertices"),
    "infinite": lambda fold: fold["vertices_coords"].__setitem__(0, [float("inf"), 0]),
}


@pytest.mark.parametrize("spoil", HOSTILE.values(), ids=HOSTILE)
def test_hostile(spoil: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fold = to_fold(designs.single_valley())
    spoil(fold)
    assert main(["verify", str(write(tmp_path / "bad.fold", fold))]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


_TRIANGLE = '"edges_vertices":[[0,1],[1,2],[2,0]]'
FLOOD = {
    "a million edges": '{"vertices_coords":[[0,0],[1,0],[0,1]],"edges_vertices":[' + "[0,1]," * 1_000_000 + "[1,2]]}",
    "a million frames": '{"vertices_coords":[[0,0],[1,0],[0,1]],"edges_vertices":[[0,1]],"file_frames":['
    + "{}," * 1_000_000
    + "{}]}",
    "deep": "[" * 1_000_000,
    "NaN": '{"vertices_coords":[[NaN,0],[1,0],[0,1]],"edges_vertices":[[0,1],[1,2],[2,0]]}',
    "1e308": '{"vertices_coords":[[1e308,0],[-1e308,0],[0,1e308]],"edges_vertices":[[0,1],[1,2],[2,0]]}',
    "too long": "[" + "0," * 2**24 + "0]",
    "400 digits": '{"vertices_coords":[[1' + "0" * 400 + ",0],[1,0],[0,1]]," + _TRIANGLE + "}",
    "a million digits": '{"vertices_coords":[[' + "1" * 1_000_000 + ",0],[1,0],[0,1]]," + _TRIANGLE + "}",
    "1e999": '{"vertices_coords":[[1e999,0],[1,0],[0,1]],' + _TRIANGLE + "}",
    "a vertex of 30 digits": '{"vertices_coords":[[0,0],[1,0],[0,1]],"edges_vertices":[[0,'
    + "9" * 30
    + "],[1,2],[2,0]]}",
    "deep objects": '{"a":' * 300_000 + "1" + "}" * 300_000,
    "100 MB of text": '{"file_title":"'
    + "x" * 100_000_000
    + '","vertices_coords":[[0,0],[1,0],[0,1]],'
    + _TRIANGLE
    + "}",
    "a long face": '{"vertices_coords":[[0,0],[1,0],[0,1]],'
    + _TRIANGLE
    + ',"faces_vertices":[['
    + "0,1,2," * 800_000
    + "0]]}",
}


@pytest.mark.parametrize("command", ["verify", "export"])
@pytest.mark.parametrize("text", FLOOD.values(), ids=FLOOD)
def test_floods_are_refused_in_one_line(
    command: str, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "flood.fold").write_text(text, encoding="utf-8")
    arguments = [] if command == "verify" else ["--to", "svg", "--output", str(tmp_path)]
    assert main([command, str(tmp_path / "flood.fold"), *arguments]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_looks_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A strip whose panels are stacked: what is looked at is counted, and the certificate says that it ended there."""
    design = strip((1.0,) * 8, (1, -1) * 3 + (1,), [60.0, 120.0, 175.0])
    assert origami_lab.verify(design).exit_code == 0
    monkeypatch.setattr("origami_lab.verification.crossing_search.MOST_LOOKS", 50)
    certificate = origami_lab.verify(design)
    assert certificate.exit_code == 3
    assert "too many states" in certificate.reason
