"""The pages of the documentation, their fenced blocks, and the commands in them."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
_BLOCK = re.compile(r"(?:^<!-- (?P<mark>[\w ,]+) -->\n)?^```(?P<language>[\w{}-]*)\n(?P<text>.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    language: str
    text: str
    mark: str
    """What an HTML comment on the line before it says, which no reader sees: ``composed``."""


@dataclass(frozen=True)
class Command:
    """A command of ours as a page shows it, without its comment."""

    page: Path
    line: int
    words: tuple[str, ...]
    composed: bool
    """Whether it needs a cluster or a server, so that no test may run it."""

    def __str__(self) -> str:
        return f"{self.page.name}:{self.line}: {shlex.join(self.words)}"


def blocks(page: Path) -> list[Block]:
    """All fenced blocks of a page, in their order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(
            page,
            text.count("\n", 0, found.start("language")) + 1,
            found["language"],
            found["text"],
            found["mark"] or "",
        )
        for found in _BLOCK.finditer(text)
    ]


def commands(page: Path) -> list[Command]:
    """All commands in blocks that name no language: a line each, or several lines that end with a backslash."""
    found = []
    for block in blocks(page):
        if block.language not in ("", "sh"):
            continue
        text = block.text.replace("\\\n", " ")
        for offset, line in enumerate(text.splitlines(), start=1):
            for part in line.split("&&"):
                if part.split()[:1] == ["origami-lab"]:
                    words = tuple(shlex.split(part, comments=True)[1:])
                    found.append(Command(page, block.line + offset, words, block.mark == "composed"))
    return found
