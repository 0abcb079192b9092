"""Reading FOLD files from anywhere: everything is checked; a wrong file is one line, never a traceback."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.fold_format.fold_file import ACTIONS, ANGLE, DRIVEN, METADATA, MODE, FoldFile, FoldFrame

_LARGEST = 64 * 2**20
"""Bytes; a design with 1000 vertices is a few hundred kB. Parsed JSON takes about ten times its size."""
_LETTERS = frozenset("BMVFUCJ")
_LARGEST_COORDINATE = 1e9
"""Beyond this, products of coordinates lose all meaning (and soon overflow)."""


def read_fold(path: str | os.PathLike[str]) -> FoldFile:
    """Read and check a FOLD file.

    Needed are ``vertices_coords`` (flat), ``edges_vertices``, ``edges_assignment``, ``edges_foldAngle`` and
    ``faces_vertices`` of the key frame. Frames in ``file_frames`` with class ``foldedForm`` and coordinates
    of their own become folded forms; other frames are passed over.

    Raises :class:`InputError`, whose field is the path, on anything that is not such a file.
    """
    return FoldReader(Path(path)).read()


class FoldReader:
    """One file being read; carries the path for the messages."""

    def __init__(self, path: Path, largest: int = _LARGEST) -> None:
        self.path, self.largest = path, largest

    def refuse(self, value: object, expected: str) -> NoReturn:
        """Raise the one-line error; long values are cut."""
        text = " ".join(str(value).split())
        raise InputError(str(self.path), text if len(text) <= 60 else text[:57] + "...", expected) from None

    def read(self) -> FoldFile:
        """The whole file."""
        fold = self.load()
        coords = self.coordinates(fold, "vertices_coords", None)
        if coords.shape[1] == 3 and np.any(coords[:, 2] != 0.0):
            self.refuse("vertices_coords", "the first frame must be the flat crease pattern (z = 0)")
        size = len(coords)
        edges = self.indices(fold, "edges_vertices", size)
        if any(len(edge) != 2 or edge[0] == edge[1] for edge in edges):
            self.refuse("edges_vertices", "every edge must be a pair of two different vertices")
        panels = self.indices(fold, "faces_vertices", size)
        if any(len(panel) < 3 for panel in panels):
            self.refuse("faces_vertices", "every face must have at least three vertices")
        count = len(edges)
        assignments = self.assignments(fold, count)
        angles = self.angles(fold, count)
        modes = self.optional(fold, MODE, size, (-1, 0, 1))
        driven = self.optional(fold, DRIVEN, count, (False, True))
        metadata = fold.get(METADATA, {})
        if not isinstance(metadata, dict):
            self.refuse(METADATA, "must be an object")
        return FoldFile(
            vertices=np.ascontiguousarray(coords[:, :2]),
            edges=np.array(edges, dtype=np.int32).reshape(-1, 2),
            assignments=assignments,
            fold_angles=angles,
            panels=tuple(_counter_clockwise(panel, coords) for panel in panels),
            modes=None if modes is None else np.array(modes, dtype=np.int8),
            driven=None if driven is None else np.array(driven, dtype=np.bool_),
            frames=self.frames(fold, size, count, assignments, angles),
            actions=self.actions(fold),
            title=_line(fold.get("file_title")) or _line(fold.get("frame_title")),
            metadata=metadata,
        )

    def load(self) -> dict[str, Any]:
        """The JSON object, or the reason why there is none."""
        try:
            size = self.path.stat().st_size
            if size > self.largest:
                self.refuse(f"{size} bytes", f"must be at most {self.largest} bytes")
            text = self.path.read_text(encoding="utf-8-sig")
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
        if key not in frame:
            self.refuse(f"no {key}", f"a FOLD file of a crease pattern must have {key}")
        value = frame[key]
        if not isinstance(value, list) or (length is None and not value):
            self.refuse(f"{key} is {_brief(value)}", "must be a list that is not empty")
        if length is not None and len(value) != length:
            self.refuse(f"{key} has {len(value)} items", f"must have {length}, one each")
        return value

    def number(self, value: object, key: str, largest: float) -> float:
        """A finite number of sane size."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not -largest <= value <= largest:
            self.refuse(f"{key} has {_brief(value)}", f"must be numbers of at most {largest:g}")
        return float(value)

    def coordinates(self, frame: Mapping[str, Any], key: str, length: int | None) -> NDArray[np.float64]:
        """(V, 2) or (V, 3) coordinates."""
        rows = self.array(frame, key, length)
        wide = len(rows[0]) if isinstance(rows[0], list) else 0
        if wide not in (2, 3) or any(not isinstance(row, list) or len(row) != wide for row in rows):
            self.refuse(key, "every vertex must have the same number of coordinates, 2 or 3")
        numbers = [[self.number(item, key, _LARGEST_COORDINATE) for item in row] for row in rows]
        return np.array(numbers, dtype=np.float64)

    def indices(self, frame: Mapping[str, Any], key: str, size: int) -> tuple[tuple[int, ...], ...]:
        """Lists of vertex indices in [0, size)."""
        rows = self.array(frame, key, None)
        for row in rows:
            if not isinstance(row, list):
                self.refuse(f"{key} has {_brief(row)}", "must be lists of vertices")
            for item in row:
                if isinstance(item, bool) or not isinstance(item, int) or not 0 <= item < size:
                    self.refuse(f"{key} has {_brief(item)}", f"must be vertices from 0 to {size - 1}")
        return tuple(tuple(row) for row in rows)

    def assignments(self, frame: Mapping[str, Any], count: int) -> tuple[str, ...]:
        """The letter of each edge."""
        letters = self.array(frame, "edges_assignment", count)
        for letter in letters:
            if not isinstance(letter, str) or letter not in _LETTERS:
                self.refuse(f"edges_assignment has {_brief(letter)}", "must be B, M, V, F, U, C or J")
        return tuple(letters)

    def angles(self, frame: Mapping[str, Any], count: int) -> NDArray[np.float64]:
        """The fold angle of each edge, radians; null (undefined) is read as 0."""
        key = "edges_foldAngle"
        degrees = [0.0 if x is None else self.number(x, key, 180.0) for x in self.array(frame, key, count)]
        return np.radians(np.array(degrees, dtype=np.float64))

    def optional(self, frame: Mapping[str, Any], key: str, length: int, allowed: Sequence[int]) -> Any:
        """A list of ``length`` items out of ``allowed``, or None where the key is missing."""
        if key not in frame:
            return None
        values = self.array(frame, key, length)
        if any(type(value) is not type(allowed[0]) or value not in allowed for value in values):
            self.refuse(key, f"must be a list of {', '.join(json.dumps(item) for item in allowed)}")
        return values

    def actions(self, fold: Mapping[str, Any]) -> tuple[int, ...]:
        """The game's actions, integers."""
        values = fold.get(ACTIONS, [])
        if not isinstance(values, list) or any(
            isinstance(x, bool) or not isinstance(x, int) or abs(x) > 2**62 for x in values
        ):
            self.refuse(ACTIONS, "must be a list of integers")
        return tuple(values)

    def frames(
        self,
        fold: Mapping[str, Any],
        size: int,
        count: int,
        assignments: tuple[str, ...],
        angles: NDArray[np.float64],
    ) -> tuple[FoldFrame, ...]:
        """The folded forms; what a frame does not say it inherits from the key frame."""
        found = fold.get("file_frames", [])
        if not isinstance(found, list) or any(not isinstance(frame, dict) for frame in found):
            self.refuse("file_frames", "must be a list of frames")
        frames = []
        for index, frame in enumerate(found, start=1):
            classes = frame.get("frame_classes", [])
            if not isinstance(classes, list) or "foldedForm" not in classes or "vertices_coords" not in frame:
                continue
            if frame.get("frame_inherit") is not True or frame.get("frame_parent", 0) != 0:
                self.refuse(f"frame {index}", "a folded form must inherit from the crease pattern, frame 0")
            coords = self.coordinates(frame, "vertices_coords", size)
            if coords.shape[1] == 2:
                coords = np.column_stack([coords, np.zeros(size)])
            degrees = frame.get(ANGLE)
            frames.append(
                FoldFrame(
                    None if degrees is None else math.radians(self.number(degrees, ANGLE, 360.0)),
                    coords,
                    self.angles(frame, count) if "edges_foldAngle" in frame else angles,
                    self.assignments(frame, count) if "edges_assignment" in frame else assignments,
                )
            )
        return tuple(frames)


def _counter_clockwise(panel: tuple[int, ...], coords: NDArray[np.float64]) -> tuple[int, ...]:
    """The polygon with its inside on the left; FOLD asks for it, not all programs care."""
    x, y = coords[list(panel), :2].T
    twice_area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return panel[::-1] if twice_area < 0.0 else panel


def _brief(value: object) -> str:
    """A value in a message; a structure, which may be deep, only by its kind."""
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "an object"
    return json.dumps(value)[:40]


def _line(value: object) -> str:
    """A title as one line of sane length; empty where it is no text."""
    return " ".join(value.split())[:120] if isinstance(value, str) else ""
