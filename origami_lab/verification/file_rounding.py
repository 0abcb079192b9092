"""How exactly a file says what it says: measured on its own states, in its own unit.

Panels that are bent and loops that stay open by a little are rounding. It widens what counts as rigid and closed, and
narrows what counts as free of crossings: panels that are nearer to each other than rounding may move them are "too
imprecise to tell".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from origami_lab.fold_format.file_digits import Precision
from origami_lab.verification.certificate import OK, OPEN, WRONG
from origami_lab.verification.flat_sheet import Sheet
from origami_lab.verification.fold_document import Document
from origami_lab.verification.measured_panels import diameters
from origami_lab.verification.plane_graph import Array

EXACT = 1e-10
"""Of the sheet's size, and radians: rounding below this is that of floating-point numbers."""
SAFETY = 10.0
"""Rounding of states adds up along a chain of panels; several times what one panel shows is allowed for."""
RIGID = 1e-5
"""Of its diameter: by how much a rigid panel may differ from its flat self (our files 1e-15, six digits 1e-6)."""
SAME_ANGLE = math.radians(0.02)
"""A stated fold angle may differ from the measured one by this."""
CLOSES = math.radians(0.1)
"""A loop around a vertex closes if it does so by this, with fold angles as they are written in a file."""
FAR_BENT, FAR_TURNED = 1e-2, math.radians(0.5)
"""Of a panel's diameter, and radians: rounding that is coarser than this hides real faults."""
LOOSE = 3.0
"""So many times what is allowed is still no contradiction in a file that rounds: it is too imprecise to tell."""


@dataclass(frozen=True, eq=False)
class Allowance:
    """What counts as rigid, as the same angle and as closed in a file with its digits.

    Beyond :data:`FAR_BENT` and :data:`FAR_TURNED` it is no longer told from a fault.
    """

    rigid: Array
    """(F,) lengths by which panels may differ from their flat selves."""
    angle: Array
    """(E,) radians by which measured and stated fold angles may differ."""
    closed: Array
    """(fans,) radians by which loops may fail to close."""
    exact: bool
    """Whether the file rounds nothing: then what is not allowed is a contradiction."""

    def status(self, times: float) -> str:
        """What it says of a file that something is so many times as far off as is allowed."""
        return OK if times <= 1.0 else OPEN if times <= LOOSE and not self.exact else WRONG


def allowance(sheet: Sheet, document: Document) -> Allowance:
    """What the digits of a file allow; of an exact file the least."""
    digits = document.precision
    ends = sheet.points[sheet.edges]
    lengths = np.maximum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 1e-300)
    along = (ends[:, 1] - ends[:, 0]) / lengths[:, None]
    reach = np.full(len(sheet.edges), np.inf)
    for e in np.flatnonzero(sheet.inner):
        for panel in sheet.beside[e]:
            rel = sheet.points[list(sheet.faces[panel])] - ends[e, 0]
            reach[e] = min(reach[e], np.abs(along[e, 0] * rel[:, 1] - along[e, 1] * rel[:, 0]).max())
    # a corner is off in two coordinates on the flat sheet, in three when folded; both panels of a crease are tilted
    turned = 4.0 * (digits.flat + digits.folded) / reach + 2.0 * digits.angle
    skewed = 2.0 * digits.flat / lengths
    return Allowance(
        rigid=np.maximum(RIGID * diameters(sheet), math.sqrt(2.0) * digits.flat + math.sqrt(3.0) * digits.folded),
        angle=np.maximum(SAME_ANGLE, turned),
        closed=np.array([max(CLOSES, float((turned + skewed)[list(fan.edges)].sum())) for fan in sheet.fans]),
        exact=digits.exact,
    )


@dataclass(frozen=True)
class Rounding:
    """By how much the states of a file may be off."""

    length: float = 0.0
    """In the file's unit: how far vertices are from where rigid panels have them, or what digits leave off."""
    angle: float = 0.0
    """Radians: by how much loops fail to close, or what the digits of fold angles leave off."""
    digits: Precision = field(default_factory=Precision)
    """What the file rounds off."""

    def length_margin(self, size: float) -> float:
        """How near panels of a sheet of that size must not come for a verdict; 0 for a file that is exact."""
        if self.length <= EXACT * size and self.angle <= EXACT:
            return 0.0
        return SAFETY * max(self.length, self.angle * size)

    def angle_margin(self, size: float) -> float:
        """Radians within which fold angles and singular values mean nothing; 0 for a file that is exact."""
        if self.length <= EXACT * size and self.angle <= EXACT:
            return 0.0
        return SAFETY * max(self.length / size, self.angle)

    def words(self, size: float, factor: float | None = None) -> str:
        """How exact the file is, to end a sentence with; ``factor`` times as exact would do, all digits by default."""
        off = max(self.length, self.angle * size)
        if self.digits.exact:
            return f"the file's states are off by {off:.1g} of its units"
        wanted = factor if factor is not None else off / (EXACT * size)
        return f"the file has {self.digits.words()}; {self.digits.finer(wanted)} would do"


def rounding_of(document: Document, size: float, bent: float, unclosed: float) -> Rounding:
    """By how much the states of a file may be off.

    What the digits leave off counts where it shows: a short number in a file whose states fit it to all digits is meant
    as it stands.

    Parameters
    ----------
    size
        Of the sheet, in the file's unit.
    bent, unclosed
        By how much panels were found bent, a length, and loops open, radians.
    """
    if bent <= EXACT * size and unclosed <= EXACT:
        return Rounding(bent, unclosed, document.precision)
    digits = document.precision
    measured = any(frame.coords is not None for frame in document.frames)
    return Rounding(
        max(bent, 2.0 * digits.length if measured else 0.0),
        max(unclosed, 0.0 if measured else 2.0 * digits.angle),
        digits,
    )
