"""Texts for people: in one line, with the nearest word, without secrets."""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Iterable, Sequence

from origami_lab.addresses import hidden, hidden_word


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


def command_text(command: Sequence[str]) -> str:
    """A command for people and records: without the secrets in its addresses."""
    return shlex.join(hidden(hidden_word(word)) for word in command)


def duration(seconds: float) -> str:
    """A length of time in the unit that suits it, for what is not known more exactly."""
    if seconds < 90:
        return f"{max(seconds, 1.0):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def short_of(angle: float) -> str:
    """The setting for a largest driving angle, in degrees, that stops before paper comes to lie on paper there."""
    return f"driving_angle.max={angle - 0.5:.4g}"


def first_line(text: str) -> str:
    """The first line of a message that is not empty."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[0] if lines else "cannot be used"
