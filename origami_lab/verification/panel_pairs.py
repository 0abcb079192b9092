"""Which pairs of panel triangles may cross, where they are as seen from one of them, and how far apart.

Panels that share a crease, each wholly on its side of it, cannot cross as long as the crease folds by less than 180°.
Of triangles that share a vertex the cones over their far sides count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.measured_panels import diameters
from origami_lab.verification.plane_graph import Array, Indices, cross
from origami_lab.verification.triangle_separation import (
    TOUCH,
    crossing_depth,
    separating,
    separating_cones,
)

_AT_A_TIME = 4096
_PAIRS = 400_000
"""More pairs than this that are close to each other are not looked at one by one."""

_FLOATING = 2e-13
"""Of the sheet's size: positions at the end of a long chain of panels are exact to this."""
_AROUND = 200
"""More triangles than this around one vertex neither."""


class CrowdedError(Exception):
    """More pairs of panels are close to each other than can be checked."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """N pairs of triangles, each turned so that a shared vertex is corner 0 of both."""

    first: Indices
    """(N, 3) corners, vertex numbers."""
    second: Indices
    panels: Indices
    """(N, 2)"""
    numbers: Indices
    """(N,) of each pair, and of the same pair the other way round, another one."""
    hinged: bool
    """Whether the pairs share a vertex."""

    def __len__(self) -> int:
        return len(self.panels)

    def take(self, which: NDArray[np.bool_] | Indices | slice) -> Pairs:
        """Some of the pairs."""
        return Pairs(self.first[which], self.second[which], self.panels[which], self.numbers[which], self.hinged)

    def turned(self) -> Pairs:
        """The pairs the other way round: seen from the second panel."""
        return Pairs(self.second, self.first, self.panels[:, ::-1], -1 - self.numbers, self.hinged)

    def parts(self) -> list[Pairs]:
        """All pairs, a bounded number at a time."""
        return [self.take(part) for part in parts(len(self))]


class Neighbourhood:
    """The pairs of a linkage's triangles that need a look."""

    def __init__(self, linkage: Linkage, held: NDArray[np.bool_]) -> None:
        self.linkage, self.sheet = linkage, linkage.sheet
        sheet = self.sheet
        self.diameters = diameters(sheet)
        """(F,) the largest distance of two corners of each panel."""
        self.bodies = _bodies(len(sheet.faces), sheet.beside[sheet.inner & held])
        parted = {tuple(sorted(sheet.beside[e])) for e in np.flatnonzero(sheet.inner & ~held) if self._on_sides(int(e))}
        count = len(sheet.triangles)
        corner_of = [np.flatnonzero((sheet.triangles == v).any(axis=1)) for v in range(len(sheet.points))]
        corners = [set(triangle) for triangle in sheet.triangles.tolist()]
        rows, touching = [], set()
        for v, around in enumerate(corner_of):
            if len(around) > _AROUND:
                raise CrowdedError
            for at, i in enumerate(around):
                for j in around[at + 1 :]:
                    pair = (int(i), int(j))
                    p, q = sheet.owner[i], sheet.owner[j]
                    if pair in touching:
                        continue
                    touching.add(pair)
                    if self.bodies[p] == self.bodies[q] or (min(p, q), max(p, q)) in parted:
                        continue
                    if len(corners[i] & corners[j]) > 1:
                        continue  # on both sides of a crease
                    rows.append((pair, v))
        self.neighbours = Pairs(
            np.array([_from(sheet.triangles[pair[0]], v) for pair, v in rows], dtype=np.int64).reshape(-1, 3),
            np.array([_from(sheet.triangles[pair[1]], v) for pair, v in rows], dtype=np.int64).reshape(-1, 3),
            sheet.owner[np.array([pair for pair, _ in rows], dtype=np.int64).reshape(-1, 2)],
            np.array([i * count + j for (i, j), _ in rows], dtype=np.int64),
            True,
        )
        self._skip = np.zeros((count, count), dtype=np.bool_)
        if touching:
            some = np.array(sorted(touching))
            self._skip[some[:, 0], some[:, 1]] = True
        self._parted = np.zeros((len(sheet.faces), len(sheet.faces)), dtype=np.bool_)
        for p, q in parted:
            self._parted[p, q] = self._parted[q, p] = True

    def _on_sides(self, e: int) -> bool:
        """Whether the two panels of a crease lie wholly on their sides of its line, on the flat sheet."""
        sheet = self.sheet
        u, v = sheet.points[sheet.edges[e]]
        along = (v - u) / np.linalg.norm(v - u)
        for panel, sign in zip(sheet.beside[e], (1.0, -1.0), strict=True):
            rel = sheet.points[list(sheet.faces[panel])] - u
            if np.min(sign * (along[0] * rel[:, 1] - along[1] * rel[:, 0])) < -TOUCH * self.diameters[panel]:
                return False
        return True

    def touch(self, pairs: Pairs) -> Array:
        """(N,) by how much the panels of pairs may reach into each other and still only touch, a length.

        Their own size counts, not the sheet's: a long panel elsewhere must not widen what is taken for contact.
        """
        own = TOUCH * self.diameters[pairs.panels].min(axis=1)
        return np.asarray(np.maximum(own, _FLOATING * self.sheet.size))

    def shortest(self, pairs: Pairs) -> Array:
        """(N,) the shortest side that the triangles of pairs have at their common vertex, a length."""
        sides = [self.linkage.flat[t[:, 1:]] - self.linkage.flat[t[:, :1]] for t in (pairs.first, pairs.second)]
        return np.asarray(np.linalg.norm(np.concatenate(sides, axis=1), axis=2).min(axis=1))

    def close(self, low: Array, high: Array) -> Pairs:
        """The pairs without a common vertex whose boxes (T, 3), (T, 3) overlap."""
        sheet, found, total = self.sheet, [], 0
        for start in range(0, len(low), 256):
            rows = slice(start, start + 256)
            near = ~self._skip[rows]
            near &= np.arange(len(low)) > np.arange(start, start + len(near))[:, None]
            for axis in range(3):
                near &= (low[rows, None, axis] <= high[None, :, axis]) & (high[rows, None, axis] >= low[None, :, axis])
            i, j = np.nonzero(near)
            p, q = sheet.owner[i + start], sheet.owner[j]
            keep = (self.bodies[p] != self.bodies[q]) & ~self._parted[p, q]
            found.append(np.column_stack([i + start, j])[keep])
            total += len(found[-1])
            if total > _PAIRS:
                raise CrowdedError
        pairs = np.concatenate(found)
        numbers = pairs[:, 0] * len(low) + pairs[:, 1]
        return Pairs(sheet.triangles[pairs[:, 0]], sheet.triangles[pairs[:, 1]], sheet.owner[pairs], numbers, False)

    # where the corners are

    def corners(self, state: State) -> Array:
        """(T, 3, 3) positions in space."""
        sheet = self.sheet
        flat = self.linkage.flat[sheet.triangles]
        return np.asarray(flat @ state.turn[sheet.owner].transpose(0, 2, 1) + state.shift[sheet.owner][:, None])

    def velocities(self, state: State) -> Array:
        """(T, 3, 3) velocities of the corners in space."""
        sheet = self.sheet
        arm = self.linkage.flat[sheet.triangles] @ state.turn[sheet.owner].transpose(0, 2, 1)
        return np.asarray(cross(state.spin[sheet.owner][:, None], arm) + state.drift[sheet.owner][:, None])

    def first(self, pairs: Pairs) -> Array:
        """(N, 3, 3) the first triangles, flat: they stay in their panel's frame."""
        return self.linkage.flat[pairs.first]

    def second(self, pairs: Pairs, state: State) -> tuple[Array, Array]:
        """(N, 3, 3) positions and velocities of the second triangles seen from the first panels."""
        p, q = pairs.panels.T
        flat = self.linkage.flat[pairs.second]
        arm = flat @ state.turn[q].transpose(0, 2, 1)
        rel = arm + (state.shift[q] - state.shift[p])[:, None]
        # from the panel x = T·X + s:  X' = Tᵀ(ẋ − ṡ − ω × (x − s))
        speed = cross(state.spin[q][:, None], arm) + (state.drift[q] - state.drift[p])[:, None]
        speed -= cross(state.spin[p][:, None], rel)
        return rel @ state.turn[p], speed @ state.turn[p]

    def depth(self, pairs: Pairs, state: State) -> Array:
        """(N,) how far the triangles reach into each other at one state; positive: they cross."""
        work = [crossing_depth(self.first(part), self.second(part, state)[0]) for part in pairs.parts()]
        return np.concatenate([np.empty(0), *work])

    def gap(self, pairs: Pairs, state: State) -> Array:
        """(N,) distances at one state; of pairs that share a vertex, how far apart the cones are (their unit sides)."""
        work = [apart(part.hinged, self.first(part), self.second(part, state)[0])[0] for part in pairs.parts()]
        return np.concatenate([np.empty(0), *work])


def parts(count: int) -> list[slice]:
    """So many pairs, a bounded number at a time: what is worked out for them takes some kilobytes each."""
    return [slice(start, min(start + _AT_A_TIME, count)) for start in range(0, count, _AT_A_TIME)]


def apart(hinged: bool, p: Array, q: Array) -> tuple[Array, Array]:
    """How far apart triangles, or cones from corner 0, are, at least 0, and the direction that shows it."""
    distance, direction = separating_cones(p[:, 1:] - p[:, :1], q[:, 1:] - q[:, :1]) if hinged else separating(p, q)
    return np.maximum(distance, 0.0), direction


def _from(triangle: Indices, vertex: int) -> Indices:
    """The corners in turn from a vertex on."""
    return np.roll(triangle, -int(np.flatnonzero(triangle == vertex)[0]))


def _bodies(count: int, joined: Indices) -> Indices:
    """(F,) the rigid body of each panel, panels being joined over creases that do not fold."""
    body = np.arange(count)
    changed = True
    while changed:
        before = body.copy()
        np.minimum.at(body, joined[:, 0], body[joined[:, 1]])
        np.minimum.at(body, joined[:, 1], body[joined[:, 0]])
        body = body[body]
        changed = bool((body != before).any())
    return body
