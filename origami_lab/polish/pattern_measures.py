"""How hard a pattern is to make: how many creases and panels it has, and how small the smallest are."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.crease_pattern import CreasePattern


@dataclass(frozen=True)
class PatternFigures:
    """Figures of a crease pattern."""

    creases: int
    panels: int
    smallest_sector: float
    """The smallest angle at a corner of a panel, degrees."""
    smallest_width: float
    """The width of the narrowest panel, board cells."""

    def to_json(self) -> dict[str, float]:
        return asdict(self)


def pattern_figures(design: CreasePattern) -> PatternFigures:
    """The figures of a pattern."""
    polygons = [design.vertices[list(panel)] for panel in design.panels]
    return PatternFigures(
        creases=int(np.count_nonzero(~design.boundary)),
        panels=len(design.panels),
        smallest_sector=math.degrees(min((float(_sectors(p).min()) for p in polygons), default=math.nan)),
        smallest_width=min((width_of(p) for p in polygons), default=math.nan),
    )


def _sectors(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) interior angles of a counter-clockwise polygon, radians."""
    after, before = np.roll(polygon, -1, axis=0) - polygon, np.roll(polygon, 1, axis=0) - polygon
    sine = after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0]
    return np.asarray(np.arctan2(sine, (after * before).sum(axis=1)) % (2 * np.pi))


def width_of(polygon: NDArray[np.float64]) -> float:
    """The width of a polygon: of all strips that hold it, that of the narrowest.

    Such a strip lies along a side of the convex hull.
    """
    from scipy.spatial import ConvexHull

    corners = polygon[ConvexHull(polygon).vertices]
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.linalg.norm(sides, axis=1)[:, None]
    across = np.einsum("ij,kij->ik", normals, corners[:, None, :] - corners[None, :, :])
    return float(across.max(axis=1).min())
