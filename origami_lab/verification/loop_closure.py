"""The closure of all loops at some fold angles: its error, its Jacobian, and linear systems with it.

The loop around an interior vertex turns its first panel back onto itself. Where it does not quite, its error is a
rotation vector, and the derivative of that by a fold angle is the direction of the crease. A crease is in two loops at
most, so the Jacobian is mostly zeros: what is asked of it is worked out from the loops' own creases.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.linalg import lapack

from origami_lab.verification.plane_graph import Array, Indices

_RANK = 1e-11
"""Of the largest singular value: smaller ones count as zero in a least-squares solution."""
_REFINEMENTS, _SHRINKS = 8, 0.1
"""So often a solution is refined; it must change by so much less each time, or the equations are too near singular."""
_SURE = 1e-5
"""Of the largest singular value: above it the smallest one is the root of an eigenvalue to six digits."""


@dataclass(frozen=True, eq=False)
class Closure:
    """How far all loops are from closed, and how that changes with the fold angles."""

    error: Array
    """(loops, 3) rotation vectors to first order."""
    angle: Array
    """(loops,) radians by which the loops fail to close."""
    directions: Array
    """(loops, D, 3) unit vectors along the creases of each loop, as seen from its first panel; 0 beyond its last."""
    creases: Indices
    """(loops, D) their numbers; E beyond the last."""
    edges: int
    """E, how many fold angles there are."""

    def jacobian(self, columns: Indices) -> Array:
        """(3·loops, n) derivatives of the errors by the fold angles of some creases."""
        loops = len(self.directions)
        out = np.zeros((loops, 3, len(columns) + 1))
        out[np.arange(loops)[:, None], :, self._places(columns)] = self.directions
        return out[:, :, :-1].reshape(3 * loops, len(columns))

    def change(self, speed: Array) -> Array:
        """(loops, 3) how fast the errors change at speeds (E,) of all fold angles."""
        return self._times(np.append(speed, 0.0)[self.creases])

    def solve(self, columns: Indices, right: Array) -> Array:
        """(n,) the speeds of some creases that change the errors by (loops, 3), or come nearest to it.

        The normal equations are factored, which takes a tenth of an orthogonal factorization, and their solution is
        refined with what the loops themselves leave, until it is as exact. Where that does not converge, because the
        Jacobian is nearly singular, its orthogonal factorization is used.
        """
        places = self._places(columns)
        count = len(columns)
        factor, failed = lapack.dpotrf(self._normal(places, count), lower=1, clean=0, overwrite_a=1)
        if failed == 0:
            solution, left, size = np.zeros(count + 1), right, np.inf
            for _ in range(_REFINEMENTS):
                step, _ = lapack.dpotrs(factor, self._gradient(places, left, count), lower=1)
                last, size = size, float(np.abs(step).max(initial=0.0))
                if not size <= _SHRINKS * last:
                    break
                solution[:-1] += step
                if size <= 1e-15 * float(np.abs(solution).max(initial=0.0)):
                    return solution[:-1]
                left = right - self._times(solution[places])
        return _least_squares(self.jacobian(columns), right.reshape(-1))

    def smallest(self, columns: Indices) -> float:
        """The smallest singular value of the Jacobian in some creases; 0 if there are more of them than equations."""
        if not len(columns):
            return float("inf")
        if 3 * len(self.error) < len(columns):
            return 0.0
        normal = self._normal(self._places(columns), len(columns))
        least = float(linalg.eigvalsh(normal, subset_by_index=(0, 0), check_finite=False)[0])
        if least > _SURE**2 * float(np.trace(normal)):  # which is no less than the largest
            return float(np.sqrt(least))
        return float(linalg.svdvals(self.jacobian(columns), check_finite=False).min())

    def _places(self, columns: Indices) -> Indices:
        """(loops, D) where the creases of each loop are among the columns; n for those that are not."""
        places = np.full(self.edges + 1, len(columns), dtype=np.int64)
        places[columns] = np.arange(len(columns))
        return places[self.creases]

    def _times(self, speed: Array) -> Array:
        """(loops, 3) J·x, of speeds (loops, D) of each loop's creases."""
        return np.asarray((speed[:, None] @ self.directions)[:, 0])

    def _gradient(self, places: Indices, error: Array, count: int) -> Array:
        """(n,) Jᵀ·r of errors (loops, 3)."""
        each = (self.directions @ error[:, :, None])[:, :, 0]
        return np.asarray(np.bincount(places.ravel(), each.ravel(), count + 1)[:count], dtype=np.float64)

    def _normal(self, places: Indices, count: int) -> Array:
        """(n, n) JᵀJ, in Fortran's order."""
        products = self.directions @ self.directions.transpose(0, 2, 1)
        at = places[:, :, None] * (count + 1) + places[:, None, :]
        whole = np.bincount(at.ravel(), weights=products.ravel(), minlength=(count + 1) ** 2)
        return np.asfortranarray(whole.reshape(count + 1, count + 1)[:count, :count])


def _least_squares(matrix: Array, right: Array) -> Array:
    rows, columns = matrix.shape
    if rows == columns:
        with suppress(np.linalg.LinAlgError):
            return np.asarray(np.linalg.solve(matrix, right))
    return np.asarray(linalg.lstsq(matrix, right, cond=_RANK, lapack_driver="gelsy", check_finite=False)[0])
