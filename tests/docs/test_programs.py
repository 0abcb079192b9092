"""The documentation runs: every block of Python, and the files and commands of the page on parts of your own."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from origami_lab.cli import main
from tests.docs.page_blocks import PAGES, blocks

FILE = re.compile(r"\A(?:# @package \S+\n)?# (\S+\.(?:py|yaml))\n")
FAST = ("seed=0", "tracking=none", "verbosity=quiet")
PROGRAMS = [page for page in PAGES if any(block.language == "python" for block in blocks(page))]


@pytest.mark.slow
@pytest.mark.parametrize("page", PROGRAMS, ids=[page.name for page in PROGRAMS])
def test_what_a_page_shows_works(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if page.name == "gymnasium.md":
        pytest.importorskip("gymnasium", reason="needs the extra gym")
    monkeypatch.chdir(tmp_path)
    known = set(sys.modules)
    names: dict[str, Any] = {"__name__": "documentation"}
    ran = 0
    for block in blocks(page):
        language, text = block.language, block.text
        if language in ("python", "yaml") and (file := FILE.match(text)):
            Path(file[1]).parent.mkdir(parents=True, exist_ok=True)
            Path(file[1]).write_text(text, encoding="utf-8")
        elif language == "python":
            exec(compile("\n" * block.line + text, str(page), "exec"), names)
            ran += 1
        elif page.name == "own-parts.md":
            for command in (command for command in text.splitlines() if command.startswith("origami-lab ")):
                assert main([*shlex.split(command)[1:], *FAST]) == 0, command
                ran += 1
    for name in set(sys.modules) - known:  # the page's own modules are no one else's
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]
    assert ran > 0


def test_the_pages_with_programs_are_found() -> None:
    assert {"python.md", "own-parts.md", "gymnasium.md"} <= {page.name for page in PROGRAMS}
