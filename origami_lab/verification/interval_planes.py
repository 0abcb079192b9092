"""Planes that part pairs of panel triangles over a whole interval of the motion.

Seen from the first panel of a pair the corners of the other move along smooth curves. Over an interval they are
replaced by the cubics through their positions and velocities at its ends, which lie in the hull of four control points
each; what the cubics miss is taken as ``SAFETY`` times what they miss in the middle, where a smooth curve is missed
most. One plane that has all of this on one side and the first triangle on the other excludes a crossing everywhere
in the interval. Of triangles that share a vertex the cones over their far sides are parted in the same way.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.linkage import State
from origami_lab.verification.panel_pairs import Neighbourhood, Pairs, apart, parts
from origami_lab.verification.plane_graph import Array, Indices, cross
from origami_lab.verification.sliding_contact import sliding_gap
from origami_lab.verification.triangle_separation import gaps, least

SAFETY = 8.0
_BESIDE = 1e-12
"""Of a gap: by so much it must be larger than enough, that rounding does not make it so."""


class RelativeMotion:
    """The second triangles of N pairs over an interval, seen from the first panels."""

    def __init__(self, near: Neighbourhood, pairs: Pairs, a: State, m: State, b: State) -> None:
        h = b.driving - a.driving
        (q0, v0), (q1, v1) = near.second(pairs, a), near.second(pairs, b)
        self.hinged, self.first, self.middle = pairs.hinged, near.first(pairs), near.second(pairs, m)[0]
        missed = (q0 + q1) / 2.0 + h / 8.0 * (v0 - v1) - self.middle
        self.error = SAFETY * np.sqrt(np.einsum("nkj,nkj->nk", missed, missed).max(axis=1))
        """(N,) how far the control points may be off."""
        self.controls = np.concatenate([q0, q0 + h / 3.0 * v0, q1 - h / 3.0 * v1, q1], axis=1)
        """(N, 12, 3) four for each corner."""

    def shown(self, directions: Array, some: Array | slice = slice(None)) -> tuple[Array, Array]:
        """(n, K) what is left beside planes with unit normals (n, K, 3) after all errors, for some of the pairs.

        Returns
        -------
        gap, least
            Distances of the triangles, twice the same; for pairs that share a vertex those of unit sides of the cones
            from the plane, first both cones' together, where it cuts neither, then that of the nearer one.
        """
        p, controls, error = self.first[some], self.controls[some], self.error[some][:, None]
        if not self.hinged:
            gap = np.asarray(gaps(directions, p, controls) - error)
            return gap, gap
        middle = self.middle[some]
        length = np.linalg.norm(middle[:, 1:] - middle[:, :1], axis=2)
        moving = controls.reshape(-1, 4, 3, 3)[:, :, 1:] - p[:, None, :1]
        moving = (moving / length[:, None, :, None]).reshape(-1, 8, 3)
        sides = p[:, 1:] - p[:, :1]
        one = least(directions, sides / np.linalg.norm(sides, axis=2)[..., None])
        other = least(-directions, moving) - error / length.min(axis=1)[:, None]
        smaller = np.minimum(one, other)
        # one cone may lie in the plane as long as the other one keeps clear of it
        return np.where(smaller >= -1e-13, one + other, smaller), smaller

    def normals(self) -> Array:
        """(N, 2, 3) of both triangles in the middle of the interval, of length 1 where they have one."""
        across = np.stack([cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]) for t in (self.first, self.middle)], axis=1)
        length = np.linalg.norm(across, axis=2, keepdims=True)
        return np.asarray(across / np.where(length > 0.0, length, 1.0))

    def at_states(self, some: Array) -> tuple[Array, Array]:
        """(n, 3) how far apart some of the pairs are at the three states, and (3, n, 3) the directions that show it."""
        p = self.first[some]
        # the three states in one go: for a few pairs it is the calls that take time
        q = np.concatenate([self.controls[some, :3], self.middle[some], self.controls[some, 9:]])
        distances, found = apart(self.hinged, np.tile(p, (3, 1, 1)), q)
        return distances.reshape(3, -1).T, found.reshape(3, -1, 3)


class IntervalPlanes:
    """The search for planes that part pairs; from interval to interval the last one of each pair is tried first."""

    def __init__(self, near: Neighbourhood) -> None:
        self.near = near
        self._numbers: Indices = np.empty(0, dtype=np.int64)
        self._planes: Array = np.empty((0, 3))

    def parted(self, pairs: Pairs, a: State, m: State, b: State, enough: Array | None = None) -> tuple[Array, Array]:
        """Whether a plane parts the triangles over a whole interval.

        Parameters
        ----------
        enough
            (N,) at least 0: of pairs that a plane at hand shows to be further apart no more is wanted.

        Returns
        -------
        gap, apart
            (N,) what is left beside the best plane after all errors, as distance or, for pairs that share a vertex,
            for unit sides of the cones; (N, 3) how far apart they are at the three states
            (:meth:`Neighbourhood.gap`), infinite where ``gap`` is enough.
        """
        gap, distances, planes = np.empty(len(pairs)), np.full((len(pairs), 3), np.inf), np.empty((len(pairs), 3))
        for part in parts(len(pairs)):
            motion = RelativeMotion(self.near, pairs.take(part), a, m, b)
            normals = motion.normals()
            ready = np.concatenate([self._last(pairs.numbers[part])[:, None], normals, -normals], axis=1)
            gap[part], least_gap, planes[part] = _best(motion.shown(ready), ready)
            rest = np.arange(part.start, part.stop)
            if enough is not None:
                beyond = (1.0 + _BESIDE) * enough[part]
                # one cone may lie in the plane, but then it is not known to keep a distance from the other one
                rest = rest[~((gap[part] > beyond) & ((least_gap > beyond) | (beyond == 0.0)))]
            if len(rest):
                some = rest - part.start
                distances[rest], found = motion.at_states(some)
                directions = _blend(found, normals[some])
                gap[rest], _, planes[rest] = _best(motion.shown(directions, some), directions)
        self._keep(pairs.numbers, planes)
        return gap, distances

    def sliding(self, pairs: Pairs, a: State, m: State, b: State) -> Array:
        """(N,) the gap that a plane shows which moves along with two touching sides, over a whole interval."""
        gap = np.empty(len(pairs))
        for part in parts(len(pairs)):
            motion = RelativeMotion(self.near, pairs.take(part), a, m, b)
            gap[part] = sliding_gap(motion.first, motion.controls.reshape(-1, 4, 3, 3), motion.error)
        return gap

    def _last(self, numbers: Indices) -> Array:
        """(N, 3) the planes kept of pairs, 0 where there is none, which shows nothing."""
        if not len(self._numbers):
            return np.zeros((len(numbers), 3))
        at, known = self._places(numbers)
        return np.where(known[:, None], self._planes[at], 0.0)

    def _places(self, numbers: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        """(N,) where pairs are among those kept, and whether they are."""
        at = np.searchsorted(self._numbers, numbers).clip(max=len(self._numbers) - 1)
        return at, self._numbers[at] == numbers

    def _keep(self, numbers: Indices, planes: Array) -> None:
        if len(self._numbers):
            at, known = self._places(numbers)
            if known.all():
                self._planes[at] = planes
                return
        # of a number that comes twice the first one is taken
        self._numbers, first = np.unique(np.concatenate([numbers, self._numbers]), return_index=True)
        self._planes = np.concatenate([planes, self._planes])[first]


def _best(shown: tuple[Array, Array], directions: Array) -> tuple[Array, Array, Array]:
    """The largest of gaps (N, K), what else is shown there, and the direction."""
    gap, other = shown
    at, rows = gap.argmax(axis=1), np.arange(len(gap))
    return gap[rows, at], other[rows, at], directions[rows, at]


def _blend(found: Array, normals: Array) -> Array:
    """Directions to try over an interval: what parts at its ends and middle, their means, and the normals."""
    means = [found[0] + found[2], found[0] + 2.0 * found[1] + found[2]]
    directions = np.concatenate([np.stack([*found, *means], axis=1), normals, -normals], axis=1)
    length = np.linalg.norm(directions, axis=2)
    usable = length > 1e-9
    unit = directions / np.where(usable, length, 1.0)[..., None]
    return np.asarray(np.where(usable[..., None], unit, unit[:, :1]))
