"""What a FOLD file holds, as arrays, close to the file: a flat key frame and the folded frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.file_digits import Precision

LARGEST_LENGTH = 1e4
"""Millimetres that are taken from a file."""


@dataclass(frozen=True, eq=False)
class FoldFrame:
    """One folded form of the pattern."""

    driving_angle: float | None
    """Radians; None where the file does not say."""
    coords: NDArray[np.float64]
    """(V, 3) folded vertices, in board cells."""
    fold_angles: NDArray[np.float64]
    """(E,) radians, valley positive."""
    assignments: tuple[str, ...]
    """(E,) M, V, B, F, U ... at this step of the motion."""


@dataclass(frozen=True, eq=False)
class FoldFile:
    """A crease pattern and its folded forms, as read from a FOLD file."""

    vertices: NDArray[np.float64]
    """(V, 2) positions on the board."""
    edges: NDArray[np.int32]
    """(E, 2) pairs of vertices."""
    assignments: tuple[str, ...]
    """(E,) M, V, B, F, U ... of the key frame: those of the best driving angle."""
    fold_angles: NDArray[np.float64]
    """(E,) radians, valley positive, those of the best driving angle."""
    panels: tuple[tuple[int, ...], ...]
    """Polygons, counter-clockwise vertex lists."""
    modes: NDArray[np.int8] | None
    """(V,) rigid body mode M, 0 for a leaf; None where the file does not say."""
    driven: NDArray[np.bool_] | None
    """(E,) whether the edge is a driven (source) crease; None where the file does not say."""
    frames: tuple[FoldFrame, ...]
    """The folded forms in the order of the file: the best one is the last."""
    actions: tuple[int, ...] = ()
    """The game's actions that lead to the pattern; empty in foreign files."""
    title: str = ""
    metadata: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    """Facts about the trial (task, search, seed, return ...)."""
    assumed: NDArray[np.bool_] | None = None
    """(E,) creases whose fold angle the file does not state, ±180° by their letter; None where there are none."""
    loose: NDArray[np.bool_] | None = None
    """(E,) auxiliary lines: neither sides of panels nor creases; None where there are none."""
    precision: Precision = field(default_factory=Precision)
    """By how much the numbers may be off for having been rounded."""
    remarks: tuple[str, ...] = ()
    """What was assumed, turned or passed over when the file was read, a line each."""

    @property
    def upright(self) -> NDArray[np.float64]:
        """(3, 3) the rotation that stands the folded sheet as it is used: up along z, its front along −y.

        The file may say what is up and what is in front; without, nothing is turned.
        """
        up = _direction(self.metadata.get("up"), (0.0, 0.0, 1.0))
        front = _direction(self.metadata.get("front"), (0.0, -1.0, 0.0))
        if np.linalg.norm(np.cross(up, front)) < 1e-6:  # any front will do
            front = np.eye(3)[int(np.argmin(np.abs(up)))]
        right = np.cross(up, front)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(up, right), up])

    @property
    def cell(self) -> float | None:
        """Millimetres a board cell, where the run that made it was told; None where the file does not say."""
        found = _lengths(self.metadata.get("cell_mm"), 1)
        return None if found is None else found[0]

    @property
    def sheet(self) -> tuple[float, float] | None:
        """Width and height in millimetres of what it is to be cut from; None where the file does not say."""
        found = _lengths(self.metadata.get("sheet_mm"), 2)
        return None if found is None else (found[0], found[1])

    @property
    def best(self) -> FoldFrame:
        """The last frame, or the flat sheet where the file has no frames."""
        return self.frames[-1] if self.frames else self.flat

    @property
    def pattern(self) -> FoldFrame:
        """The crease pattern as the file states it: flat, with its own assignments and fold angles."""
        return FoldFrame(None, self.flat.coords, self.fold_angles, self.assignments)

    @property
    def flat(self) -> FoldFrame:
        """The unfolded sheet in the plane z = 0, as a frame."""
        coords = np.column_stack([self.vertices, np.zeros(len(self.vertices))])
        letters = tuple("B" if letter == "B" else "F" for letter in self.assignments)
        return FoldFrame(0.0, coords, np.zeros(len(self.edges)), letters)

    @property
    def motion(self) -> tuple[FoldFrame, ...]:
        """The frames by increasing driving angle; in the order of the file where it does not say."""
        known = [(frame.driving_angle, frame) for frame in self.frames if frame.driving_angle is not None]
        if len(known) < len(self.frames):
            return self.frames
        return tuple(frame for _, frame in sorted(known, key=lambda pair: abs(pair[0])))


def _lengths(known: Any, count: int) -> list[float] | None:
    """So many lengths in millimetres from what a file says, if that is such."""
    values = known if isinstance(known, list | tuple) else [known]
    good = all(isinstance(n, int | float) and not isinstance(n, bool) and 0.0 < n <= LARGEST_LENGTH for n in values)
    return [float(n) for n in values] if good and len(values) == count else None


def _direction(known: object, default: tuple[float, float, float]) -> NDArray[np.float64]:
    """A unit vector from what a file says, if that is one."""
    if isinstance(known, list) and len(known) == 3 and all(isinstance(n, int | float) for n in known):
        length = float(np.linalg.norm(vector := np.array(known, dtype=np.float64)))
        if 1e-6 < length < np.inf:
            return vector / length
    return np.array(default)
