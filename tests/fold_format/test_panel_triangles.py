"""Cutting panels into triangles."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.fold_format.panel_triangles import triangulate

POLYGONS = {
    "triangle": ([(0, 0), (1, 0), (0, 1)], 0.5),
    "convex": ([(0, 0), (4, 0), (5, 2), (2, 5), (-1, 2)], 19.0),
    "reflex": ([(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)], 10.0),
    "on the sides": ([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)], 4.0),
    "spiral": (
        [(0, 0), (6, 0), (6, 6), (2, 6), (2, 3), (4, 3), (4, 5), (5, 5), (5, 1), (1, 1), (1, 7), (0, 7)],
        24.0,
    ),
}


@pytest.mark.parametrize(("ring", "area"), POLYGONS.values(), ids=POLYGONS)
def test_triangles_tile_the_polygon(ring: list[tuple[float, float]], area: float) -> None:
    points = np.array(ring, dtype=float)
    x, y = points.T
    assert (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 == pytest.approx(area)
    triangles, owners = triangulate(points, [range(len(ring))])
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    assert (twice > 0).all()
    assert twice.sum() / 2 == pytest.approx(area)
    assert len(triangles) == len(ring) - 2  # every vertex is used: no cracks in a mesh
    assert set(owners) == {0}
    # every side of the polygon once, every diagonal once in each direction
    sides = {(i, (i + 1) % len(ring)) for i in range(len(ring))}
    used = [(t[i], t[(i + 1) % 3]) for t in triangles.tolist() for i in range(3)]
    assert len(set(used)) == len(used)
    assert sides <= set(used)
    assert all((v, u) in used for u, v in set(used) - sides)


def test_owners_and_empty_panels() -> None:
    points = np.array([(0, 0), (1, 0), (2, 0), (1, 1)], dtype=float)
    triangles, owners = triangulate(points, [(0, 1, 3), (0, 1, 2), (1, 2, 3)])
    assert owners.tolist() == [0, 2]
    assert triangles.shape == (2, 3)
