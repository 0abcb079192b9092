"""How many ways a folded state can move: the rank of its closure Jacobian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from origami_lab.verification.linkage import Linkage
from origami_lab.verification.motion import CLOSED, Motion
from origami_lab.verification.planar import Array, Indices

_ZERO = 1e-8
"""Of the largest singular value: smaller ones count as zero (rounding leaves 1e-15)."""
_PUSHES = (0.02, 0.005)
"""Radians by which a freedom is tried out: another state nearby would be found at the same place by both."""


@dataclass(frozen=True)
class Rank:
    """The closure Jacobian of some creases at one state."""

    columns: int
    rank: int
    smallest: float
    """The smallest singular value that counts as not zero; infinite if there is none."""
    directions: Array
    """(columns − rank, columns) unit vectors of fold angles that keep all loops closed to first order."""

    @property
    def freedoms(self) -> int:
        """How many ways to move, to first order."""
        return self.columns - self.rank


def rank(linkage: Linkage, rho: Array, creases: Indices) -> Rank:
    """The rank of the closure Jacobian in the creases with the given numbers, at fold angles (E,)."""
    jacobian = linkage.closure(rho)[1][:, creases]
    count = len(creases)
    if not count:
        return Rank(0, 0, float("inf"), np.empty((0, 0)))
    if not len(jacobian):
        return Rank(count, 0, float("inf"), np.eye(count))
    _, values, right = np.linalg.svd(jacobian, full_matrices=len(jacobian) < count)
    kept = int(np.sum(values > _ZERO * values[0]))
    return Rank(count, kept, float(values[kept - 1]), right[kept:])


def is_free(motion: Motion, driving: float, rho: Array, found: Rank) -> bool:
    """Whether a freedom to first order is a real one: pushed along it, the loops close again somewhere else."""
    free = motion.free
    for direction in found.directions:
        moved = []
        for push in _PUSHES:
            guess = rho.copy()
            guess[free] += push * direction
            state = motion.solve(driving, guess)
            if state is not None and state.residual <= CLOSED:
                moved.append(float(np.linalg.norm(state.rho - rho)) / push)
        if len(moved) == len(_PUSHES) and all(0.5 < share < 2.0 for share in moved):
            return True
    return False
