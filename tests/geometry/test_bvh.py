"""The tree against brute force, and the inside test against a cube, a sphere and winding numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from origami_lab.geometry.bvh import (
    LEAF_SIZE,
    build_bvh,
    distances,
    inside,
    nearest_squared,
    nearest_triangle,
)
from origami_lab.geometry.distance import point_triangle_squared
from origami_lab.targets.solids import bowl, cube

Array = NDArray[np.float64]


def brute(triangles: Array, point: Array) -> Array:
    return np.array([point_triangle_squared(*point, *t) for t in triangles.reshape(-1, 9).tolist()])


def random_triangles(seed: int, count: int, size: float) -> Array:
    rng = np.random.default_rng(seed)
    triangles = rng.normal(size=(count, 1, 3)) + size * rng.normal(size=(count, 3, 3))
    triangles[rng.random(count) < 0.1, 1] = triangles[0, 0]  # long ones
    flat = rng.random(count) < 0.1
    triangles[flat, 2] = triangles[flat, 1]
    point = rng.random(count) < 0.1
    triangles[point, 1:] = triangles[point, :1]
    return np.round(triangles, 1) if seed % 3 == 0 else triangles


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60), st.sampled_from([0.0, 0.1, 1.0]))
def test_equals_brute_force(seed: int, count: int, size: float) -> None:
    triangles = random_triangles(seed, count, size)
    bvh = build_bvh(triangles)
    points = 2 * np.random.default_rng(seed + 1).normal(size=(5, 3))
    found = distances(bvh, points)
    for point, value in zip(points, found, strict=True):
        squared = brute(triangles, point)
        # to the last bit but one: the same formula may be compiled in another order elsewhere
        nearest = pytest.approx(squared.min(), rel=1e-14)
        assert value**2 == nearest
        exact, row = nearest_triangle(bvh, *point, 0.0, np.inf)
        assert exact == nearest
        assert squared[bvh.original[row]] == nearest
        # what the caller may say about the answer
        assert nearest_squared(bvh, *point, 0.0, 0.5 * exact) == 0.5 * exact
        assert nearest_triangle(bvh, *point, 0.0, 0.5 * exact)[1] == -1
        early = nearest_squared(bvh, *point, 2.0 * exact, np.inf)
        assert exact <= early <= 2.0 * exact


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7, 8, 9, 31, 300])
def test_the_tree_is_well_formed(count: int) -> None:
    triangles = random_triangles(1, count, 0.3)
    bvh = build_bvh(triangles)
    assert sorted(bvh.original) == list(range(count))
    assert (bvh.triangles == triangles[bvh.original]).all()
    leaves = len(bvh.boxes) // 2
    assert leaves * LEAF_SIZE >= count
    for node in range(1, len(bvh.boxes)):
        level = node.bit_length() - 1
        position, width = node - (1 << level), 1 << level
        own = bvh.triangles[count * position // width : count * (position + 1) // width].reshape(-1, 3)
        assert (bvh.boxes[node, :3] == own.min(axis=0)).all()
        assert (bvh.boxes[node, 3:] == own.max(axis=0)).all()
        assert node < leaves or 1 <= len(own) // 3 <= LEAF_SIZE


def test_equal_triangles_and_none() -> None:
    bvh = build_bvh(np.ones((50, 3, 3)))
    assert distances(bvh, np.array([[1.0, 1.0, 3.0]])) == pytest.approx([2.0])
    with pytest.raises(ValueError, match="at least one triangle"):
        build_bvh(np.empty((0, 3, 3)))


def test_a_tree_over_points_is_a_nearest_neighbour_search() -> None:
    rng = np.random.default_rng(2)
    samples, points = rng.normal(size=(500, 3)), rng.normal(size=(100, 3))
    bvh = build_bvh(np.repeat(samples[:, None], 3, axis=1))
    np.testing.assert_allclose(distances(bvh, points), cKDTree(samples).query(points)[0], rtol=1e-14)


def test_inside_the_cube() -> None:
    bvh = cube().bvh
    # round coordinates on purpose: rays from them meet many edges if the direction is a bad one
    grid = np.arange(-1.75, 3.0, 0.25)
    for x in grid:
        for y in grid:
            for z in grid:
                gap = max(abs(x) - 1, abs(y) - 1, abs(z - 1) - 1)
                if gap != 0:
                    assert inside(bvh, x, y, z) == (gap < 0)


def test_inside_a_sphere_turned_about() -> None:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3)
    bvh = build_bvh(np.array(ball.triangles))
    points = np.random.default_rng(3).normal(size=(4000, 3)) * 0.8
    radius = np.linalg.norm(points, axis=1)
    inner = np.linalg.norm(ball.triangles_center, axis=1).min()
    for point, r in zip(points, radius, strict=True):
        if not inner - 1e-3 < r < 1:
            assert inside(bvh, *point) == (r < 1)
    for t in ball.triangles_center:  # just below and just above every face
        assert inside(bvh, *(0.999 * t))
        assert not inside(bvh, *(1.001 * t))


def test_inside_a_non_convex_solid_equals_the_winding_number() -> None:
    triangles = cube().triangles.copy()
    triangles[np.linalg.norm(triangles - [0, 0, 2], axis=2) < 1e-9] = (0.1, 0.2, 0.5)  # the lid pushed in
    bvh = build_bvh(triangles)
    for p in np.random.default_rng(4).uniform((-1.2, -1.2, -0.2), (1.2, 1.2, 2.2), size=(1000, 3)):
        a, b, c = np.moveaxis(triangles - p, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        dot = [(u * v).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))]
        top = (a * np.cross(b, c)).sum(axis=1)
        angle = 2 * np.arctan2(top, la * lb * lc + dot[0] * lc + dot[1] * la + dot[2] * lb).sum()
        assert inside(bvh, *p) == (round(angle / (4 * np.pi)) == 1)


def test_the_bowl_and_its_mirror_image() -> None:
    target = bowl()
    points = np.random.default_rng(5).normal(size=(50, 3)) * [3, 3, 2] + [0, 0, 2]
    swapped = np.ascontiguousarray(points[:, [1, 0, 2]])
    np.testing.assert_allclose(distances(target.bvh, points), distances(target.bvh, swapped), atol=1e-13)
