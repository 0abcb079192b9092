"""The data beside a page: whole pieces, of which an update writes one, and nothing that a script could run."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from origami_lab.experiment import multirun_page
from origami_lab.pages import PageFolder, page_folder, page_text, script_json, templates
from origami_lab.report.learning_curves import COLOURS

NASTY = "</script><script>alert(1)</script><!-- & \u2028 '\"`${x} é"


def pieces(folder: Path) -> list[Any]:
    """All entries on disk, in order."""
    found: list[Any] = []
    for number in range(len(list((folder / "index.data").glob("ended-*.js")))):
        text = (folder / f"index.data/ended-{number}.js").read_text("ascii")
        match = re.fullmatch(rf"ended\({number},(.*)\);\n", text, re.DOTALL)
        assert match is not None
        found += json.loads(match[1])
    return found


def test_what_is_added_is_on_disk_piece_by_piece(tmp_path: Path) -> None:
    page = PageFolder(tmp_path)
    page.begin("<p>")
    for size in (1, 40, 3, 0, 60):
        page.add([{"seed": page.ended + k} for k in range(size)])
        page.say({"state": "running"})
        assert [entry["seed"] for entry in pieces(tmp_path)] == list(range(page.ended))
    said = (tmp_path / "index.data/live.js").read_text()
    assert json.loads(said.removeprefix("live(").removesuffix(");\n"))["ended"] == 104
    assert (tmp_path / "index.html").read_text() == "<p>"
    again = PageFolder(tmp_path)
    (tmp_path / "index.data/.ended-0.js.123.tmp").touch()
    (tmp_path / "index.data/mine.txt").touch()
    again.begin("<b>")
    assert [file.name for file in (tmp_path / "index.data").iterdir()] == ["mine.txt"]


def test_an_update_costs_the_same_however_much_has_gone_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[int] = []
    whole = page_folder.write_whole

    def count(path: Path, content: str) -> None:
        written[-1] += len(content)
        whole(path, content)

    page = PageFolder(tmp_path)
    page.begin("")
    monkeypatch.setattr(page_folder, "write_whole", count)
    for seed in range(640):
        written.append(0)
        page.add([{"seed": 1000 + seed}])
        page.say({"state": "running"})
    assert max(written[-64:]) <= max(written[:64]) + 4  # the numbers of pieces and entries have more digits


def test_the_data_of_a_link_is_not_written(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "run").mkdir()
    (tmp_path / "run/index.data").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="link"):
        PageFolder(tmp_path / "run").begin("")
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_a_text_cannot_leave_the_script_it_is_in() -> None:
    text = script_json({"a": [NASTY]})
    assert json.loads(text) == {"a": [NASTY]}
    assert text.isascii()
    assert not set("<>&") & set(text)


def test_pages_have_one_look_and_escape_what_they_show() -> None:
    text = page_text(
        "origami_lab.experiment",
        "multirun_page.html.jinja",
        {
            "kind": "multirun",
            "name": NASTY,
            "experiment": NASTY,
            "table": NASTY,
            "report": NASTY,
            "look": [NASTY],
            "jobs": [{"name": NASTY}],
            "data": "x",
        },
    )
    assert "alert(1)</script>" not in text
    assert text.count("<script") == 1
    assert '<meta name="generator" content="origami-lab multirun">' in text
    assert "--mark: #1d5fd1" in text


def test_curves_on_pages_have_the_colours_of_those_in_reports() -> None:
    style = Path(templates.__file__).with_name("page_parts.css").read_text("utf-8")
    drawn = re.findall(r"\.k(\d) { stroke: (#\w{6}); }", style)
    assert drawn == [(str(k), colour) for k, colour in enumerate(COLOURS)]
    script = Path(multirun_page.__file__).with_suffix(".js").read_text("utf-8")
    assert f"const COLOURS = {len(COLOURS)};" in script
