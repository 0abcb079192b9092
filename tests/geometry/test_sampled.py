"""The nearest of the random points of a surface, against all of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from origami_lab.geometry.sampled import LANES, nearest_sample_squared, sample_surface, sample_within_squared
from origami_lab.geometry.sampling import sample_triangles, surface_draws
from tests.geometry.test_bvh import random_triangles


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(1, 400))
def test_equals_brute_force(seed: int, count: int, number: int) -> None:
    triangles = random_triangles(seed, count, 0.5)
    triangles[0, :] = np.eye(3)  # there is some area
    draws = surface_draws(number, np.random.default_rng(seed))
    sampled = sample_surface(triangles, draws[np.argsort(draws[:, 0], kind="stable")])
    points = sample_triangles(triangles, number, np.random.default_rng(seed))
    assert int(sampled.starts[-1]) == number
    for point in 2 * np.random.default_rng(seed + 1).normal(size=(8, 3)):
        exact = ((points - point) ** 2).sum(axis=1).min()
        assert nearest_sample_squared(sampled, *point, 0.0, np.inf) == pytest.approx(exact, rel=1e-12)
        assert nearest_sample_squared(sampled, *point, 0.0, 0.5 * exact) == pytest.approx(0.5 * exact, rel=1e-12)
        assert exact <= nearest_sample_squared(sampled, *point, 2.0 * exact, np.inf) * (1 + 1e-12)
        for limit_sq in (0.5 * exact, 0.99 * exact, 1.01 * exact, 4.0 * exact, -1.0, np.inf):
            within = sample_within_squared(sampled, *point, limit_sq)
            assert (within <= limit_sq) == (exact <= limit_sq)
            if within <= limit_sq:
                assert within >= exact * (1 - 1e-12)


@pytest.mark.parametrize("number", [1, LANES - 1, LANES, LANES + 1, 2 * LANES, 5 * LANES + 3])
def test_every_point_of_a_triangle_is_looked_at(number: int) -> None:
    triangle = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]]])
    draws = surface_draws(number, np.random.default_rng(number))
    sampled = sample_surface(triangle, draws[np.argsort(draws[:, 0], kind="stable")])
    for point in sample_triangles(triangle, number, np.random.default_rng(number)):
        assert nearest_sample_squared(sampled, *point, 0.0, np.inf) == pytest.approx(0.0, abs=1e-24)
