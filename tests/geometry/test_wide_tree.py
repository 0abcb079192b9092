"""The eight-wide tree against brute force, wherever a search begins."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from origami_lab.geometry.bvh import build_bvh
from origami_lab.geometry.wide_tree import MOST_LEVELS, WIDTH, build_wide_tree, nearest_row, row_squared
from tests.geometry.test_bvh import brute, random_triangles


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 200), st.sampled_from([0.0, 0.1, 1.0]))
def test_equals_brute_force(seed: int, count: int, size: float) -> None:
    rng = np.random.default_rng(seed + 1)
    bvh = build_bvh(random_triangles(seed, count, size))
    tree, far = build_wide_tree(bvh), np.empty((MOST_LEVELS, WIDTH))
    assert tree.are_points == bool((bvh.triangles == bvh.triangles[:, :1]).all())
    for point in 2 * rng.normal(size=(5, 3)):
        squared = brute(bvh.triangles, point)
        nearest = pytest.approx(squared.min(), rel=1e-14)
        for near in (0, count - 1, int(rng.integers(count))):  # whatever is looked at first
            exact, row = nearest_row(tree, *point, 0.0, np.inf, near, far)
            assert exact == nearest
            assert squared[row] == nearest
            # what the caller may say about the answer
            assert nearest_row(tree, *point, 0.0, 0.5 * exact, near, far) == (0.5 * exact, near)
            early, row = nearest_row(tree, *point, 2.0 * exact, np.inf, near, far)
            assert exact <= early <= 2.0 * exact
            assert squared[row] == pytest.approx(early, rel=1e-14)


@pytest.mark.parametrize("count", [1, 2, 3, 8, 9, 64, 65, 512, 513, 5000])
def test_trees_of_points_of_every_size(count: int) -> None:
    points = np.random.default_rng(count).normal(size=(count, 3))
    tree = build_wide_tree(build_bvh(np.repeat(points[:, None], 3, axis=1)))
    far = np.empty((MOST_LEVELS, WIDTH))
    assert tree.are_points
    near = 0
    for point in np.random.default_rng(0).normal(size=(20, 3)):
        squared, near = nearest_row(tree, *point, 0.0, np.inf, near, far)
        assert squared == pytest.approx(((points - point) ** 2).sum(axis=1).min(), rel=1e-13)


def test_answers_are_the_same_to_the_last_bit_wherever_a_search_begins() -> None:
    """On a height field a box often ends at the nearest corner, and rounding may put the one before the other."""
    rng = np.random.default_rng(0)
    heights = np.cumsum(rng.normal(size=(9, 9)), axis=0)
    points = np.array([[[x - 4.0, y / 3.0, heights[x, y]] for y in range(9)] for x in range(9)])
    lower, upper = (
        [points[:-1, :-1], points[1:, :-1], points[:-1, 1:]],
        [points[1:, 1:], points[:-1, 1:], points[1:, :-1]],
    )
    bvh = build_bvh(np.concatenate([np.stack(each, axis=2).reshape(-1, 3, 3) for each in (lower, upper)]))
    tree, far = build_wide_tree(bvh), np.empty((MOST_LEVELS, WIDTH))
    rows = range(len(bvh.triangles))
    for point in 6 * rng.normal(size=(300, 3)):
        squared = min(row_squared(tree, row, *point) for row in rows)
        assert {nearest_row(tree, *point, 0.0, np.inf, near, far)[0] for near in rows[::8]} == {squared}
