"""Text as other programs write it: any line ends, byte order marks, something behind the end."""

from __future__ import annotations

import codecs
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

_MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))


def text_of(data: bytes) -> str:
    """The text of a file; bytes that are none in its encoding are replaced, names and comments may hold them."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(encoding, errors="replace")
    return data.decode("utf-8", errors="replace")


def lines_of(data: bytes) -> list[str]:
    """The lines of a file, with Unix, Windows or old Macintosh ends."""
    return text_of(data).replace("\r\n", "\n").replace("\r", "\n").split("\n")


def numbers(words: Iterable[str]) -> NDArray[np.float64]:
    """Words as numbers; raises ValueError that names the one that is none."""
    words = list(words)
    try:
        return np.array(list(map(float, words)), dtype=np.float64)
    except ValueError:
        word = next(word for word in words if not _is_number(word))
        hint = ": decimals must follow a point" if "," in word else ""
        raise ValueError(f"{word[:30]!r} is no number{hint}") from None


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
