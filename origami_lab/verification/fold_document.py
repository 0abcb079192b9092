"""A FOLD file as it is to be verified: one crease pattern, and the folded states that the file claims."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.file_digits import Precision
from origami_lab.fold_format.model import FoldModel, Limits
from origami_lab.fold_format.model_reader import read_model

Array = NDArray[np.float64]
Face = tuple[int, ...]

LARGEST_BYTES = 24 * 2**20
MOST_VERTICES, MOST_EDGES, MOST_FACES, MOST_FRAMES = 2000, 6000, 4000, 400
"""What is verified within a minute or so and well below a gigabyte; real designs stay far below it."""
_LIMITS = Limits(LARGEST_BYTES, MOST_VERTICES, MOST_EDGES, MOST_FACES, MOST_FRAMES)


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
    loose: NDArray[np.bool_] | None = None
    """(E,) auxiliary lines, which are no part of the sheet; None where there are none."""
    unread: tuple[str, ...] = ()
    """Folded forms that could not be read as states of the crease pattern, and why, a line each."""
    declared: bool = True
    """Whether the file says by its classes that it shows a crease pattern, or a folded form."""
    fault: str = ""
    """Why the frame that calls itself a crease pattern is none; empty if it is one."""
    precision: Precision = field(default_factory=Precision)
    """By how much the numbers of the file may be off for having been rounded."""
    creator: str = ""
    """The program that wrote the file, if it says so."""


def document_of(source: str | Path | Design) -> Document:
    """The document in a file, or the one that a design in memory would be written as.

    Raises :class:`InputError` on a file that is not FOLD or too large.
    """
    if isinstance(source, str | Path):
        return document_from(read_model(source, limits=_LIMITS))
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


def document_from(model: FoldModel) -> Document:
    """What a file shows, as it is to be verified."""
    count = len(model.edges)
    return Document(
        flat=model.flat,
        edges=model.edges,
        faces=model.faces,
        letters=model.letters or ("U",) * count,
        angles=model.angles,
        driven=model.driven,
        frames=tuple(Frame(s.name, s.driving, s.coords, s.angles, s.letters) for s in model.states),
        remarks=model.remarks,
        loose=model.loose if model.loose.any() else None,
        unread=model.unread,
        declared=model.declared,
        fault=model.fault,
        precision=model.precision,
        creator=model.creator,
    )


def _letters(design: Design, k: int) -> tuple[str, ...]:
    """Assignments as a file would say them; a crease that folds by less than 1e-6 is flat there."""
    return tuple(
        "B" if outer else "F" if abs(angle) <= 1e-6 else "V" if angle > 0.0 else "M"
        for outer, angle in zip(design.boundary, design.fold_angles[k], strict=True)
    )
