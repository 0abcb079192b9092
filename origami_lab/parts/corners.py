"""Corners of a tray: where two walls meet, the paper between them is to be tucked away behind one of them.

At such a corner of the start panel both walls' outer creases would come to lie on one line in space, and the paper
between them would stand out from the part. So one wall's outer crease is moved in by an angle, and the paper is folded
behind that wall: flat, when the walls are up. For the pattern to be exact, the ends of all its creases must be board
points (docs/from-a-part.md draws it). Here is found whether there are such points.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from origami_lab.geometry.groups import SymmetryGroup
from origami_lab.parts.unfolding import BaseSide

RIGHT = 1e-6
"""Of a cell, within which a point is a board point here."""
MOST_CORNERS = 10


@dataclass(frozen=True)
class Corner:
    """A corner of the base between two walls, the second of which begins where the first one ends."""

    sides: tuple[int, int]
    place: tuple[float, float]
    """Its place on the board."""
    reach: float
    """Cells along either wall that the tucked paper covers; infinite if it has no such place on the board."""


def corners_between(sides: Sequence[BaseSide], driven: Sequence[bool], scale: float) -> list[Corner]:
    """The corners at which two driven walls meet."""
    found = []
    for second in range(len(sides)):
        first = (second - 1) % len(sides)
        if driven[first] and driven[second]:
            x, y = (float(t) for t in scale * sides[second].start)
            found.append(Corner((first, second), (x, y), _reach(sides[first], sides[second], scale)))
    return found


def _reach(first: BaseSide, second: BaseSide, scale: float) -> float:
    """How far along a wall the tucked paper reaches, at the least; infinite where none can be exact."""
    rises = first.rises[1], second.rises[0]
    directions = [(side.end - side.start) / side.length for side in (first, second)]
    if rises[0] is None or rises[1] is None or abs(float(directions[0] @ directions[1])) > 1e-6:
        return math.inf
    (ahead, up), (other_ahead, other_up) = scale * rises[0], scale * rises[1]
    if abs(ahead - other_ahead) > 1e-3 or abs(up - other_up) > 1e-3 or abs(first.fold - second.fold) > 1e-3:
        return math.inf
    return tucked_reach(round(float(ahead), 3), round(float(up), 3), max(first.length, second.length) * scale)


def tucked_reach(ahead: float, up: float, most: float) -> float:
    """The least reach of the paper that is tucked behind a wall at a right-angled corner of the base.

    Parameters
    ----------
    ahead, up
        Where the walls' common edge ends in the unfolded wall: beyond the side's end, and away from the side.
    most
        No reach above this is looked for.

    Returns
    -------
    The reach along the wall in cells; infinite if board points do not allow any.
    """
    lean = math.atan2(ahead, up)
    if abs(up - round(up)) > RIGHT:
        return math.inf
    for inward in range(math.floor(1 - ahead), math.floor(most) + 1):
        # the wall's own crease ends at (−inward, up) behind the corner, the tucked one where both meet the wall's top
        turned = lean + math.atan2(inward, up)
        folded = 0.25 * math.pi + turned - 2.0 * lean
        if not turned > 0.0 or folded >= 0.5 * math.pi - 1e-9:
            continue
        reach, distance = up * math.tan(folded), up / math.cos(folded)
        if reach > most + RIGHT:
            break
        tip = distance * math.cos(0.25 * math.pi - turned), distance * math.sin(0.25 * math.pi - turned)
        if all(abs(t - round(t)) <= RIGHT for t in tip):
            return reach
    return math.inf


def can_be_tucked(corners: Sequence[Corner], sides: Sequence[BaseSide], scale: float, group: SymmetryGroup) -> bool:
    """Whether every corner's paper finds a wall, none twice at one place, and alike under a symmetry group."""
    if len(corners) > MOST_CORNERS or any(math.isinf(corner.reach) for corner in corners):
        return False
    lengths = [scale * side.length for side in sides]
    images = [_images(corners, matrix) for matrix in group.matrices]
    for choice in itertools.product((0, 1), repeat=len(corners)):
        loads = [0.0] * len(sides)
        for corner, which in zip(corners, choice, strict=True):
            loads[corner.sides[which]] += corner.reach
        if any(load > length + RIGHT for load, length in zip(loads, lengths, strict=True)):
            continue
        # a mirror exchanges the walls before and after a corner, a turn does not
        if all(
            image is not None
            and all(choice[image[i]] == (choice[i] if turns else 1 - choice[i]) for i in range(len(corners)))
            for image, turns in images
        ):
            return True
    return False


def _images(
    corners: Sequence[Corner], matrix: np.ndarray[tuple[int, ...], np.dtype[np.int64]]
) -> tuple[list[int] | None, bool]:
    """Which corner each one is mapped to, None if to none, and whether the map is a turn."""
    places = np.array([corner.place for corner in corners]).reshape(-1, 2)
    found = []
    for place in places @ matrix.T:
        off = np.abs(places - place).max(axis=1)
        if off.min() > 1e-3:
            return None, True
        found.append(int(np.argmin(off)))
    return found, bool(np.linalg.det(matrix) > 0.0)
