"""How many digits a file's numbers have, and by how much they may be off for that."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DOUBLE = 15
"""Significant digits from which on numbers are as good as this machine's."""
_GRID = 64.0
"""Numbers that are all multiples of its reciprocal are meant as they stand: halves and quarters are not rounded."""
_SHORT = 1e-3
"""Of the largest number: where rounding would be coarser than this, a few decimals are a grid, not rounding."""
_SINGLE = 2.0**-24
"""What single precision rounds off, relatively."""


@dataclass(frozen=True)
class Precision:
    """By how much the numbers of a file may be off, because they were rounded when it was written.

    0 stands for numbers that are exact (a grid) or written with all digits of double precision. Nothing else knows the
    file's digits: what is accepted as rigid, as closed and as the same angle follows from here, and nothing more.
    """

    flat: float = 0.0
    """Of the crease pattern's coordinates, in the file's unit."""
    folded: float = 0.0
    """Of the folded vertices, in the file's unit: the coarsest frame."""
    angle: float = 0.0
    """Of the stated fold angles, radians."""

    @property
    def exact(self) -> bool:
        """Whether nothing was rounded off."""
        return self.flat == self.folded == self.angle == 0.0

    @property
    def length(self) -> float:
        """The coarser one of the two roundings of coordinates."""
        return max(self.flat, self.folded)

    def words(self) -> str:
        """The digits of the file, for a text: "coordinates with 6 decimals and fold angles with 3"."""
        parts = []
        if self.length > 0.0:
            parts.append(f"coordinates with {plural(decimals(self.length))}")
        if self.angle > 0.0:
            parts.append(f"fold angles with {plural(decimals(math.degrees(self.angle)))}")
        return " and ".join(parts)

    def finer(self, factor: float) -> str:
        """The digits that would be enough were all that is rounded off ``factor`` times smaller, for a text."""
        more = max(1, math.ceil(math.log10(max(factor, 1.0))))
        parts = []
        if self.length > 0.0:
            parts.append(f"coordinates with {plural(min(decimals(self.length) + more, DOUBLE))}")
        if self.angle > 0.0:
            parts.append(f"fold angles with {plural(min(decimals(math.degrees(self.angle)) + more, DOUBLE))}")
        return " and ".join(parts)


def plural(count: int) -> str:
    """A number of decimals in words."""
    return f"{count} decimal" + ("" if count == 1 else "s")


def decimals(rounding: float) -> int:
    """How many decimals leave so much off: half a unit of the last one."""
    return max(0, math.floor(-math.log10(2.0 * rounding) + 1e-6))


def precision(flat: Array | None, folded: Iterable[Array], angles: Iterable[Array]) -> Precision:
    """What the digits of a file say.

    Parameters
    ----------
    flat
        Coordinates of the crease pattern, as the file writes them.
    folded
        Coordinates of each state.
    angles
        Stated fold angles in degrees; NaN is passed over.
    """
    of_flat = 0.0 if flat is None else rounding(flat)
    of_folded = max((rounding(coords) for coords in folded), default=0.0)
    stated = [found[np.isfinite(found)] for found in angles]
    values = np.concatenate(stated) if stated else np.empty(0)
    return Precision(of_flat, of_folded, math.radians(_of_angles(values)))


def rounding(values: Array) -> float:
    """By how much numbers of about one size may be off: half a unit of the last digit of the largest ones.

    Decimals are counted from the largest number down, so that files with fixed decimals and files with fixed
    significant digits are seen alike.
    """
    sizes = np.abs(values).ravel()
    largest = float(sizes.max(initial=0.0))
    if largest == 0.0 or np.all(values * _GRID == np.rint(values * _GRID)):
        return 0.0
    sizes = sizes[sizes > 1e-12 * largest]
    if np.all(sizes == sizes.astype(np.float32)):
        return largest * _SINGLE
    top = math.floor(math.log10(largest))
    digits = _significant(sizes)
    off = 0.5 * 10.0 ** (top + 1 - digits)
    return 0.0 if digits >= DOUBLE or off > _SHORT * largest else off


def _of_angles(degrees: Array) -> float:
    """Degrees by which stated fold angles may be off; they have fixed decimals as a rule."""
    size = np.abs(degrees)
    size = size[(size > 1e-9) & (size < 180.0)]
    if not len(size) or (np.all(size * _GRID == np.rint(size * _GRID)) and not np.all(size == np.rint(size))):
        return 0.0
    if not np.all(size == np.rint(size)) and np.all(size == size.astype(np.float32)):
        return 180.0 * _SINGLE
    places = _decimals(size)
    return 0.0 if places >= DOUBLE - 3 else 0.5 * 10.0**-places


def _significant(sizes: Array) -> int:
    """The most significant digits that any of some positive numbers is written with; at most :data:`DOUBLE`."""
    exponent = np.floor(np.log10(sizes))

    def same(digits: int) -> bool:
        shift = digits - 1 - exponent  # digits behind the point
        up, down = 10.0 ** np.maximum(shift, 0.0), 10.0 ** np.maximum(-shift, 0.0)
        return bool(np.all(np.rint(sizes * up / down) * down / up == sizes))

    return _least(same, 1)


def _decimals(values: Array) -> int:
    """The least number of decimals that all values can be written with; at most :data:`DOUBLE`."""
    return _least(lambda places: bool(np.all(np.rint(values * 10.0**places) / 10.0**places == values)), 0)


def _least(enough: Callable[[int], bool], low: int) -> int:
    """The least number from ``low`` to :data:`DOUBLE` that is enough; each above it is, too."""
    high = DOUBLE
    while low < high:
        middle = (low + high) // 2
        if enough(middle):
            high = middle
        else:
            low = middle + 1
    return low
