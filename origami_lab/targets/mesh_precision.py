"""How precise the coordinates of a mesh file are: what a symmetric part's two halves may differ by."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SINGLE = 2.0**-23
"""A unit in the last place of a float32, relative: most programs compute with it, whatever they write."""
DOUBLE = 2.0**-48
"""Relative error that a calculation in doubles may have left."""
MOST_DIGITS = 6
"""Significant digits beyond which float32 is the coarser one."""
CHANCE = 1
"""Zeros at the ends of values that mean nothing: one in ten has one."""
FINE, COARSE = 1000, 400
"""How many steps of a grid make a part: from FINE on the grid is a rounding's, below COARSE it is the designer's."""
CURVED = 16
"""Different values along an axis that tell a rounded, curved part: designers rarely use so many."""


def coordinate_precision(points: Array) -> float:
    """How far a coordinate (n, 3) may be from what it was meant to be: half a unit in the last place that there is.

    Never better than a unit of float32, whatever the file's format. Coordinates that all have few decimals, few
    significant digits, or lie on any other grid, as after a change of unit, are taken for rounded ones, unless the
    grid is so coarse that it looks designed: a box of whole millimetres is what it is. Read from the values, so that
    what was written with four decimals and then converted to a binary format still has four.
    """
    values = np.unique(np.abs(points))
    largest = float(values[-1]) if len(values) else 0.0
    if not 1e-200 < largest < math.inf:  # squares of smaller ones are nothing to anybody
        return 0.0
    unit = SINGLE * largest
    axes = [np.unique(points[:, axis]) for axis in range(points.shape[1])]
    is_curved = max(map(len, axes)) >= CURVED
    steps = [_decimal_step(values[values > 1e-30 * largest], unit)]
    if is_curved:
        gaps = np.unique(np.concatenate([np.diff(axis) for axis in axes]))
        steps += [_grid_step(gaps, noise) for noise in (DOUBLE * largest, unit)]
    size = max(float(axis[-1] - axis[0]) for axis in axes)
    least = COARSE if is_curved else FINE
    return max([unit, *(0.5 * step for step in steps if step * least <= size)])


def _decimal_step(values: Array, unit: float) -> float:
    """The last decimal place of the largest of some ascending positive values if all are short; 0 if they are not.

    They may have few decimals, or few significant digits. Of both the coarser counts, unless it is unlikely: with the
    finer one, several values end in a zero less than by chance.
    """
    largest = float(values[-1])
    found: list[tuple[float, int]] = []
    for power in range(math.ceil(math.log10(largest)), math.ceil(math.log10(2.0 * unit)) - 1, -1):
        counts = values / 10.0**power
        if (np.abs(counts - np.rint(counts)) <= unit / 10.0**power).all():
            found.append((10.0**power, _zeros(counts)))
            break
    exponents = np.floor(np.log10(values)) + 1
    for digits in range(1, MOST_DIGITS + 1):
        counts = values / 10.0 ** (exponents - digits)
        if (np.abs(counts - np.rint(counts)) <= SINGLE * counts).all():
            found.append((float(10.0 ** (exponents[-1] - digits)), _zeros(counts)))
            break
    if not found:
        return 0.0
    coarse, fine = max(found), min(found)
    return coarse[0] if coarse[1] <= fine[1] + CHANCE else fine[0]


def _zeros(counts: Array) -> int:
    """How many zeros numbers end in, together."""
    whole = np.rint(counts)
    return sum(int((whole[whole > 0.0] % 10.0**place == 0.0).sum()) for place in range(1, 16))


def _grid_step(gaps: Array, noise: float) -> float:
    """The step of the grid that ascending gaps between values, each within ``noise``, are multiples of; 0 for none.

    The gaps are those of all axes: rounding makes the same grid along each, sampling a surface does not. Euclid's
    algorithm for all at once: what is left over of one is tried as the next step.
    """
    gaps = gaps[gaps > 4.0 * noise]
    if not len(gaps):
        return 0.0
    step, error = float(gaps[0]), 2.0 * noise
    while True:
        counts = np.rint(gaps / step)
        allowed = 2.0 * noise + counts * error
        if 4.0 * float(allowed[-1]) > step:
            return 0.0
        rest = np.abs(gaps - counts * step)
        over = np.nonzero(rest > allowed)[0]
        if not len(over):
            return step
        least = over[np.argmin(rest[over])]
        step, error = float(rest[least]), float(allowed[least])
