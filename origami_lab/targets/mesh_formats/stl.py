"""STL files, binary or text, by what they hold and not by what their first word says."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from origami_lab.targets.mesh_formats.polygons import Array, Polygons
from origami_lab.targets.mesh_formats.text_lines import numbers, text_of

HEADER, RECORD = 84, 50
"""Bytes before the first triangle of a binary file, and of each."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> Polygons:
    """Its triangles, three vertices each; several solids in one file are taken together.

    Raises
    ------
    ValueError
        If it ends before it has what it promises, or promises less than it has.
    """
    if len(data) < HEADER or len(data) != HEADER + RECORD * _count(data, 0):
        text = text_of(data).lower()
        if re.search(r"\bouter\s+loop\b", text) or (len(text) < HEADER and text.lstrip().startswith("solid")):
            return _read_text(text)
    corners = _read_binary(data).reshape(-1, 3)
    return Polygons(corners, np.arange(len(corners)), np.full(len(corners) // 3, 3))


def _count(data: bytes, start: int) -> int:
    return int.from_bytes(data[start + HEADER - 4 : start + HEADER], "little")


def _read_binary(data: bytes) -> Array:
    """(T, 3, 3); what follows the triangles is ignored unless it is a solid, too, or looks like more triangles."""
    if len(data) < HEADER:
        raise ValueError(f"cut off: a binary STL begins with {HEADER} bytes, it has {len(data)}")
    solids, start = [], 0
    while True:
        count = _count(data, start)
        end = start + HEADER + RECORD * count
        if end > len(data):
            there = (len(data) - start - HEADER) // RECORD
            raise ValueError(f"cut off: its header promises {count} triangles, there are {there}")
        solids.append(np.frombuffer(data, _TRIANGLE, count, start + HEADER)["corners"].astype(np.float64))
        left = len(data) - end
        # one file written behind another one
        if left > HEADER and 0 < _count(data, end) <= (left - HEADER) // RECORD:
            start = end
            continue
        if left and left % RECORD == 0 and _belongs(np.frombuffer(data, _TRIANGLE, -1, end)["corners"], solids):
            raise ValueError(f"its header promises {count} triangles, {left // RECORD} more follow")
        return np.concatenate(solids)


def _belongs(more: NDArray[np.float32], solids: list[Array]) -> bool:
    """Whether records behind the promised ones are triangles in the same place."""
    before = np.concatenate(solids)
    reach = 10.0 * float(np.abs(before).max()) if len(before) else 1e9
    with np.errstate(invalid="ignore"):
        return bool((np.abs(more) <= reach).all() and (np.ptp(more, axis=1).max(axis=1) > 0.0).all())


def _read_text(text: str) -> Polygons:
    # names of solids are free
    text = re.sub(r"(?m)^[ \t]*(?:end)?solid\b(?!.*\bfacet\b).*$", "", text.replace("\r", "\n"))
    words: list[str] = []
    sizes: list[int] = []
    loops = re.split(r"\bouter\s+loop\b", text)
    for number, loop in enumerate(loops[1:], start=1):
        corners, end, _ = loop.partition("endloop")
        found = corners.split()
        if not end:
            where = "cut off within" if number == len(loops) - 1 else "there is no endloop in"
            raise ValueError(f"{where} triangle {number}")
        if len(found) % 4 or len(found) < 12 or any(word != "vertex" for word in found[::4]):
            raise ValueError(f"triangle {number} does not have three vertices")
        del found[::4]
        words += found
        sizes.append(len(found) // 3)
    rest = loops[-1].rpartition("endloop")[2].replace("endfacet", "").strip()
    if rest and len(loops) > 1 and (rest.startswith("facet") or "facet".startswith(rest)):
        raise ValueError(f"cut off within triangle {len(loops)}")
    return Polygons(numbers(words).reshape(-1, 3), np.arange(len(words) // 3), np.array(sizes, dtype=np.int64))
