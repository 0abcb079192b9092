"""A chair (paper, sections 3.6.2 and F.4): a seat, three legs on the ground, a backrest.

    L_legs = the mean of |z + 4| + ||y| − 2.1| over the three lowest vertices
    L_rest = |z_max − 4| + the mean of ||y| − 2.1| over the vertices with z > 0
    f = −L_legs − L_rest + penalties

in board cells, at most 0. The seat is the start square of half-width 2. Vertices are all of the sheet's, images
included; the mean over no vertices is 0. The penalties, each once for a sheet however often it deserves it, with r_min
= −(N − 1):

* r_min if a vertex has |x| or |y| above 4;
* r_min/2 if the chair does not stand: the three lowest vertices differ by more than 0.1 in z, or all have y > 0, or
all y < 0.

Where several vertices are the third lowest, those count as legs that cost least, and the chair stands on all of them.

What sticks out stays out, the three lowest vertices only get lower, the highest higher, and a backrest vertex remains
one. Hence the bound: all of this at its best, the sum over the backrest divided by as many vertices as the board has
room for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import Record, States, has_image
from origami_lab.jit import inlined, kernel
from origami_lab.objectives.compiled_objective import (
    TIE,
    Array,
    CompiledObjective,
    board_points_beside,
    scored_by,
    sticks_out,
)
from origami_lab.objectives.objective import checked_number

LEGS = 3
UNEVEN = 0.1
"""Board cells by which the legs may differ in height."""
BEYOND = 1e-6
"""Board cells by which a vertex may stick out."""


class ChairObjective(CompiledObjective):
    """Minus the mean deviations of legs and backrest from where they should be, in board cells, and penalties.

    Parameters
    ----------
    height
        Of the backrest above the seat, and of the seat above the ground, in board cells: the paper's 4.
    side
        |y| of legs and backrest: the paper's 2.1, just beside the edge of the seat.
    extent
        |x| and |y| that no vertex should exceed: the paper's 4.
    compactness
        Weight of the penalty on the furthest vertex.
    """

    def __init__(self, height: float = 4.0, side: float = 2.1, extent: float = 4.0, compactness: float = 0.0) -> None:
        super().__init__(best_chair, compactness, ChairScore)
        self.height = checked_number("height", height, 0)
        self.side = checked_number("side", side, 0)
        self.extent = checked_number("extent", extent, 0)

    def numbers(self, game: Game) -> tuple[float, ...]:
        return (self.height, self.side, self.extent, game.penalty)

    def front(self, design: CreasePattern) -> tuple[float, float, float]:
        """Away from the backrest: from the highest vertex over the middle of the seat."""
        highest = design.folded[design.best][np.argmax(design.folded[design.best][:, 2])]
        return (0.0, -1.0 if highest[1] > 0.0 else 1.0, 0.0)


@inlined
def put_lowest(lowest: Array, value: float) -> None:
    """Keep the lowest values, rising."""
    for j in range(lowest.shape[0]):
        if value < lowest[j]:
            value, lowest[j] = lowest[j], value


@inlined
def image_y(s: Record, r: Record, v: int, g: int, k: int) -> float:
    """Folded y of a representative's image."""
    return float(r.matrices[g, 2] * s.position[v, k, 0] + r.matrices[g, 3] * s.position[v, k, 1])


@kernel
def leg_cost(
    s: Record, r: Record, k: int, lowest: Array, height: float, side: float, costs: Array
) -> tuple[float, bool]:
    """L_legs, and whether the chair has legs on both sides, or between.

    Parameters
    ----------
    lowest
        (3,) z of the three lowest vertices, rising.
    costs
        (3,) scratch: the lowest costs among the vertices that are third lowest.
    """
    third = lowest[LEGS - 1]
    cost, count = 0.0, 0
    costs[:] = np.inf
    front = back = True
    for v in range(s.n_vertices):
        z = s.position[v, k, 2]
        if z > third + TIE:
            continue
        for g in range(r.order):
            if not has_image(r, s.axis[v], g):
                continue
            y = image_y(s, r, v, g, k)
            front, back = front and y < -TIE, back and y > TIE
            here = abs(z + height) + abs(abs(y) - side)
            if z < third - TIE:
                cost += here
                count += 1
            else:
                put_lowest(costs, here)
    for j in range(LEGS - count):
        cost += costs[j]
    return cost / LEGS, not (front or back)


@kernel
def chair_at(s: Record, r: Record, k: int, numbers: Array, bound: bool, least: float, scratch: Array) -> float:
    """The value at driving angle k; −inf if it is not above ``least``."""
    height, side, extent, worst = numbers[1], numbers[2], numbers[3], numbers[4]
    lowest, costs = scratch[0], scratch[1]
    lowest[:] = np.inf
    highest = -np.inf
    behind, rest, low = 0.0, 0, 0
    value = 0.0
    for v in range(s.n_vertices):
        x, y, z = s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]
        if value == 0.0 and max(abs(x), abs(y)) > extent + BEYOND:
            value = worst
            if value <= least:
                return -np.inf
        highest = max(highest, z)
        for g in range(r.order):
            if has_image(r, s.axis[v], g):
                put_lowest(lowest, z)
                if z > TIE:
                    behind += abs(abs(image_y(s, r, v, g, k)) - side)
                    rest += 1
                else:
                    low += 1
    if bound:
        for z in lowest:
            if z < np.inf:
                value -= max(0.0, -height - z) / LEGS
        return value - max(0.0, highest - height) - behind / board_points_beside(r, low)
    value -= abs(highest - height)
    if rest > 0:
        value -= behind / rest
    if lowest[LEGS - 1] - lowest[0] > UNEVEN:
        value += 0.5 * worst
    if value <= least:
        return -np.inf
    legs, stands = leg_cost(s, r, k, lowest, height, side, costs)
    if not stands and lowest[LEGS - 1] - lowest[0] <= UNEVEN:
        value += 0.5 * worst
    return value - legs


@kernel
def best_chair(states: States, i: int, rules: States, numbers: Array, bound: bool, above: float) -> tuple[float, int]:
    """See :data:`~.compiled_objective.Best`; ``numbers``: compactness, height, side, extent and r_min."""
    s, r = states[i], rules[0]
    best, angle = above, -1
    scratch = np.empty((2, LEGS))
    for k in range(r.min_reach - 1, s.reach):
        penalty = sticks_out(s, k, numbers[0])
        value = chair_at(s, r, k, numbers, bound, best + penalty, scratch) - penalty
        if value > best:
            best, angle = value, k
    return best, angle


@scored_by(best_chair)
class ChairScore(NamedTuple):
    """The compiled score; ``numbers`` are those of :func:`best_chair`."""

    numbers: Array
