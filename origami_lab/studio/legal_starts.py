"""Where a start pattern or a driven crease may be laid, as outlines and segments of the board."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.boundary import tail
from origami_lab.game.kernels.boundary_sources import boundary_action
from origami_lab.game.kernels.corner_choice import start_corners
from origami_lab.game.kernels.state import LARGEST_PANEL, PLACEMENT, States
from origami_lab.game.moves import Point


@dataclass(frozen=True)
class Segment:
    """A boundary segment on which a driven crease may be laid: its ends, and the actions by the crease's sign."""

    ends: tuple[Point, Point]
    actions: dict[int, tuple[int, ...]]


def start_outlines(game: Game, states: States) -> list[list[Point]]:
    """The outlines of the start patterns that may be laid, by option; none while their corners are chosen."""
    if int(states["phase"][0]) != PLACEMENT or not (game.legal(states) >= 3 * game.rules.points + 5).any():
        return []
    room, found = np.zeros((LARGEST_PANEL, 2), dtype=np.int32), []
    for option in range(int(game.rules.record["n_placements"][0])):
        count = int(start_corners(states[0], game.rules.record[0], option, room))
        found.append([(int(x), int(y)) for x, y in room[:count]])
    return found


def free_segments(game: Game, states: States) -> list[Segment]:
    """The segments of a sheet's boundary that may have a driven crease, in a state between two moves."""
    legal, n, state = set(game.legal(states).tolist()), game.rules.points, states[0]

    def at(code: int) -> Point:
        x, y = game.symmetry.matrices[code & 7] @ state["xy"][code >> 3]
        return int(x), int(y)

    found = []
    for end in range(2):
        first = 3 * n + 1 + 2 * end
        if first in legal:
            v = int(state["head"]) if end == 0 else int(tail(state))
            other = int(state["prev"][v] if end == 0 else state["next"][v])
            found.append(Segment((at(8 * v), at(other)), {-1: (first,), 1: (first + 1,)}))
    begins = int(boundary_action(game.rules.record[0]))
    if begins in legal:
        trial = states.copy()
        for place in game.play(trial, begins).tolist():
            leaf = point_of(game, place - 2 * n)
            v = next(v for v in range(int(state["n_vertices"])) if at(8 * v) == leaf and not state["modes"][v])
            ends = leaf, at(int(state["next"][v]))
            found.append(Segment(ends, {-1: (begins, place), 1: (begins + 1, place)}))
    return found


def point_of(game: Game, index: int) -> Point:
    """The board point of an index, row by row from the lower left."""
    row, column = divmod(int(index), game.board[0])
    return column - game.rules.half[0], row - game.rules.half[1]
