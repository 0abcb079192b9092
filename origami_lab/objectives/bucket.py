"""A bucket (paper, sections 3.6.2 and F.1): its rim, the leaves, as high as possible all around.

    f = min z over the leaves    if that is above 0, max z ≤ 2 · min z over the leaves and max ‖xy‖ ≤ 2 · min ‖xy‖ over
                                 all vertices but the corners of the start pattern,
    f = 0                        otherwise,

in board cells, from 0 up. The leaves are the vertices that were not extended, images included: the boundary of the
sheet, so nothing runs out below the lowest of them. Whose norms the paper means it leaves open; its authors' program
takes all vertices that were placed in the game, ``norm_of="leaves"`` the leaves alone.

Leaves come and go as the sheet grows, but some are leaves for good: those on the board's edge, on two axes, or with a
sector of more than π (or of π, where the rules do not know such). Their lowest z bounds what any continuation reaches,
and where they break a rule there is nothing to be had, nor where the vertices do, which never move; without such leaves
the bound is infinite.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import Record, States
from origami_lab.game.kernels.straight_sectors import is_closed
from origami_lab.jit import inlined, kernel
from origami_lab.objectives.compiled_objective import TIE, Array, CompiledObjective, scored_by, sticks_out
from origami_lab.objectives.objective import checked_number


class BucketObjective(CompiledObjective):
    """The lowest point of the rim, in board cells.

    Parameters
    ----------
    spread
        How much higher than the lowest point of the rim the highest may be, and how much further from the axis than the
        nearest the furthest: the paper's factor 2.
    compactness
        Weight of the penalty on the furthest vertex.
    norm_of
        Whose distance from the axis may spread no further: ``"vertices"``, all but the corners of the start pattern, or
        ``"leaves"``.

    Raises
    ------
    InputError
        If an argument is not such a thing.
    """

    def __init__(self, spread: float = 2.0, compactness: float = 0.0, norm_of: str = "vertices") -> None:
        super().__init__(best_bucket, compactness, BucketScore)
        self.spread = checked_number("spread", spread, 1)
        if norm_of not in ("vertices", "leaves"):
            raise InputError("objective.norm_of", norm_of, "must be vertices or leaves")
        self.norm_of = norm_of

    def numbers(self, game: Game) -> tuple[float, ...]:
        return self.spread, game.corners if self.norm_of == "vertices" else _LEAVES


_LEAVES = -1
"""Instead of the number of the start pattern's corners: only leaves count."""


@inlined
def stays_leaf(s: Record, r: Record, v: int) -> bool:
    """Whether a leaf can never be extended, whatever is played."""
    on_edge = abs(s.xy[v, 0]) >= r.half_x or abs(s.xy[v, 1]) >= r.half_y
    return on_edge or s.axis[v] < 0 or is_closed(s, r, v)


@kernel
def bucket_at(s: Record, r: Record, k: int, spread: float, corners: int, bound: bool, least: float) -> float:
    """The value at driving angle k; −inf if it is not above ``least``. Images have the same z and ‖xy‖.

    The first ``corners`` vertices are those of the start pattern; −1: the norms of leaves count only.
    """
    low, high = np.inf, -np.inf
    near, wide = np.inf, 0.0
    for v in range(s.n_vertices):
        is_rim = s.modes[v] == 0 and not (bound and not stays_leaf(s, r, v))
        if is_rim:
            z = s.position[v, k, 2]
            if z <= 0.0:
                return 0.0
            low, high = min(low, z), max(high, z)
            if low <= least:
                return -np.inf
        if v >= corners if corners >= 0 else is_rim:
            x, y = s.position[v, k, 0], s.position[v, k, 1]
            squared = x * x + y * y
            near, wide = min(near, squared), max(wide, squared)
    if high > spread * low + TIE or np.sqrt(wide) > spread * np.sqrt(near) + TIE:
        return 0.0
    return low


@kernel
def best_bucket(states: States, i: int, rules: States, numbers: Array, bound: bool, above: float) -> tuple[float, int]:
    """See :data:`~origami_lab.objectives.compiled_objective.Best`; ``numbers`` are compactness, spread and corners."""
    s, r = states[i], rules[0]
    best, angle = above, -1
    for k in range(r.min_reach - 1, s.reach):
        penalty = sticks_out(s, k, numbers[0])
        value = bucket_at(s, r, k, numbers[1], int(numbers[2]), bound, best + penalty) - penalty
        if value > best:
            best, angle = value, k
    return best, angle


@scored_by(best_bucket)
class BucketScore(NamedTuple):
    """The compiled score; ``numbers`` are those of :func:`best_bucket`."""

    numbers: Array
