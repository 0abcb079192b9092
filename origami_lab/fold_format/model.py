"""The contents of a FOLD file, whatever its dialect: one crease pattern and the states of it that the file claims."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.checked_json import LARGEST_BYTES
from origami_lab.fold_format.file_digits import Precision
from origami_lab.fold_format.flat_graph import Array, Face, Indices, area, crossing_edges, faces_between, without_holes
from origami_lab.fold_format.loose_lines import MOST_EDGES

SAME_PLACE = 1e-9
"""Of the pattern's size: closer than this, flat points coincide."""


@dataclass(frozen=True)
class Limits:
    """The largest file that is read, by what it holds."""

    bytes: int = LARGEST_BYTES
    vertices: int | None = 1_000_000
    edges: int | None = 1_000_000
    faces: int | None = 1_000_000
    frames: int | None = 10_000


@dataclass(frozen=True, eq=False)
class FoldState:
    """One state that the file claims: by folded vertices, by fold angles, or both."""

    index: int
    """The frame, 0 for the key frame."""
    driving: float | None
    """The driving angle, radians; None where the file does not say."""
    coords: Array | None
    """(V, 3) folded vertices."""
    angles: Array | None
    """(E,) fold angles in radians, valley positive, NaN where undefined; None where the frame has none of its own."""
    letters: tuple[str, ...]
    """(E,) assignments at this state, U where the file has none."""

    @property
    def name(self) -> str:
        """The state in messages."""
        return f"frame {self.index}"


@dataclass(frozen=True, eq=False)
class FoldModel:
    """One crease pattern and its states, in the order of the file; None stands for what the file does not say."""

    index: int
    """The frame of the crease pattern, or of the first state where the file has no crease pattern."""
    flat: Array | None
    """(V, 2) the flat sheet seen from above."""
    edges: Indices
    """(E, 2)"""
    faces: tuple[Face, ...] | None
    """The panels that the file lists, counter-clockwise."""
    letters: tuple[str, ...] | None
    """(E,) B, M, V, F, U, C, J."""
    angles: Array | None
    """(E,) fold angles of the crease pattern itself in radians, NaN where null."""
    loose: NDArray[np.bool_]
    """(E,) auxiliary lines: neither sides of panels nor creases."""
    modes: NDArray[np.int8] | None
    """(V,) rigid body modes."""
    driven: NDArray[np.bool_] | None
    """(E,) driven creases."""
    declared: bool
    """Whether the file itself says by its classes that this is a crease pattern, or a folded form."""
    states: tuple[FoldState, ...]
    chosen: int | None = None
    """The number of the state that a reader asked for by its frame."""
    fault: str = ""
    """Why the frame that calls itself a crease pattern is none; empty if it is one."""
    unread: tuple[str, ...] = ()
    """Folded forms that could not be read as states of this pattern, and why, a line each."""
    remarks: tuple[str, ...] = ()
    """What was assumed, turned or passed over, a line each."""
    precision: Precision = field(default_factory=Precision)
    creator: str = ""
    title: str = ""
    actions: tuple[int, ...] = ()
    metadata: Mapping[str, Any] = field(default_factory=dict)

    @property
    def used(self) -> Indices:
        """Numbers of the vertices that an edge of the sheet has."""
        return np.unique(self.edges[~self.loose])


def panels_of(model: FoldModel) -> tuple[Face, ...]:
    """The panels, counter-clockwise: the file's, or those between the edges; none where that does not say."""
    flat = model.flat
    if model.faces is not None:
        return tuple(f[::-1] if flat is not None and area(flat, f) < 0.0 else f for f in model.faces)
    edges = model.edges[~model.loose]
    if flat is None or np.any(np.all(flat[edges[:, 0]] == flat[edges[:, 1]], axis=1)):
        return ()
    if len(np.unique(np.sort(edges, axis=1), axis=0)) < len(edges):
        return ()
    size = float(np.ptp(flat[model.used], axis=0).max(initial=0.0))
    if len(edges) <= MOST_EDGES and crossing_edges(flat, edges, SAME_PLACE * size) is not None:
        return ()
    outer = np.array([letter in "BC" for letter in model.letters or ("U",) * len(model.edges)], dtype=np.bool_)
    faces = without_holes(faces_between(flat, edges), edges, outer[~model.loose])
    return tuple(face for face in faces if len(set(face)) == len(face))
