"""Points on triangulated surfaces: covering ones, exactly symmetric where the mesh is, and random ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MAX_CELLS = 4_000_000
"""`covering_points` refuses a spacing that would cut the surface into more triangles than this."""


def areas(triangles: Array) -> Array:
    """(F,) areas of (F, 3, 3) triangles."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def surface_draws(count: int, rng: np.random.Generator) -> Array:
    """(count, 3) numbers in [0, 1) that choose points of a surface: a share of its area, and where in that triangle."""
    return np.column_stack((rng.random(count), np.sqrt(rng.random(count)), rng.random(count)))


def sample_triangles(triangles: Array, count: int, rng: np.random.Generator) -> Array:
    """``count`` points (count, 3), uniform by area on (F, 3, 3) triangles of positive total area.

    This is the paper's sampling of a surface (10,000 points).
    """
    share, root, along = surface_draws(count, rng).T[:, :, None]
    a, b, c = np.moveaxis(triangles, 1, 0)
    cumulative = np.cumsum(areas(triangles))
    chosen = np.searchsorted(cumulative, share[:, 0] * cumulative[-1], side="right")
    chosen = np.minimum(chosen, len(triangles) - 1)  # rounding may reach the last sum
    return np.asarray((1.0 - root) * a[chosen] + root * (1.0 - along) * b[chosen] + root * along * c[chosen])


def covering_points(triangles: Array, spacing: float) -> Array:
    """Points (n, 3), sorted, one of them within spacing/√3 of every point of (F, 3, 3) triangles.

    They are the corners after all edges longer than ``spacing`` > 0 were halved, again and again. Where
    exchanging or negating x and y maps the mesh to itself, it does so with the points, to the last bit.

    Raises
    ------
    ValueError
        If more than :data:`MAX_CELLS` triangles would be needed.
    """
    cells = triangles
    points = [cells.reshape(-1, 3)]
    while len(cells):
        if len(cells) > MAX_CELLS:
            raise ValueError(f"more than {MAX_CELLS} triangles")
        cells = _split(cells, spacing)
        points.append(cells.reshape(-1, 3))
    return _sorted_points(np.concatenate(points))


def _sorted_points(points: Array) -> Array:
    """Each of (n, 3) points once, sorted by coordinates: numpy's ``unique`` of rows takes several times as long."""
    points = points[np.lexsort(points.T[::-1])]
    return np.asarray(points[np.append(True, (points[1:] != points[:-1]).any(axis=1))])


def _squared(d: Array) -> Array:
    """Squared lengths, summed by hand: x and y must be interchangeable to the last bit."""
    return np.asarray((d[..., 0] * d[..., 0] + d[..., 1] * d[..., 1]) + d[..., 2] * d[..., 2])


def _split(cells: Array, spacing: float) -> Array:
    """Halve all edges of (n, 3, 3) triangles longer than ``spacing``; triangles without one are left out.

    What is cut depends on lengths only, never on the order of corners, so that mirror images are cut alike.
    """
    long = _squared(cells - np.roll(cells, -1, axis=1)) > spacing * spacing
    number = long.sum(axis=1)
    # turn each triangle so that its one long edge, or its one short edge, comes first
    odd_one = np.where(number == 1, long.argmax(axis=1), np.where(number == 2, long.argmin(axis=1), 0))
    turned = np.take_along_axis(cells, ((odd_one[:, None] + np.arange(3)) % 3)[:, :, None], axis=1)

    a, b, c = np.moveaxis(turned[number == 1], 1, 0)
    m = 0.5 * (a + b)
    pieces = [(a, m, c), (m, b, c)]

    a, b, c = np.moveaxis(turned[number == 3], 1, 0)
    m, n, o = 0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)
    pieces += [(a, o, n), (o, b, m), (n, m, c), (m, n, o)]

    # two long edges: a triangle at their corner and a quadrilateral a, b, m, n, cut along its shorter
    # diagonal or, where neither is (it may be its own mirror image), from its centre
    a, b, c = np.moveaxis(turned[number == 2], 1, 0)
    m, n = 0.5 * (b + c), 0.5 * (c + a)
    pieces.append((n, m, c))
    am, bn = _squared(m - a), _squared(n - b)
    for shorter, cut in ((am < bn, ((0, 1, 2), (0, 2, 3))), (am > bn, ((0, 1, 3), (1, 2, 3)))):
        corners = [point[shorter] for point in (a, b, m, n)]
        pieces += [(corners[i], corners[j], corners[k]) for i, j, k in cut]
    a, b, m, n = (point[am == bn] for point in (a, b, m, n))
    o = 0.5 * (0.5 * (a + b) + 0.5 * (m + n))
    pieces += [(a, b, o), (b, m, o), (m, n, o), (n, a, o)]
    return np.concatenate([np.stack(piece, axis=1) for piece in pieces])
