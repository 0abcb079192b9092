"""The rank of a closure Jacobian, and the two spaces that a lack of rank leaves.

Fold angles that change along a null vector of the Jacobian J keep all loops closed to first order; a null vector of Jᵀ,
a self-stress, says which errors no fold angles can make up for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from origami_lab.verification.loop_closure import Closure
from origami_lab.verification.plane_graph import Array, Indices

_ZERO = 1e-8
"""Of the largest singular value: smaller ones count as zero (rounding leaves 1e-15)."""


@dataclass(frozen=True, eq=False)
class Rank:
    """The singular values and vectors of a closure Jacobian (rows, columns) of some creases at one state."""

    rank: int
    left: Array
    """(rows, rows) singular vectors, a column each."""
    values: Array
    """(min(rows, columns),) singular values, the largest first."""
    right: Array
    """(columns, columns) singular vectors, a row each."""

    @property
    def freedoms(self) -> int:
        """How many ways to move, to first order."""
        return len(self.right) - self.rank

    @property
    def smallest(self) -> float:
        """The smallest singular value that counts as not zero; infinite if there is none."""
        return float(self.values[self.rank - 1]) if self.rank else float("inf")

    @property
    def directions(self) -> Array:
        """(columns − rank, columns) unit vectors of fold angles that keep all loops closed to first order."""
        return self.right[self.rank :]

    @property
    def stresses(self) -> Array:
        """(rows − rank, rows) unit vectors, an orthonormal basis of the self-stresses."""
        return self.left[:, self.rank :].T

    def solve(self, errors: Array) -> Array:
        """(columns,) the shortest change of the fold angles that makes errors (rows,), or comes nearest to it."""
        kept = slice(self.rank)
        return np.asarray((self.left[:, kept].T @ errors / self.values[kept]) @ self.right[kept])


def rank(closure: Closure, creases: Indices, least: float = 0.0) -> Rank:
    """The rank of the closure Jacobian in the creases with the given numbers.

    Singular values of at most ``least`` count as zero, and those that rounding leaves.
    """
    jacobian = closure.jacobian(creases)
    if not jacobian.size:
        return Rank(0, np.eye(len(jacobian)), np.empty(0), np.eye(len(creases)))
    left, values, right = np.linalg.svd(jacobian)
    return Rank(int(np.sum(values > max(_ZERO * values[0], least))), left, values, right)
