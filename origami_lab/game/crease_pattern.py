"""A finished design: the flat crease pattern and its folding motion, independent of the game's buffers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

BOUNDARY, MOUNTAIN, VALLEY, FLAT = "B", "M", "V", "F"

FLAT_ANGLE = 1e-6
"""A crease folded by less than this many radians is written as flat (F): rounding gives such a crease 1e-8."""


@dataclass(frozen=True, eq=False)
class CreasePattern:
    """A crease pattern with one degree of freedom and the motion that its driving angle drives.

    ``V`` vertices, ``E`` edges (creases and boundary), ``F`` panels, ``T`` triangles, ``K`` driving angles
    that the pattern reaches, in increasing order. Lengths are board cells, angles radians.
    """

    vertices: NDArray[np.float64]
    """(V, 2) positions on the board."""
    modes: NDArray[np.int8]
    """(V,) rigid body mode M of each extended vertex (−1 or +1), 0 for a leaf."""
    edges: NDArray[np.int32]
    """(E, 2) pairs of vertices."""
    boundary: NDArray[np.bool_]
    """(E,) whether the edge belongs to one panel only."""
    driven: NDArray[np.bool_]
    """(E,) whether the edge is a source crease, whose fold angle is ± the driving angle."""
    fold_angles: NDArray[np.float64]
    """(K, E) signed fold angles, valley positive, 0 on the boundary."""
    panels: tuple[tuple[int, ...], ...]
    """F polygons, counter-clockwise vertex lists."""
    triangles: NDArray[np.int32]
    """(T, 3) a triangulation of the panels, counter-clockwise."""
    triangle_panels: NDArray[np.int32]
    """(T,) the panel each triangle belongs to."""
    driving_angles: NDArray[np.float64]
    """(K,) the reachable driving angles, increasing."""
    folded: NDArray[np.float64]
    """(K, V, 3) the folded vertices at each driving angle."""
    best: int
    """Index of the driving angle that the objective likes best."""
    actions: tuple[int, ...] = ()
    """The game's actions that lead to the pattern."""
    metadata: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    """Free-form facts (task, seed, return ...); plain JSON values only."""

    @property
    def assignments(self) -> tuple[str, ...]:
        """The assignment of each edge at the best driving angle: M, V, B or F."""
        angles = self.fold_angles[self.best]
        return tuple(
            BOUNDARY if outer else FLAT if abs(angle) <= FLAT_ANGLE else VALLEY if angle > 0 else MOUNTAIN
            for outer, angle in zip(self.boundary, angles, strict=True)
        )
