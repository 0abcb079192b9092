"""The nearest of the random points of a surface, against all of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from origami_lab.geometry.sampled import nearest_sample_squared, sample_surface
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
