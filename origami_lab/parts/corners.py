"""Corners of a tray: where two walls meet, the paper between them is to be tucked away behind one of them.

At such a corner of the start panel both walls' outer creases would come to lie on one line in space, and the paper
between them would stand out from the part. So one wall's outer crease is moved in by an angle, and the paper is folded
behind that wall: flat, when the walls are up. For the pattern to be exact, the ends of all its creases must be board
points. Here is found how far such paper reaches, as the board must have room for it. It is not the only way: searches
find others, of more creases, where no single fold has its places on the board.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from origami_lab.parts.unfolding import BaseSide

RIGHT = 1e-6
"""Of a cell, within which a point is a board point here."""


@dataclass(frozen=True)
class Corner:
    """A corner of the base between two walls."""

    place: tuple[float, float]
    """Its place on the board."""
    reach: float
    """Cells along either wall that the tucked paper covers; infinite if no board points allow it."""
    height: float
    """Cells that the walls are wide, unfolded; 0 where they do not begin at the corner."""


def corners_between(sides: Sequence[BaseSide], driven: Sequence[bool], scale: float) -> list[Corner]:
    """The corners at which two driven walls meet."""
    found = []
    for second in range(len(sides)):
        first = (second - 1) % len(sides)
        if driven[first] and driven[second]:
            x, y = (float(t) for t in scale * sides[second].start)
            rises = (sides[first].rises[1], sides[second].rises[0])
            height = max(float(scale * rise[1]) if rise is not None else 0.0 for rise in rises)
            found.append(Corner((x, y), _reach(sides[first], sides[second], scale), height))
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
