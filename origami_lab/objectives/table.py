"""A table (paper, sections 3.6.2 and F.3): four feet at one height, everything else in the plane z = 0.

    f = −¼ Σ |z − 2.5| over the four highest vertices − the mean of |z| over all others,

in board cells, at most 0. Vertices are all of the sheet's, images included; the second mean is 0 where there are only
four. (The table stands on its head: the start square is its top.)

Of the vertices that are there, those below the four highest stay below them, and the i-th highest only gets higher.
Hence the bound

    −¼ Σ max(0, z − 2.5) over the four highest − Σ |z| over the others / (wh − 4)

on a w×h board, which has no room for more than wh vertices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import Record, States
from origami_lab.jit import kernel
from origami_lab.objectives.compiled_objective import (
    Array,
    CompiledObjective,
    board_points_beside,
    count_vertices,
    orbit_size,
    scored_by,
    sticks_out,
)
from origami_lab.objectives.objective import checked_number

FEET = 4


class TableObjective(CompiledObjective):
    """Minus the mean deviation of the feet from their height, minus that of the rest from the plane, in board cells.

    Parameters
    ----------
    height
        Where the feet should be, in board cells: the paper's 2.5.
    compactness
        Weight of the penalty on the furthest vertex.
    """

    def __init__(self, height: float = 2.5, compactness: float = 0.0) -> None:
        super().__init__(best_table, compactness, TableScore)
        self.height = checked_number("height", height, 0)

    def numbers(self, game: Game) -> tuple[float, ...]:
        return (self.height,)

    def up(self, design: CreasePattern) -> tuple[float, float, float]:
        """On its feet."""
        return (0.0, 0.0, -1.0)


@kernel
def table_at(s: Record, r: Record, k: int, height: float, others: int, bound: bool, least: float, top: Array) -> float:
    """The value at driving angle k; −inf if it is not above ``least``.

    Parameters
    ----------
    others
        What the sum over the vertices below the four highest is divided by.
    top
        (4,) scratch: the four highest z, falling.
    """
    top[:] = -np.inf
    astray = 0.0
    for v in range(s.n_vertices):
        size = orbit_size(s, r, v)
        for _ in range(min(size, FEET)):
            # each copy finds its place among the highest, what falls out is one of the others
            z = s.position[v, k, 2]
            for j in range(FEET):
                if z > top[j]:
                    z, top[j] = top[j], z
            if z > -np.inf:
                astray += abs(z)
        if size > FEET:
            astray += (size - FEET) * abs(s.position[v, k, 2])
        if others > 0 and astray >= -least * others:
            return -np.inf
    feet = 0.0
    for z in top:
        if bound:
            feet += max(0.0, z - height)
        else:
            feet += abs(z - height)
    return -feet / FEET - (astray / others if others > 0 else 0.0)


@kernel
def best_table(states: States, i: int, rules: States, numbers: Array, bound: bool, above: float) -> tuple[float, int]:
    """See :data:`~origami_lab.objectives.compiled_objective.Best`; ``numbers`` are compactness and height."""
    s, r = states[i], rules[0]
    best, angle = above, -1
    others = board_points_beside(r, FEET) if bound else count_vertices(s, r) - FEET
    top = np.empty(FEET)
    for k in range(r.min_reach - 1, s.reach):
        penalty = sticks_out(s, k, numbers[0])
        value = table_at(s, r, k, numbers[1], others, bound, best + penalty, top) - penalty
        if value > best:
            best, angle = value, k
    return best, angle


@scored_by(best_table)
class TableScore(NamedTuple):
    """The compiled score; ``numbers`` are those of :func:`best_table`."""

    numbers: Array
