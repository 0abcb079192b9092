"""Changes of a design: what is cut away, or shifted, before it is laid and grown again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.move_table import EXTEND, PLACE, SOURCE, Flags, Moves
from origami_lab.jit import kernel
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


def unchanged(design: RunDesign) -> Change:
    """The design as it is."""
    return Change(design, np.zeros(len(design.moves), dtype=np.int8), len(design.moves))


def is_bare(design: RunDesign) -> bool:
    """Whether there is nothing but the start pattern."""
    return len(design.moves) == placements(design)


def placements(design: RunDesign) -> int:
    """How many of the first moves place the start pattern: one, or none where it is made of moves."""
    return int(len(design.moves) > 0 and design.moves["kind"][0] == PLACE)


def cut(design: RunDesign, chosen: int, more: float, draws: Draws) -> Change:
    """Cut a move away, and with probability ``more`` each another random one, again and again."""
    goes = np.zeros(len(design.moves), dtype=np.int8)
    goes[chosen] = 1
    while draws.one() < more:
        goes[random_move(design, draws)] = 1
    return Change(design, goes, int(np.argmax(goes)))


def shift(design: RunDesign, chosen: int, half: tuple[int, int], flip: float, draws: Draws) -> Change | None:
    """Shift a vertex of a move to a neighbouring board point, or with probability ``flip`` turn its mode over.

    Whatever names the vertex goes with it. None if there is nothing to be changed: no extension, a point off the board,
    or a vertex that the start pattern has laid.
    """
    move, goes = design.moves[chosen], np.zeros(len(design.moves), dtype=np.int8)
    if move["kind"] != EXTEND:
        return None
    if draws.one() < flip:
        moves = design.moves.copy()
        moves["sign"][chosen] = -moves["sign"][chosen]
        return Change(replace(design, moves=moves), goes, chosen)
    children = [int(v) for v in (move["first"], move["second"], move["middle"]) if v >= 0]
    v = children[draws.below(len(children))]
    step = draws.below(8)
    step += step >= 4  # not the middle of the 3×3 points
    points = design.points.copy()
    points[v] += (step % 3 - 1, step // 3 - 1)
    if v < design.own or abs(points[v, 0]) > half[0] or abs(points[v, 1]) > half[1]:
        return None
    return Change(replace(design, points=points), goes, int(first_naming(design.moves, v)))


@kernel
def first_naming(moves: Moves, v: int) -> int:
    """The first move that names a vertex."""
    for m in range(moves.shape[0]):
        move = moves[m]
        if v in (move.leaf, move.first, move.second, move.middle):
            return m
    return int(moves.shape[0])


def random_move(design: RunDesign, draws: Draws) -> int:
    """Any move but the placement."""
    placed = placements(design)
    return placed + draws.below(len(design.moves) - placed)


def move_near(design: RunDesign, point: Array, matrices: NDArray[np.int32], noise: float, draws: Draws) -> int:
    """The move whose middle child, or an image of it, lies nearest to a point in space, each distance with noise."""
    count = len(design.moves)
    draws.reserve(count)
    chosen = nearest_move(design.moves, design.places, point, matrices, noise, draws.block, draws.used)
    draws.use(count)
    return int(chosen)


@kernel
def nearest_move(
    moves: Moves,
    places: Array,
    point: Array,
    matrices: NDArray[np.int32],
    noise: float,
    draws: Array,
    used: int,
) -> int:
    """The row of the move of :func:`move_near`, with one draw for each; sources lie where their leaf does."""
    nearest, chosen = np.inf, 0
    for m in range(moves.shape[0]):
        move = moves[m]
        if move.kind == PLACE:
            continue
        v = move.leaf if move.kind == SOURCE else move.middle
        x, y, z = places[v, 0], places[v, 1], places[v, 2]
        squared = np.inf
        for g in range(matrices.shape[0]):
            dx = matrices[g, 0] * x + matrices[g, 1] * y - point[0]
            dy = matrices[g, 2] * x + matrices[g, 3] * y - point[1]
            squared = min(squared, dx * dx + dy * dy)
        distance = np.sqrt(squared + (z - point[2]) ** 2) + noise * draws[used + m]
        if distance < nearest:
            nearest, chosen = distance, m
    return chosen


@kernel
def parent_of(moves: Moves, m: int) -> int:
    """The last move before m that has its leaf as a child; m itself where the start pattern has laid the leaf."""
    leaf = moves[m].leaf
    for other in range(m - 1, -1, -1):
        move = moves[other]
        if move.kind == EXTEND and leaf in (move.first, move.second, move.middle):
            return other
    return m
