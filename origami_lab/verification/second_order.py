"""Freedoms to first order: do they lead somewhere, or do second-order terms block them?

Directions v of fold angles that keep all loops closed to first order need not belong to a motion. A motion that begins
along v has v·∂J·v in the range of the closure Jacobian J: what is left beside the range, one quadratic form for each
self-stress (a vector that Jᵀ maps to 0), must vanish. If a combination of the forms is definite, no direction is left
and the state is rigid. Else the linkage is pushed along those that an SVD gives, and along mixtures of them in which
all forms vanish: in a flat part of a sheet every single direction is blocked, and mixtures fold.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from itertools import islice

import numpy as np

from origami_lab.verification.continuation import CLOSED, Motion
from origami_lab.verification.linkage import State
from origami_lab.verification.plane_graph import Array
from origami_lab.verification.singular_values import Rank

PUSHES = (0.02, 0.005)
"""Radians by which a freedom is tried out: another state nearby would be found at the same place by both."""
MOST_DIRECTIONS, _MOST_CREASES, _A_FEW = 60, 300, 5
"""More freedoms than this at once, or of more creases, are not taken apart: only a few are tried."""
_STEP = 1e-4
"""Radians over which the closure Jacobian is differentiated; the error is its square."""
_DEFINITE = 1e-4
"""The least eigenvalue of a definite form, of its largest; differences leave 1e-8."""
_VANISHES = 1e-6
_STARTS, _ROUNDS = 30, 80


class Freedom(Enum):
    """What is known of the freedoms to first order at a state."""

    MOVES = "moves"
    MIXES = "moves in a mixture"
    BLOCKED = "blocked"
    UNKNOWN = "unknown"


def explore(motion: Motion, state: State, found: Rank, tries: int | None = None) -> tuple[Freedom, Array | None]:
    """Whether a linkage with its driven creases held really moves along freedoms to first order.

    Parameters
    ----------
    found
        The rank in the n free creases.
    tries
        The linkage is pushed along so many directions at most.

    Returns
    -------
    What is known, and (n,) a direction that is the reason: along which it moves, or that nothing is known to block.
    """
    directions = found.directions
    many = len(directions) > MOST_DIRECTIONS or len(motion.free) > _MOST_CREASES
    curved, forms = np.empty(0), np.empty(0)
    if not many:
        curved = _curvature(motion, state.rho, directions)
        forms = _forms(found.stresses, curved)
        if _some_definite(forms):
            return Freedom.BLOCKED, None
    # mixtures need the second half of the tries
    alone = directions[: _A_FEW if many else tries and tries // 2]
    for direction in alone:
        if moves(motion, state, direction, np.zeros_like(direction)):
            return Freedom.MOVES, direction
    if many:
        return Freedom.UNKNOWN, directions[0]
    for mixture in islice(_vanishing(forms, len(directions)), None if tries is None else tries - len(alone)):
        direction = mixture @ directions
        bend = np.einsum("rij,i,j->r", curved, mixture, mixture)
        if moves(motion, state, direction, found.solve(-bend)):
            return Freedom.MIXES, direction
    return Freedom.UNKNOWN, directions[0]


def moves(motion: Motion, state: State, direction: Array, bend: Array) -> bool:
    """Whether the loops close again a little along a curve of free fold angles with that speed and acceleration."""
    share = []
    for push in PUSHES:
        guess = state.rho.copy()
        guess[motion.free] += push * direction + push * push / 2.0 * bend
        found = motion.solve(state.driving, guess)
        if found is None or found.residual > CLOSED:
            return False
        share.append(float(np.linalg.norm(found.rho - state.rho)) / push)
    return all(0.5 < part < 2.0 for part in share)


def _curvature(motion: Motion, rho: Array, directions: Array) -> Array:
    """(rows, k, k) second derivatives of the loops along pairs of directions."""
    columns = []
    for direction in directions:
        ends = []
        for sign in (1.0, -1.0):
            moved = rho.copy()
            moved[motion.free] += sign * _STEP * direction
            ends.append(motion.linkage.closure(moved).jacobian(motion.free))
        columns.append((ends[0] - ends[1]) / (2.0 * _STEP) @ directions.T)
    curved = np.stack(columns, axis=2)
    return np.asarray((curved + curved.transpose(0, 2, 1)) / 2.0)


def _forms(stresses: Array, curved: Array) -> Array:
    """(m, k, k) independent quadratic forms that must vanish along a motion, each of norm 1."""
    count = curved.shape[1]
    flat = stresses @ curved.reshape(len(curved), count * count)
    if not len(flat):
        return np.empty((0, count, count))
    _, values, basis = np.linalg.svd(flat, full_matrices=False)
    return np.asarray(basis[values > _VANISHES * max(1.0, float(values[0]))].reshape(-1, count, count))


def _some_definite(forms: Array) -> bool:
    """Whether some combination of the forms is positive definite: the most definite one is climbed to."""
    if not len(forms):
        return False
    weights = np.einsum("mii->m", forms)  # the combination nearest to the identity, for an orthonormal basis
    step = 1.0
    best = -np.inf
    for _ in range(200):
        size = float(np.linalg.norm(weights))
        if size == 0.0:
            weights = np.ones(len(forms))
            continue
        weights = weights / size
        values, vectors = np.linalg.eigh(np.einsum("m,mij->ij", weights, forms))
        best = max(best, float(values[0]))
        if values[0] > _DEFINITE:
            return True
        # the directions in which it is least definite say which forms to add
        some = vectors[:, values < values[0] + 0.1 * (values[-1] - values[0]) + 1e-12]
        weights = weights + step * np.einsum("mij,ia,ja->m", forms, some, some) / some.shape[1]
        step *= 0.98
    return False


def _vanishing(forms: Array, count: int) -> Iterator[Array]:
    """Unit vectors (k,) at which all forms vanish, as many as some starts lead to (Levenberg-Marquardt)."""
    rng = np.random.default_rng(0)
    found: list[Array] = []
    for v in rng.normal(size=(_STARTS, count)):
        v /= np.linalg.norm(v)
        error, damping = np.einsum("mij,i,j->m", forms, v, v), 0.1
        for _ in range(_ROUNDS):
            if float(np.abs(error).max(initial=0.0)) < 1e-12:
                break
            slope = 2.0 * np.einsum("mij,j->mi", forms, v)
            step = np.linalg.solve(slope.T @ slope + damping * np.eye(count), slope.T @ error)
            tried = (v - step) / np.linalg.norm(v - step)
            left = np.einsum("mij,i,j->m", forms, tried, tried)
            better = bool(left @ left < error @ error)
            v, error = (tried, left) if better else (v, error)
            damping = max(damping / 3.0, 1e-12) if better else 4.0 * damping
        if float(np.abs(error).max(initial=0.0)) < 1e-9 and all(abs(float(v @ other)) < 0.999 for other in found):
            found.append(v)
            yield v
