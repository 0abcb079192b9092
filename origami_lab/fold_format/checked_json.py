"""The values of a FOLD file's JSON, checked one by one: a wrong one is one line, never a traceback."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.files import regular_bytes
from origami_lab.text import one_line

Array = NDArray[np.float64]
Face = tuple[int, ...]

LARGEST_BYTES = 32 * 2**20
"""A design with 1000 vertices is a few hundred kB. Parsed JSON takes up to forty times its size."""
LETTERS = frozenset("BMVFUCJ")
LARGEST_COORDINATE = 1e9
"""Beyond this, products of coordinates lose all meaning (and soon overflow)."""
_HALF_TURN = 180.001
"""Degrees: what rounding makes of 180 is read as 180."""


class CheckedJson:
    """One file's JSON; it carries the path for the messages, and a key whose value is null counts as missing."""

    def __init__(self, path: Path, largest: int = LARGEST_BYTES) -> None:
        self.path, self.largest = path, largest

    def refuse(self, value: object, expected: str) -> NoReturn:
        """Raise the one-line error; long values are cut."""
        text = " ".join(str(value).split())
        raise InputError(str(self.path), text if len(text) <= 60 else text[:57] + "...", expected) from None

    def load(self) -> dict[str, Any]:
        """The JSON object, or the reason why there is none."""
        try:
            size = self.path.stat().st_size
            if size > self.largest:
                self.refuse(f"{size} bytes", f"must be at most {self.largest} bytes")
            text = regular_bytes(self.path, self.largest).decode("utf-8-sig")
        except OSError as error:
            self.refuse(error.strerror or type(error).__name__, "must be a FOLD file that can be read")
        except UnicodeDecodeError:
            self.refuse("binary data", "must be a FOLD file, which is JSON text")
        try:
            fold = json.loads(text, parse_constant=self.constant)
        except json.JSONDecodeError as error:
            self.refuse(f"{error.msg} at line {error.lineno}", "must be a FOLD file, which is JSON text")
        except (RecursionError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            self.refuse(type(error).__name__, "must be a FOLD file; this JSON is too deep or too long")
        if not isinstance(fold, dict):
            self.refuse(type(fold).__name__, "must be a FOLD file, which is one JSON object")
        return fold

    def constant(self, name: str) -> NoReturn:
        """JSON has no NaN or Infinity, though Python's parser takes them."""
        self.refuse(name, "numbers must be finite")

    def array(self, frame: Mapping[str, Any], key: str, length: int | None) -> list[Any]:
        """The list under ``key``, of ``length`` items (None: at least one)."""
        value = frame.get(key)
        if value is None:
            self.refuse(f"no {key}", f"a FOLD file of a crease pattern must have {key}")
        if not isinstance(value, list) or (length is None and not value):
            self.refuse(f"{key} is {brief(value)}", "must be a list that is not empty")
        if length is not None and len(value) != length:
            self.refuse(f"{key} has {len(value)} items", f"must have {length}, one each")
        return value

    def number(self, value: object, key: str, largest: float) -> float:
        """A finite number of sane size."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not -largest <= value <= largest:
            self.refuse(f"{key} has {brief(value)}", f"must be numbers of at most {largest:g}")
        return float(value)

    def coordinates(self, frame: Mapping[str, Any], length: int | None) -> Array:
        """(V, 2) or (V, 3) coordinates; where only some vertices have a third one, it is 0 for the others."""
        key = "vertices_coords"
        rows = self.array(frame, key, length)
        if any(not isinstance(row, list) or len(row) not in (2, 3) for row in rows):
            self.refuse(key, "every vertex must have 2 or 3 coordinates")
        wide = max(map(len, rows))
        flat = [item for row in rows for item in (row if len(row) == wide else [*row, 0.0])]
        sane = set(map(type, flat)) <= {float, int} and max(map(abs, flat)) <= LARGEST_COORDINATE
        for item in () if sane else flat:  # which says what is wrong
            self.number(item, key, LARGEST_COORDINATE)
        return np.array(flat, dtype=np.float64).reshape(-1, wide)

    def indices(self, frame: Mapping[str, Any], key: str, size: int) -> tuple[Face, ...]:
        """Lists of vertex numbers below ``size``."""
        rows = self.array(frame, key, None)
        for row in rows:
            if not isinstance(row, list):
                self.refuse(f"{key} has {brief(row)}", "must be lists of vertices")
            for item in row:
                if isinstance(item, bool) or not isinstance(item, int) or not 0 <= item < size:
                    self.refuse(f"{key} has {brief(item)}", f"must be vertices from 0 to {size - 1}")
        return tuple(tuple(row) for row in rows)

    def edges(self, frame: Mapping[str, Any], size: int) -> tuple[Face, ...]:
        """Pairs of different vertices; the faces' sides where the file lists no edges and says nothing of them."""
        said = any(key.startswith("edges_") and value is not None for key, value in frame.items())
        if not said and frame.get("faces_vertices"):
            faces = self.faces(frame, size) or ()
            sides = ((u, v) for face in faces for u, v in zip(face, (*face[1:], face[0]), strict=True))
            found: Sequence[Face] = tuple(dict.fromkeys((min(side), max(side)) for side in sides))
        else:
            found = self.indices(frame, "edges_vertices", size)
        if any(len(edge) != 2 or edge[0] == edge[1] for edge in found):
            self.refuse("edges_vertices", "every edge must be a pair of two different vertices")
        return tuple(found)

    def faces(self, frame: Mapping[str, Any], size: int) -> tuple[Face, ...] | None:
        """Polygons of at least three vertices, or None where the file lists none."""
        if frame.get("faces_vertices") in (None, []):
            return None
        faces = self.indices(frame, "faces_vertices", size)
        if any(len(face) < 3 for face in faces):
            self.refuse("faces_vertices", "every face must have at least three vertices")
        return faces

    def letters(self, frame: Mapping[str, Any], count: int) -> tuple[str, ...] | None:
        """The letter of each edge, or None where the file has none."""
        if frame.get("edges_assignment") is None:
            return None
        letters = self.array(frame, "edges_assignment", count)
        for letter in letters:
            if not isinstance(letter, str) or letter.upper() not in LETTERS:
                self.refuse(f"edges_assignment has {brief(letter)}", "must be B, M, V, F, U, C or J")
        return tuple(letter.upper() for letter in letters)

    def angles(self, frame: Mapping[str, Any], count: int) -> Array | None:
        """(E,) fold angles in degrees, NaN where null; None where the file has none.

        ``edges_foldAngles`` is what the key was called in FOLD 1.0.
        """
        key = "edges_foldAngle" if frame.get("edges_foldAngle") is not None else "edges_foldAngles"
        if frame.get(key) is None:
            return None
        values = self.array(frame, key, count)
        degrees = [np.nan if x is None else self.number(x, key, _HALF_TURN) for x in values]
        return np.clip(np.array(degrees, dtype=np.float64), -180.0, 180.0)

    def optional(self, frame: Mapping[str, Any], key: str, length: int, allowed: Sequence[int]) -> Any:
        """A list of ``length`` items out of ``allowed``, or None where the key is missing."""
        if frame.get(key) is None:
            return None
        values = self.array(frame, key, length)
        if any(type(value) is not type(allowed[0]) or value not in allowed for value in values):
            self.refuse(key, f"must be a list of {', '.join(json.dumps(item) for item in allowed)}")
        return values

    def integers(self, frame: Mapping[str, Any], key: str) -> tuple[int, ...]:
        """A list of integers that a machine can hold; empty where the key is missing."""
        values = frame.get(key)
        values = [] if values is None else values
        if not isinstance(values, list) or any(
            isinstance(x, bool) or not isinstance(x, int) or abs(x) > 2**62 for x in values
        ):
            self.refuse(key, "must be a list of integers")
        return tuple(values)

    def record(self, frame: Mapping[str, Any], key: str) -> dict[str, Any]:
        """An object; empty where the key is missing."""
        value = frame.get(key)
        if value is not None and not isinstance(value, dict):
            self.refuse(key, "must be an object")
        return value or {}


def brief(value: object) -> str:
    """A value in a message; a structure, which may be deep, only by its kind."""
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "an object"
    return json.dumps(value)[:40]


def line(value: object) -> str:
    """A title as one line of sane length; empty where it is no text."""
    if not isinstance(value, str):
        return ""
    return one_line(" ".join(value[:10_000].split())[:120].encode("utf-8", "replace").decode())
