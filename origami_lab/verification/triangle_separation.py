"""Pairs of triangles in space: do they cross, how far are they apart, which plane separates them.

Two convex sets are apart by what the best direction shows: along the unit vector n the gap is min n·P − max n·Q. For
triangles the best one is among finitely many: the normals, the cross products of sides, and the shortest connections of
their corners and sides. A positive gap proves that they are apart, whatever the direction; if all directions of the
first two kinds show overlap, triangles in different planes cross. Triangles in one plane overlap without crossing: the
gap along the normal is 0. All functions work on N pairs at a time, arrays (N, 3 corners, 3).
"""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.plane_graph import cross

Array = NDArray[np.float64]

TOUCH = 1e-9
"""Of the sheet's size: triangles that reach into each other by no more are in contact, not crossing."""
_PARALLEL = 1e-9
_NEXT, _LAST = (1, 2, 0), (2, 0, 1)


def gaps(directions: Array, p: Array, q: Array) -> Array:
    """(N, K) by how much each of the unit directions (N, K, 3) separates p from q, n pointing from q to p."""
    return least(directions, p) + least(-directions, q)


def least(directions: Array, points: Array) -> Array:
    """(N, K) the least of n·x over points (N, P, 3), for directions (N, K, 3)."""
    heights = (directions @ points.transpose(0, 2, 1)).transpose(2, 0, 1)
    return np.asarray(reduce(np.minimum, heights))  # several times faster than min over a short last axis


def crossing_depth(p: Array, q: Array) -> Array:
    """(N,) how far triangles reach into each other: positive if they cross, at most 0 if they do not."""
    return np.asarray(-_best(_planes(p, q), p, q)[0])


def separating(p: Array, q: Array) -> tuple[Array, Array]:
    """(N,) distances, negative where triangles cross, and (N, 3) the directions that show them, from q to p."""
    return _best(np.concatenate([_planes(p, q), _connections(p, q)], axis=1), p, q)


def overlap_in_plane(p: Array, q: Array, tolerance: float) -> NDArray[np.bool_]:
    """(N,) whether triangles lie in one plane and overlap there by more than the tolerance."""
    normal = _unit(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), None)
    height = np.einsum("nkj,nj->nk", q - p[:, :1], normal)
    sides = np.concatenate([p[:, _NEXT] - p, q[:, _NEXT] - q], axis=1)
    across = _unit(cross(sides, normal[:, None]), None)
    best, _ = _best(across, p, q)
    return np.asarray((np.abs(height).max(axis=1) <= tolerance) & (best < -tolerance))


def separating_cones(p: Array, q: Array) -> tuple[Array, Array]:
    """Cones from the origin over (N, 2, 3) sides each: the gap and the direction of the plane that parts them best.

    The gap is the least distance of the four unit sides from the plane, at most 0 where none parts the cones but
    in the origin: the point of the hull of the sides (q's turned round) that is nearest to the origin.
    """
    z = np.concatenate([_unit(p, None), -_unit(q, None)], axis=1)
    found = [z]
    for i in range(4):
        for j in range(i + 1, 4):
            normal = _unit(cross(z[:, i], z[:, j]), z[:, i])[:, None]  # where they touch
            found += [normal, -normal]
            side = z[:, j] - z[:, i]
            t = np.einsum("nj,nj->n", -z[:, i], side) / np.maximum(np.einsum("nj,nj->n", side, side), 1e-300)
            found.append(_unit(z[:, i] + t[:, None] * side, z[:, i])[:, None])
    for skip in range(4):
        a, b, c = (z[:, i] for i in range(4) if i != skip)
        normal = _unit(cross(b - a, c - a), a)[:, None]
        found += [normal, -normal]
    directions = np.concatenate(found, axis=1)
    gap = least(directions, z)
    at = np.argmax(gap, axis=1)
    rows = np.arange(len(z))
    return gap[rows, at], directions[rows, at]


def _best(directions: Array, p: Array, q: Array) -> tuple[Array, Array]:
    """The largest gap over directions and their opposites, and the direction."""
    one, other = gaps(directions, p, q), gaps(directions, q, p)
    larger = np.maximum(one, other)
    at, rows = np.argmax(larger, axis=1), np.arange(len(p))
    sign = np.where(one[rows, at] >= other[rows, at], 1.0, -1.0)
    return larger[rows, at], sign[:, None] * directions[rows, at]


def _planes(p: Array, q: Array) -> Array:
    """(N, 11, 3) normals and cross products of sides; what is too short to point anywhere becomes the first normal."""
    normals = [_unit(cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), None)[:, None] for t in (p, q)]
    sides = [_unit(t[:, _NEXT] - t, None) for t in (p, q)]
    products = cross(sides[0][:, :, None], sides[1][:, None]).reshape(len(p), 9, 3)
    return np.concatenate([*normals, _unit(products, np.broadcast_to(normals[0], products.shape))], axis=1)


def _connections(p: Array, q: Array) -> Array:
    """(N, 33, 3) from corner to corner, from corner to side, and the sides' normals in their planes."""
    found = [(p[:, :, None] - q[:, None]).reshape(len(p), 9, 3)]
    for one, other in ((p, q), (q, p)):
        side = _unit(other[:, _NEXT] - other, None)
        to = one[:, :, None] - other[:, None]
        found.append((to - np.einsum("nijk,njk->nij", to, side)[..., None] * side[:, None]).reshape(len(p), 9, 3))
        found.append(cross(side, cross(side, other[:, _LAST] - other)))
    directions = np.concatenate(found, axis=1)
    normal = _unit(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), None)
    return _unit(directions, np.broadcast_to(normal[:, None], directions.shape))


def _unit(vectors: Array, instead: Array | None) -> Array:
    """Unit vectors; where there is no direction, ``instead``."""
    length = np.sqrt(np.einsum("...j,...j->...", vectors, vectors))[..., None]
    out = vectors / np.where(length > 0.0, length, 1.0)
    return np.asarray(out if instead is None else np.where(length > _PARALLEL, out, instead))
