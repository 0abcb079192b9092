"""What is no regular file, aliases that explode and control characters: one line, no waiting, and XML stays XML."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from origami_lab.cli import main

BOMB = "a: &a [x,x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{new}: &{new} [{','.join([f'*{old}'] * 10)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGES = "a: &a {x: 1}\n" + "".join(
    f"{new}: &{new} {{<<: [{','.join([f'*{old}'] * 10)}]}}\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
COMMANDS = {
    "a configuration": ("odd.yaml", ["odd.yaml"]),
    "an option": ("conf/experiment/odd.yaml", ["--config-dir", "conf", "target=cube", "experiment=odd"]),
    "a sweep": ("odd.yaml", ["sweep", "odd.yaml"]),
    "a mesh": ("odd.stl", ["target=mesh", "target.path=odd.stl"]),
    "a start": ("odd.json", ["target=bowl", "start=file", "start.path=odd.json"]),
    "a certificate": ("odd.fold", ["verify", "odd.fold"]),
    "an export": ("odd.fold", ["export", "odd.fold", "--to", "svg"]),
    "known values": ("odd.csv", ["report", "runs", "--beside", "odd.csv"]),
    "a design": ("odd.fold", ["polish", "odd.fold"]),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    Path("conf/experiment").mkdir(parents=True)
    Path("runs").mkdir()
    return tmp_path


@pytest.mark.parametrize("kind", ["pipe", "folder", "device", "socket"])
@pytest.mark.parametrize(("name", "words"), COMMANDS.values(), ids=COMMANDS)
def test_what_is_no_file_is_refused(
    kind: str, name: str, words: list[str], here: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    match kind:
        case "pipe":
            os.mkfifo(name)
        case "folder":
            Path(name).mkdir()
        case "device":
            Path(name).symlink_to("/dev/zero")
        case "socket":
            with socket.socket(socket.AF_UNIX) as bound:
                bound.bind(name)
    assert main([*words, *(["output=out"] if "=" in words[-1] else [])]) == 2
    said = capfd.readouterr().err
    assert said.startswith("error: ")
    assert said.count("\n") == 1


@pytest.mark.parametrize("text", [BOMB, MERGES, "a: &a [*a]\n", "[" * 5000, "a: " + "9" * 5000 + "\n"])
@pytest.mark.parametrize("what", ["a configuration", "an option", "a sweep"])
def test_aliases_that_explode_are_refused(text: str, what: str, here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    name, words = COMMANDS[what]
    Path(name).write_text(text)
    assert main(words) == 2
    said = capfd.readouterr().err
    assert said.startswith("error: ")
    assert said.count("\n") == 1


HARM = "a\x1b]0;gone\x07\x1b[2J\x00 <b>&\ud800\u202e]]>\ufffe"
VALLEY = {
    "vertices_coords": [[-2, -1], [0, -1], [2, -1], [2, 1], [0, 1], [-2, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
    "edges_assignment": ["B", "B", "B", "B", "B", "B", "V"],
    "edges_foldAngle": [0, 0, 0, 0, 0, 0, 90],
    "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
}


@pytest.mark.slow
def test_control_characters_in_titles(here: Path, capfd: pytest.CaptureFixture[str]) -> None:
    names = dict.fromkeys(("file_title", "file_creator", "file_author", "file_description", "frame_title"), HARM)
    Path("odd.fold").write_text(json.dumps({"file_spec": 1.2, **names, **VALLEY}))
    main(["verify", "odd.fold"])
    assert main(["export", "odd.fold", "--to", "svg,dxf,html,cut,cp,fold"]) == 0
    said = capfd.readouterr()
    assert not [c for c in said.out + said.err if not (c.isprintable() or c == "\n")]
    for file in here.glob("*.svg"):
        ElementTree.fromstring(file.read_bytes())
    assert len(list(here.glob("*.svg"))) == 2
    for name in ("odd.svg", "odd.dxf", "odd.html"):
        assert not {b"\x1b", b"\x00", b"\x07"} & {bytes([byte]) for byte in Path(name).read_bytes()}
