"""What a FOLD file holds, as arrays, close to the file: a flat key frame and the folded frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

CREATOR = "origami-lab"
ANGLE = "origami_lab:driving_angle"
ACTIONS = "origami_lab:actions"
METADATA = "origami_lab:metadata"
MODE = "vertices_origami_lab:mode"
DRIVEN = "edges_origami_lab:driven"


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

    @property
    def up(self) -> NDArray[np.float64]:
        """(3,) the direction that is up when the folded sheet stands as it is used: z where the file does not say."""
        known = self.metadata.get("up")
        numbers = isinstance(known, list) and len(known) == 3 and all(isinstance(n, int | float) for n in known)
        up = np.array(known if numbers else (0.0, 0.0, 1.0), dtype=np.float64)
        return up if np.isfinite(up).all() and np.linalg.norm(up) > 1e-6 else np.array([0.0, 0.0, 1.0])

    @property
    def best(self) -> FoldFrame:
        """The last frame, or the flat sheet where the file has no frames."""
        return self.frames[-1] if self.frames else self.flat

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
