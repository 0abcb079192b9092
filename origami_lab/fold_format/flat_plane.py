"""The plane that a crease pattern lies in: is there one, which side is up, and where the vertices are on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from origami_lab.fold_format.flat_graph import Array, Face, Indices
from origami_lab.fold_format.loose_lines import net_area

_AXIS = 1e-6
"""Of the pattern's size: a plane that is no further off is one of the coordinate planes."""


@dataclass(frozen=True, eq=False)
class FlatPlane:
    """A crease pattern laid into its plane."""

    points: Array
    """(V, 2), seen from above."""
    off: float
    """The largest distance of a vertex from the plane, in the file's unit."""
    sure: bool
    """Whether it is said which side is up: by coordinates (x, y) or by the way that faces run around."""
    mirror: tuple[float, float] = (-1.0, 1.0)
    """What coordinates are multiplied by to see the pattern from the other side."""

    def turned_over(self) -> FlatPlane:
        """The pattern seen from the other side."""
        return replace(self, points=self.points * self.mirror)


def lay_into_plane(coords: Array, used: Indices, faces: Sequence[Face] | None, tolerance: float) -> FlatPlane:
    """Lay coordinates (V, 2) or (V, 3) into the plane that fits the vertices ``used`` best.

    Up is z where the plane is level. Of others the file's faces, which FOLD lists counter-clockwise, say which side is
    up; without faces it is the one towards the largest coordinate of the plane's normal, and −y of an upright plane
    (x, z): programs that have y upwards write flat patterns so. Coordinates in a coordinate plane are kept to the last
    bit; ``tolerance`` is a distance from such a plane that counts as none.
    """
    if coords.shape[1] == 2:
        return FlatPlane(np.array(coords), 0.0, True)
    ring = coords[used] if len(used) else coords
    low, high = ring.min(axis=0), ring.max(axis=0)
    size = float((high - low).max())
    for axis, (a, b) in ((2, (0, 1)), (1, (0, 2)), (0, (1, 2))):
        if high[axis] - low[axis] <= max(_AXIS * size, 2.0 * tolerance):
            points, off = coords[:, [a, b]], float(high[axis] - low[axis]) / 2.0
            mirror = (1.0, -1.0) if axis == 1 else (-1.0, 1.0)
            return _faced(FlatPlane(points, off, axis == 2, mirror), faces)
    middle = ring.mean(axis=0)
    _, _, directions = np.linalg.svd(ring - middle, full_matrices=len(ring) < 3)
    normal = directions[2]
    normal = normal * (np.sign(normal[np.argmax(np.abs(normal))]) or 1.0)
    across = np.cross(normal, directions[0])
    points = (coords - middle) @ np.column_stack([directions[0], across])
    off = float(np.abs((ring - middle) @ normal).max())
    return _faced(FlatPlane(points, off, False), faces)


def _faced(plane: FlatPlane, faces: Sequence[Face] | None) -> FlatPlane:
    """The plane with the side up from which most faces run around counter-clockwise, where that decides."""
    if plane.sure or faces is None:
        return plane
    whole = replace(plane, sure=True)
    return whole.turned_over() if net_area(plane.points, faces) < 0.0 else whole
