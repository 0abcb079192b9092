"""The scale at which corners come to lie on board points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from origami_lab.parts.surface import Array

ON_POINTS = 1e-6
"""Of the largest coordinate: corners so near to board points lie on them."""
MOST_CELLS = 60
"""From the middle of the part to its furthest corner, or from corner to corner."""
NEARLY = 1.3
"""A scale whose corners are off by no more than this factor of the best is as good, if it is smaller."""


@dataclass(frozen=True)
class Lattice:
    """A scale, and where the corners then are."""

    scale: float
    """Cells per unit of the file."""
    cells: int
    """Along what the scale was counted by: the furthest a corner is from the middle or from the other corners."""
    off: float
    """Furthest that a corner is from a board point, cells."""


def lattices(corners: Array, mirrored: tuple[bool, bool], precision: float) -> tuple[list[Lattice], Lattice]:
    """The scales at which all corners lie on board points, the smallest first; and the best small one of all.

    Parameters
    ----------
    corners
        (n, 2) places in the plane of the sheet, units of the file; the first one becomes a board point.
    mirrored
        Whether x, and whether y, is counted from a mirror's axis at 0, which must become a line of the board.
    precision
        How far a corner may be from where it was meant to be.
    """
    counted = corners - np.where(mirrored, 0.0, corners[0])
    values = np.unique(np.abs(counted))
    longest = float(values[-1])
    found = list(_lattices(values, longest))
    exact = [one for one in found if one.off <= ON_POINTS * one.cells + min(8.0 * precision * one.scale, 0.02)]
    off = [one.off / one.cells for one in found[3:24]]
    limit = NEARLY * min(off)
    return exact, next(one for one in found[3:24] if one.off / one.cells <= limit)


def _lattices(values: Array, longest: float) -> Iterator[Lattice]:
    for cells in range(1, MOST_CELLS + 1):
        scaled = values * (cells / longest)
        yield Lattice(cells / longest, cells, float(np.abs(scaled - np.rint(scaled)).max()))
