"""A FOLD file as it is to be verified: one crease pattern, and the folded states that the file claims."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.fold_file import ANGLE, DRIVEN
from origami_lab.fold_format.reader import FoldReader

Array = NDArray[np.float64]
Face = tuple[int, ...]

LARGEST_BYTES = 24 * 2**20
MOST_VERTICES, MOST_EDGES, MOST_FACES, MOST_FRAMES = 2000, 6000, 4000, 400
"""What is verified within a minute or so and well below a gigabyte; real designs stay far below it."""


class Design(Protocol):
    """What is needed of a crease pattern in memory (``origami_lab.game.crease_pattern.CreasePattern`` has it)."""

    @property
    def vertices(self) -> Array: ...
    @property
    def edges(self) -> NDArray[np.int32]: ...
    @property
    def boundary(self) -> NDArray[np.bool_]: ...
    @property
    def driven(self) -> NDArray[np.bool_]: ...
    @property
    def fold_angles(self) -> Array: ...
    @property
    def panels(self) -> tuple[Face, ...]: ...
    @property
    def driving_angles(self) -> Array: ...
    @property
    def folded(self) -> Array: ...


@dataclass(frozen=True, eq=False)
class Frame:
    """One state that the file claims: by folded vertices, by fold angles, or both."""

    name: str
    driving: float | None
    """Radians; None where the file does not say."""
    coords: Array | None
    """(V, 3) folded vertices."""
    angles: Array | None
    """(E,) fold angles in radians, valley positive, NaN where undefined; None where the frame has none of its own."""
    letters: tuple[str, ...]
    """(E,) assignments at this state."""


@dataclass(frozen=True, eq=False)
class Document:
    """The crease pattern and its states, in the order of the file."""

    flat: Array | None
    """(V, 2) the flat sheet; None where the file has folded states only."""
    edges: NDArray[np.int64]
    """(E, 2)"""
    faces: tuple[Face, ...] | None
    letters: tuple[str, ...]
    angles: Array | None
    """(E,) fold angles of the crease pattern itself (the state that it is meant for), if it has any."""
    driven: NDArray[np.bool_] | None
    frames: tuple[Frame, ...]
    remarks: tuple[str, ...] = ()


def document_of(source: str | Path | Design) -> Document:
    """The document in a file, or the one that a design in memory would be written as.

    Raises :class:`InputError` on a file that is not FOLD or too large.
    """
    if isinstance(source, str | Path):
        return _Reader(Path(source), LARGEST_BYTES).document()
    count = len(source.edges)
    frames = tuple(
        Frame(f"state {k + 1}", float(angle), source.folded[k], source.fold_angles[k], _letters(source, k))
        for k, angle in enumerate(source.driving_angles)
    )
    return Document(
        flat=np.asarray(source.vertices, dtype=np.float64),
        edges=np.asarray(source.edges, dtype=np.int64).reshape(-1, 2),
        faces=tuple(tuple(int(v) for v in panel) for panel in source.panels),
        letters=frames[-1].letters if frames else tuple("B" if outer else "F" for outer in source.boundary),
        angles=None if frames else np.zeros(count),
        driven=np.asarray(source.driven, dtype=np.bool_),
        frames=frames,
    )


def _letters(design: Design, k: int) -> tuple[str, ...]:
    """Assignments as a file would say them; a crease that folds by less than 1e-6 is flat there."""
    return tuple(
        "B" if outer else "F" if abs(angle) <= 1e-6 else "V" if angle > 0.0 else "M"
        for outer, angle in zip(design.boundary, design.fold_angles[k], strict=True)
    )


class _Reader(FoldReader):
    """A reader of other programs' frames and omissions, for which :func:`read_fold` is too strict."""

    def document(self) -> Document:
        """The whole file."""
        key = self.load()
        listed = key.get("file_frames", [])
        if not isinstance(listed, list) or any(not isinstance(frame, dict) for frame in listed):
            self.refuse("file_frames", "must be a list of frames")
        if len(listed) > MOST_FRAMES:
            self.refuse(f"{len(listed)} frames", f"must be at most {MOST_FRAMES}")
        frames = [{name: value for name, value in key.items() if name != "file_frames"}, *listed]
        whole = [self.resolved(frames, index) for index in range(len(frames))]
        base = next((frame for frame in whole if _is_flat(frame)), None)
        base = base or next((frame for frame in whole if "vertices_coords" in frame), whole[0])
        coords = self.coordinates(base, "vertices_coords", None)
        size = len(coords)
        edges = self.indices(base, "edges_vertices", size)
        if any(len(edge) != 2 or edge[0] == edge[1] for edge in edges):
            self.refuse("edges_vertices", "every edge must be a pair of two different vertices")
        faces = self.indices(base, "faces_vertices", size) if base.get("faces_vertices") else None
        if faces is not None and any(len(face) < 3 for face in faces):
            self.refuse("faces_vertices", "every face must have at least three vertices")
        for count, most, what in (
            (size, MOST_VERTICES, "vertices"),
            (len(edges), MOST_EDGES, "edges"),
            (len(faces or ()), MOST_FACES, "faces"),
            (sum(map(len, faces or ())), 2 * MOST_EDGES, "sides of faces"),
        ):
            if count > most:
                self.refuse(f"{count} {what}", f"must be at most {most}")
        letters = self.letters(base, len(edges))
        flat = coords[:, :2] if _is_flat(base) else None
        states, remarks = [], []
        for index, (own, frame) in enumerate(zip(frames, whole, strict=True)):
            if frame is base and flat is not None:
                continue
            if "vertices_coords" not in frame or _is_flat(frame):
                continue
            if frame.get("edges_vertices") != base["edges_vertices"]:
                remarks.append(f"frame {index} shows another graph and was not looked at")
                continue
            states.append(self.frame(index, own, frame, size, len(edges)))
        driven = self.optional(base, DRIVEN, len(edges), (False, True))
        return Document(
            flat=flat,
            edges=np.array(edges, dtype=np.int64).reshape(-1, 2),
            faces=faces,
            letters=letters,
            angles=self.degrees(base, len(edges)) if flat is not None else None,
            driven=None if driven is None else np.array(driven, dtype=np.bool_),
            frames=tuple(states),
            remarks=tuple(remarks),
        )

    def resolved(self, frames: list[dict[str, Any]], index: int) -> dict[str, Any]:
        """A frame with all that it inherits."""
        chain, seen = [], set()
        while True:
            if index in seen:
                self.refuse("frame_parent", "a frame must not inherit from itself")
            seen.add(index)
            chain.append(frames[index])
            if index == 0 or frames[index].get("frame_inherit") is not True:
                break
            parent = frames[index].get("frame_parent", 0)
            if isinstance(parent, bool) or not isinstance(parent, int) or not 0 <= parent < len(frames):
                self.refuse("frame_parent", f"must be a frame, 0 to {len(frames) - 1}")
            index = parent
        whole: dict[str, Any] = {}
        for frame in reversed(chain):
            if "frame_classes" not in frame:
                whole.pop("frame_classes", None)
            whole |= frame
        return whole

    def frame(self, index: int, own: Mapping[str, Any], whole: Mapping[str, Any], size: int, count: int) -> Frame:
        """A folded state."""
        coords = self.coordinates(whole, "vertices_coords", size)
        if coords.shape[1] == 2:
            coords = np.column_stack([coords, np.zeros(size)])
        degrees = whole.get(ANGLE)
        return Frame(
            name=f"frame {index}",
            driving=None if degrees is None else math.radians(self.number(degrees, ANGLE, 360.0)),
            coords=coords,
            angles=self.degrees(own, count),
            letters=self.letters(whole, count),
        )

    def letters(self, frame: Mapping[str, Any], count: int) -> tuple[str, ...]:
        """Assignments, U where the file has none."""
        return self.assignments(frame, count) if "edges_assignment" in frame else ("U",) * count

    def degrees(self, frame: Mapping[str, Any], count: int) -> Array | None:
        """Fold angles in radians, NaN where null; None where the frame has none."""
        if "edges_foldAngle" not in frame:
            return None
        angles = self.angles(frame, count)
        angles[[value is None for value in frame["edges_foldAngle"]]] = np.nan
        return angles


def _is_flat(frame: Mapping[str, Any]) -> bool:
    """Whether a frame shows the unfolded sheet: it says so, or it does not say and lies in the plane z = 0."""
    classes = frame.get("frame_classes", [])
    coords = frame.get("vertices_coords")
    if not isinstance(coords, list) or not coords or (isinstance(classes, list) and "foldedForm" in classes):
        return False
    return all(isinstance(row, list) and (len(row) == 2 or (len(row) == 3 and row[2] == 0)) for row in coords)
