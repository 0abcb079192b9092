"""Panels as triangles, for everything that draws or meshes a pattern read from a file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def triangulate(
    vertices: NDArray[np.float64], panels: Sequence[Sequence[int]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut panels into triangles by clipping ears in the flat pattern.

    Parameters
    ----------
    vertices
        (V, 2) flat positions.
    panels
        Counter-clockwise simple polygons; vertices on their sides are fine.

    Returns
    -------
    triangles, panel
        (T, 3) counter-clockwise vertex triples and (T,) the panel each belongs to. Triangles without area are
        left out.
    """
    triangles: list[tuple[int, int, int]] = []
    owners: list[int] = []
    points = [(float(x), float(y)) for x, y in vertices]
    for index, panel in enumerate(panels):
        cut = _ears(points, list(panel))
        triangles += cut
        owners += [index] * len(cut)
    return np.array(triangles, dtype=np.int64).reshape(-1, 3), np.array(owners, dtype=np.int64)


def _ears(points: Sequence[tuple[float, float]], ring: list[int]) -> list[tuple[int, int, int]]:
    """The triangles of one polygon."""
    found = []
    while len(ring) > 3:
        at = _best_ear(points, ring)
        u, v, w = ring[at - 1], ring[at], ring[(at + 1) % len(ring)]
        if _area(points[u], points[v], points[w]) > 0.0:
            found.append((u, v, w))
        del ring[at]
    if _area(*(points[v] for v in ring)) > 0.0:
        found.append((ring[0], ring[1], ring[2]))
    return found


def _best_ear(points: Sequence[tuple[float, float]], ring: list[int]) -> int:
    """The corner to clip: an ear as far from a sliver as there is.

    A vertex in the middle of a side (area 0) is no ear as long as a real one is left, or it would vanish from
    the triangulation and leave a crack in a mesh. A polygon that is not simple has no ear at some point; then
    any convex corner does.
    """
    best, best_score = 0, -np.inf
    for at in range(len(ring)):
        a, b, c = points[ring[at - 1]], points[ring[at]], points[ring[(at + 1) % len(ring)]]
        area = _area(a, b, c)
        longest = max((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 for p, q in ((a, b), (b, c), (c, a)))
        score = area / longest if longest > 0.0 else 0.0
        if score <= best_score:
            continue
        corners = (a, b, c)
        blocked = any(
            points[v] not in corners and _inside(points[v], a, b, c) for v in ring
        )  # a pinched polygon visits a point twice: equal points do not block
        if area > 0.0 and blocked:
            score -= 10.0
        if score > best_score:
            best, best_score = at, score
    return best


def _area(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the signed area of a triangle."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _inside(p: tuple[float, float], a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    """Whether ``p`` is in the closed counter-clockwise triangle."""
    return _area(a, b, p) >= 0.0 and _area(b, c, p) >= 0.0 and _area(c, a, p) >= 0.0
