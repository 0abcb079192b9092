"""What may move in a design: groups of vertices that move together, and in which directions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import CREASE, SQUARE
from origami_lab.game.start_patterns import CHOOSE, Crease, Square
from origami_lab.polish.finer_board import FineBoard

DRIVING_ANGLE = -1
"""The ``members`` of the variable that is no vertex."""
MOST_MEMBERS = 4


class Variables(NamedTuple):
    """N variables of a design.

    Attributes
    ----------
    members
        (N, 4) int64: vertices that move together; the rest of a row is −1. A row without any is the driving angle.
    directions
        (N, 4, 2) int64: how each of them moves, in parts of a cell, for a step of 1.
    free
        (N,) bool: a vertex that moves in both directions of the board, independently.
    """

    members: NDArray[np.int64]
    directions: NDArray[np.int64]
    free: NDArray[np.bool_]


def variables_of(board: FineBoard) -> Variables:
    """All that may move in a design.

    A vertex on a mirror axis moves along it, one where axes meet stays. The corners of a start square about the centre
    move together, on the diagonals; a start crease along x moves as a whole along y, and its ends along x. The corners
    of other start patterns stay, and what the game's settings fix to a number: ``start.size``, ``start.position``,
    ``driving_angle.fixed``.
    """
    rows: list[tuple[list[tuple[int, int, int]], bool]] = []
    game, layout = board.game, board.layout
    corners = range(layout.corners)
    fixed = isinstance(game.start, Square | Crease) and _number(game.start) is not None
    kind = int(board.rules["start"][0])
    if kind == SQUARE:
        if not fixed:
            signs = np.sign(board.points)
            rows.append(([(v, int(signs[v, 0]), int(signs[v, 1])) for v in corners], False))
    elif kind == CREASE:
        if not fixed:
            rows.append(([(v, 0, 1) for v in corners], False))
        rows += [([(v, 1, 0)], False) for v in corners]
    for v in range(layout.corners, len(board.points)):
        axis = int(layout.axis[v])
        if axis == 0:
            rows.append(([(v, 1, 1)], True))
        elif axis > 0:
            rows.append(([(v, *_along(game.symmetry.matrices[axis]))], False))
    if not game.rules.fixed:
        rows.append(([], False))
    members = np.full((len(rows), MOST_MEMBERS), DRIVING_ANGLE, dtype=np.int64)
    directions = np.zeros((len(rows), MOST_MEMBERS, 2), dtype=np.int64)
    for row, (moved, _) in enumerate(rows):
        for place, (v, dx, dy) in enumerate(moved):
            members[row, place], directions[row, place] = v, (dx, dy)
    return Variables(members, directions, np.array([free for _, free in rows], dtype=np.bool_))


def _number(start: Square | Crease) -> int | None:
    """The size or position that the settings fix; None where the player chose it."""
    value = start.size if isinstance(start, Square) else start.position
    return None if value == CHOOSE else int(value)


def _along(mirror: NDArray[np.int64]) -> tuple[int, int]:
    """The direction that a mirror of the board keeps."""
    for direction in ((1, 0), (0, 1), (1, 1), (1, -1)):
        if tuple(mirror @ np.array(direction)) == direction:
            return direction
    raise ValueError("not a mirror of the board")
