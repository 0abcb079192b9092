"""Changes of a design: what is cut away, or shifted, before it is laid and grown again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import Record
from origami_lab.game.move_table import EXTEND, PLACE, SOURCE, Flags, Moves, Points
from origami_lab.jit import bare
from origami_lab.search.neighbourhood.one_run import RunDesign
from origami_lab.search.random_stream import Draws

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """A changed design.

    Attributes
    ----------
    design
        The design with the vertex shifted or the mode flipped.
    goes
        (M,) int8, 1 for the moves that are cut away.
    first
        The first move that goes or is not as it was.
    """

    design: RunDesign
    goes: Flags
    first: int


class Shift(NamedTuple):
    """What is not as it was in a table of moves.

    Attributes
    ----------
    move
        The move whose mode is turned over, −1 for none.
    vertex, x, y
        The vertex that lies elsewhere, −1 for none, and how far.
    """

    move: int
    vertex: int
    x: int
    y: int


TOO_FEW = -1
"""In place of the number of draws used: the block ends before the change is made."""


def unchanged(design: RunDesign) -> Change:
    """The design as it is."""
    return Change(design, np.zeros(len(design.moves), dtype=np.int8), len(design.moves))


def is_bare(design: RunDesign) -> bool:
    """Whether there is nothing but the start pattern."""
    return len(design.moves) == placements(design.moves)


@bare
def placements(moves: Moves) -> int:
    """How many of the first moves place the start pattern: one, or none where it is made of moves."""
    return int(moves.shape[0] > 0 and moves[0].kind == PLACE)


def random_move(design: RunDesign, draws: Draws) -> int:
    """Any move but the placement."""
    placed = placements(design.moves)
    return placed + draws.below(len(design.moves) - placed)


def cut(design: RunDesign, chosen: int, more: float, draws: Draws) -> Change:
    """Cut a move away, and with probability ``more`` each another random one, again and again."""
    goes = np.zeros(len(design.moves), dtype=np.int8)
    while (used := mark_cuts(design.moves, chosen, more, goes, draws.block, draws.used)) == TOO_FEW:
        draws.reserve(draws.available + 1)
    draws.used = used
    return Change(design, goes, int(np.argmax(goes)))


@bare
def mark_cuts(moves: Moves, chosen: int, more: float, goes: Flags, draws: Array, used: int) -> int:
    """Mark the moves that :func:`cut` cuts away; returns the draws used in all, or :data:`TOO_FEW`."""
    count, placed = moves.shape[0], placements(moves)
    for m in range(count):
        goes[m] = 0
    goes[chosen] = 1
    while used + 1 < draws.shape[0]:
        if draws[used] >= more:
            return used + 1
        goes[placed + int(draws[used + 1] * (count - placed))] = 1
        used += 2
    return TOO_FEW


def shift(design: RunDesign, chosen: int, half: tuple[int, int], flip: float, draws: Draws) -> Change | None:
    """Shift a vertex of a move to a neighbouring board point, or with probability ``flip`` turn its mode over.

    Whatever names the vertex goes with it. None if there is nothing to be changed: no extension, a point off the board,
    or a vertex that the start pattern has laid.
    """
    draws.reserve(SHIFT_DRAWS)
    line = design.moves, design.points, design.own, chosen, half, flip
    found, draws.used = choose_shift(*line, draws.block, draws.used)
    if found.move < 0 and found.vertex < 0:
        return None
    moves, points, goes = design.moves.copy(), design.points.copy(), np.zeros(len(design.moves), dtype=np.int8)
    make_shift(moves, points, found, 1)
    return Change(replace(design, moves=moves, points=points), goes, int(first_changed(moves, found)))


SHIFT_DRAWS = 3
"""Random numbers that a shift needs at most."""


@bare
def choose_shift(
    moves: Moves,
    points: Points,
    own: int,
    chosen: int,
    half: tuple[int, int],
    flip: float,
    draws: Array,
    used: int,
) -> tuple[Shift, int]:
    """What :func:`shift` changes, none of both if nothing; and the draws used in all."""
    move, nothing = moves[chosen], Shift(-1, -1, 0, 0)
    if move.kind != EXTEND:
        return nothing, used
    if draws[used] < flip:
        return Shift(chosen, -1, 0, 0), used + 1
    children = (move.first, move.second, move.middle)
    count = 0
    for child in children:
        count += int(child >= 0)
    which = int(draws[used + 1] * count)
    v = -1
    for child in children:
        if child >= 0:
            if which == 0:
                v = child
            which -= 1
    step = int(draws[used + 2] * 8)
    step += int(step >= 4)  # not the middle of the 3×3 points
    x, y = step % 3 - 1, step // 3 - 1
    if v < own or abs(points[v, 0] + x) > half[0] or abs(points[v, 1] + y) > half[1]:
        return nothing, used + 3
    return Shift(-1, v, x, y), used + 3


@bare
def make_shift(moves: Moves, points: Points, found: Shift, way: int) -> None:
    """Make a shift (``way`` 1), or take it back (−1)."""
    if found.move >= 0:
        moves[found.move].sign = -moves[found.move].sign
    elif found.vertex >= 0:
        points[found.vertex, 0] += way * found.x
        points[found.vertex, 1] += way * found.y


@bare
def first_changed(moves: Moves, found: Shift) -> int:
    """The first move that a shift changes."""
    if found.move >= 0:
        return found.move
    v = found.vertex
    for m in range(moves.shape[0]):
        move = moves[m]
        if v in (move.leaf, move.first, move.second, move.middle):
            return m
    return int(moves.shape[0])


@bare
def nearest_move(
    moves: Moves,
    places: Array,
    point: Array,
    r: Record,
    noise: float,
    draws: Array,
    used: int,
) -> int:
    """The move whose middle child, or an image of it, lies nearest to a point in space, each distance with noise.

    One draw is used for each move; sources lie where their leaf does.
    """
    nearest, chosen = np.inf, 0
    for m in range(moves.shape[0]):
        move = moves[m]
        if move.kind == PLACE:
            continue
        v = move.leaf if move.kind == SOURCE else move.middle
        x, y, z = places[v, 0], places[v, 1], places[v, 2]
        squared = np.inf
        for g in range(r.order):
            dx = r.matrices[g, 0] * x + r.matrices[g, 1] * y - point[0]
            dy = r.matrices[g, 2] * x + r.matrices[g, 3] * y - point[1]
            squared = min(squared, dx * dx + dy * dy)
        distance = np.sqrt(squared + (z - point[2]) ** 2) + noise * draws[used + m]
        if distance < nearest:
            nearest, chosen = distance, m
    return chosen


@bare
def parent_of(moves: Moves, m: int) -> int:
    """The last move before m that has its leaf as a child; m itself where the start pattern has laid the leaf."""
    leaf = moves[m].leaf
    for other in range(m - 1, -1, -1):
        move = moves[other]
        if move.kind == EXTEND and leaf in (move.first, move.second, move.middle):
            return other
    return m
