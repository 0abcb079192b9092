"""One line, nearest word, no passwords."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Iterable, Sequence


def shorten(value: object, most: int = 200) -> str:
    """A value as text, its middle left out if it is long."""
    text = str(value)
    return text if len(text) <= most else f"{text[: most // 2]} … {text[-most // 2 :]}"


def one_line(text: str) -> str:
    """Text that cannot disturb a terminal: line breaks as spaces, other control characters escaped."""
    spaced = " ".join(text.splitlines())
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in spaced)


def nearest(word: str, words: Iterable[str]) -> str:
    """The end of a message that suggests the most similar word, empty if none is similar."""
    found = difflib.get_close_matches(word, list(words), n=1, cutoff=0.6)
    return f"; did you mean {found[0]}?" if found else ""


def without_password(uri: str) -> str:
    """The same address, for people."""
    # a password may hold any character, so all up to the last @ goes
    return re.sub(r"(?i)(password=)[^&\s]*", r"\1...", re.sub(r"//\S*@", "//", uri))


def command_text(command: Sequence[str]) -> str:
    """A command for people and records: without the passwords in its addresses."""
    return shlex.join(map(without_password, command))


def first_line(text: str) -> str:
    """The first line of a message that is not empty."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[0] if lines else "cannot be used"
