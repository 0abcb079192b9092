"""Polygons cut into triangles: exact areas and gapless edges, in integers, in any plane and at any scale."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.targets.mesh_formats.polygons import Polygons, triangulate

Ring = list[tuple[int, int]]


@st.composite
def simple_rings(draw: st.DrawFn) -> Ring:
    """Monotone polygons on the integers: convex, concave, with straight corners; counter-clockwise, from any corner."""
    columns = draw(st.integers(2, 9))
    heights = st.integers(0, 4)  # few values, so that many sides are in line
    lower = [draw(heights) for _ in range(columns)]
    upper = [low + draw(st.integers(1, 4)) for low in lower]
    xs = np.cumsum([draw(st.integers(1, 3)) for _ in range(columns)]).tolist()
    ring = list(zip(xs, lower, strict=True)) + list(zip(xs, upper, strict=True))[::-1]
    first = draw(st.integers(0, len(ring) - 1))
    return ring[first:] + ring[:first]


def doubled_area(ring: Ring) -> int:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1], strict=True))


def check(ring: Ring, triangles: NDArray[np.int64]) -> None:
    """That triangles of a counter-clockwise ring fill it once, and leave no gap to what lies beside it."""
    areas = [doubled_area([ring[k] for k in triangle]) for triangle in triangles.tolist()]
    assert min(areas) >= 0
    assert sum(areas) == doubled_area(ring)
    assert len(triangles) == len(ring) - 2
    edges = Counter((t[k], t[(k + 1) % 3]) for t in triangles.tolist() for k in range(3))
    sides = {(k, (k + 1) % len(ring)) for k in range(len(ring))}
    assert max(edges.values()) == 1
    assert {edge for edge in edges if edge[::-1] not in edges} == sides


def in_space(ring: Ring, frame: NDArray[np.int64]) -> NDArray[np.float64]:
    """Points of the plane that a frame (origin and two axes) spans; integers, so without any rounding."""
    return np.array([[1, x, y] for x, y in ring]) @ frame.astype(np.float64)


vectors = st.tuples(*[st.integers(-9, 9)] * 3)
frames = st.tuples(st.tuples(*[st.integers(-1000, 1000)] * 3), vectors, vectors).filter(
    lambda f: np.cross(f[1], f[2]).any()
)


@given(ring=simple_rings(), frame=frames, exponent=st.integers(-250, 250), turned=st.booleans())
def test_any_simple_polygon_in_any_plane_at_any_scale(
    ring: Ring, frame: tuple[object, ...], exponent: int, turned: bool
) -> None:
    points = in_space(ring, np.array(frame)) * 2.0**exponent
    order = list(range(len(ring)))[:: -1 if turned else 1]
    triangles = triangulate(Polygons.of(points, [order]))
    check(ring, triangles[:, ::-1] if turned else triangles)


@given(rings=st.lists(simple_rings(), min_size=1, max_size=6))
def test_many_polygons_keep_their_order(rings: list[Ring]) -> None:
    points, named, first = [], [], 0
    for ring in rings:
        points += [(x, y, 0) for x, y in ring]
        named.append(list(range(first, first + len(ring))))
        first += len(ring)
    triangles = triangulate(Polygons.of(np.array(points, dtype=np.float64), named))
    at = 0
    for ring, names in zip(rings, named, strict=True):
        own = triangles[at : at + len(ring) - 2]
        check(ring, own - names[0])
        at += len(own)
    assert at == len(triangles)


@given(n=st.integers(3, 40), frame=frames)
def test_convex_polygons_are_fans_about_their_first_corner(n: int, frame: tuple[object, ...]) -> None:
    parabola = [(k, k * k) for k in range(n)]
    triangles = triangulate(Polygons.of(in_space(parabola, np.array(frame)), [range(n)]))
    assert triangles.tolist() == [[0, k, k + 1] for k in range(1, n - 1)]


@pytest.mark.parametrize("teeth", [3, 200])
def test_a_comb(teeth: int) -> None:
    ring: Ring = [(0, -1), (2 * teeth, -1)]
    for k in range(teeth, 0, -1):
        ring += [(2 * k, 50), (2 * k - 1, 50), (2 * k - 1, 0), (2 * k - 2, 0)]
    check(ring, triangulate(Polygons.of(np.array([(x, y, 3.0) for x, y in ring]), [range(len(ring))])))


def test_a_hole_on_a_bridge() -> None:
    outer: Ring = [(0, 0), (4, 0), (4, 4), (0, 4)]
    hole: Ring = [(1, 1), (1, 3), (3, 3), (3, 1)]
    points = np.array([(x, y, 0.0) for x, y in outer + hole])
    triangles = triangulate(Polygons.of(points, [[0, 1, 2, 3, 0, 4, 5, 6, 7, 4]]))
    areas = [doubled_area([(outer + hole)[k] for k in triangle]) for triangle in triangles.tolist()]
    assert min(areas) >= 0
    assert sum(areas) == 2 * (16 - 4)


@settings(max_examples=30)
@given(ring=simple_rings(), seed=st.integers(0, 2**32 - 1))
def test_a_face_that_is_not_quite_flat(ring: Ring, seed: int) -> None:
    """Rounded to float32 after a rotation, as files have it."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    points = (np.array([(x, y, 0.0) for x, y in ring]) @ turn).astype(np.float32).astype(np.float64)
    triangles = triangulate(Polygons.of(points, [range(len(ring))]))
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(0.5 * doubled_area(ring), rel=1e-5)


def test_what_has_no_area_or_too_few_corners() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [1, 1, 0]])
    assert triangulate(Polygons.of(points, [[0, 1, 2, 3]])).shape == (2, 3)
    assert triangulate(Polygons.of(points, [[0, 0, 0, 0]])).shape == (2, 3)
    polygons = Polygons.of(points, [[], [0], [0, 1], [0, 1, 4], [2]])
    assert triangulate(polygons).tolist() == [[0, 1, 4]]
    assert polygons.triangle_count == 1
    assert triangulate(Polygons.of(points, [])).shape == (0, 3)
