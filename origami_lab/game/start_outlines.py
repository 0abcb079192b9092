"""Outlines of start patterns: points, turns and symmetry, and what the rules' record says of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.kernels.state import LARGEST_PANEL
from origami_lab.game.moves import Point
from origami_lab.geometry.groups import SymmetryGroup

Half = tuple[int, int]
"""Half of a board's sides: x runs from −half to half by the first, y by the second."""


def maps_to_itself(corners: list[Point], signs: tuple[int, ...], group: SymmetryGroup) -> bool:
    """Whether a symmetry group maps an outline to itself, its sides to sides of the same sign and nothing inside out.

    ``corners`` go round counter-clockwise, ``signs`` are those of the sides from each to the next; of a crease there
    are two, its own and 0 for the panel that stays.
    """
    count = len(corners)
    sides = {(corners[i], corners[(i + 1) % count]): signs[i] for i in range(count)}
    for matrix in group.matrices:
        turned = np.linalg.det(matrix) < 0
        for (a, b), sign in sides.items():
            (x, y), (z, w) = ((int(t) for t in matrix @ np.array(p)) for p in (a, b))
            side = ((z, w), (x, y)) if turned else ((x, y), (z, w))
            if sides.get(side) != sign:
                return False
    return True


def outline_fields(corners: list[Point], signs: tuple[int, ...]) -> dict[str, Any]:
    """The fields of the rules' record for a pattern that is given."""
    room = np.zeros((LARGEST_PANEL, 2), dtype=np.int32)
    sides = np.zeros(LARGEST_PANEL, dtype=np.int32)
    room[: len(corners)], sides[: len(corners)] = corners, signs
    return {"n_corners": len(corners), "corners": room, "sides": sides, "n_driven": int(np.count_nonzero(signs))}


def picked_box(
    group: SymmetryGroup, wide: tuple[int, ...], high: tuple[int, ...], is_square: int = 0
) -> dict[str, Any]:
    """The fields of the rules' record for a rectangle whose corners are chosen, of least and most width and height."""
    flips = flips_of(group)
    picks = 1 if all(flips.values()) else 2
    least, most = ((wide[j], high[j]) for j in range(2))
    is_square = int(is_square or group.name == "xyd")
    return {"picks": picks, "n_driven": 4, "least": least, "most": most, "is_square": is_square, **flips}


def flips_of(group: SymmetryGroup) -> dict[str, int]:
    """Whether a group takes x to −x, and y to −y."""
    has = {tuple(matrix.ravel().tolist()) for matrix in group.matrices}
    return {"flips_x": int((-1, 0, 0, 1) in has), "flips_y": int((1, 0, 0, -1) in has)}


def has_room(fields: Mapping[str, Any], half: Half, corner: Point | None = None) -> bool:
    """Whether a rectangle fits, its lower left corner at one point if that is given."""
    least, most = fields["least"], fields["most"]
    sides = []
    for j, flips in enumerate((fields["flips_x"], fields["flips_y"])):
        inside = half[j] - 1
        if corner is None:
            lengths = list(range(least[j], min(most[j], 2 * inside) + 1))
            found = [length for length in lengths if not flips or length % 2 == 0]
        else:
            lengths = [-2 * corner[j]] if flips else list(range(least[j], inside - corner[j] + 1))
            found = [length for length in lengths if least[j] <= length <= most[j] and abs(corner[j]) <= inside]
        sides.append(set(found))
    return bool(sides[0] & sides[1] if fields["is_square"] else sides[0] and sides[1])


def turn_at(corners: list[Point], i: int) -> int:
    """Positive where an outline turns left at its i-th corner."""
    (ax, ay), (bx, by), (cx, cy) = corners[i - 1], corners[i], corners[(i + 1) % len(corners)]
    return (bx - ax) * (cy - by) - (by - ay) * (cx - bx)


def winds_once(corners: list[Point]) -> bool:
    """Whether an outline that always turns to one side goes round once only."""
    ends = np.array(corners, dtype=float)
    sides = np.roll(ends, -1, axis=0) - ends
    angles = np.arctan2(sides[:, 1], sides[:, 0])
    steps = (np.roll(angles, -1) - angles + np.pi) % (2 * np.pi) - np.pi
    return abs(abs(steps.sum()) - 2 * np.pi) < 1e-6


def board_point(field: str, value: Any, half: Half | None, expected: str) -> Point:
    """A board point that is not on the board's edge; raises InputError."""
    if not is_list(value) or len(value) != 2 or not all(is_whole(t) for t in value):
        raise InputError(field, value, f"must be {expected}")
    x, y = int(value[0]), int(value[1])
    if half is not None and not (abs(x) < half[0] and abs(y) < half[1]):
        inside = f"x from {1 - half[0]} to {half[0] - 1}, y from {1 - half[1]} to {half[1] - 1}"
        raise InputError(field, [x, y], f"must lie inside the board's edge, {inside}")
    return x, y


def is_list(value: Any) -> bool:
    return isinstance(value, list | tuple)


def is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)
