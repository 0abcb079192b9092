"""Point–triangle and point–box distances against closed forms, dense sampling and a quadratic programme."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import nnls

from origami_lab.geometry.distance import point_box_squared, point_segment_squared, point_triangle_squared

Array = NDArray[np.float64]
RIGHT = np.array([[0.0, 0, 0], [4.0, 0, 0], [0.0, 3, 0]])


def distance(point: Array, triangle: Array) -> float:
    return float(np.sqrt(point_triangle_squared(*map(float, point), *map(float, triangle.reshape(-1)))))


def by_least_squares(point: Array, triangle: Array) -> float:
    """An independent truth: non-negative least squares with the weights' sum pinned to 1 by a heavy row."""
    heavy = 1e5
    weights, _ = nnls(np.vstack([triangle.T, np.full(3, heavy)]), np.append(point, heavy))
    return float(np.linalg.norm(weights / weights.sum() @ triangle - point))


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((1, 1, 0), 0.0),
        ((1, 1, -2), 2.0),
        ((-3, -4, 0), 5.0),  # corner a
        ((7, -4, 0), 5.0),  # corner b
        ((-4, 6, 12), 13.0),  # corner c
        ((2, -3, 4), 5.0),  # side ab
        ((-3, 1, 4), 5.0),  # side ca
        ((2 + 3, 1.5 + 4, 12), 13.0),  # side bc, from its middle along (3, 4)/5
        ((4, 0, 0), 0.0),
        ((2, 1.5, 0), 0.0),
    ],
)
def test_every_region_has_its_closed_form(point: tuple[float, ...], expected: float) -> None:
    for turn in range(3):
        for flip in (1, -1):
            triangle = np.roll(RIGHT, turn, axis=0)[::flip]
            assert distance(np.array(point, float), triangle) == pytest.approx(expected, abs=1e-14)


coordinate = st.integers(-3, 3).map(float) | st.floats(-3, 3, width=32)
points = st.tuples(coordinate, coordinate, coordinate).map(np.array)


@settings(max_examples=300, deadline=None)
@given(points, points, points, points)
def test_against_least_squares(p: Array, a: Array, b: Array, c: Array) -> None:
    triangle = np.array([a, b, c])
    assert distance(p, triangle) == pytest.approx(by_least_squares(p, triangle), abs=2e-6)


def test_against_dense_sampling() -> None:
    rng = np.random.default_rng(1)
    u, v = np.meshgrid(np.linspace(0, 1, 80), np.linspace(0, 1, 80))
    inside = u + v <= 1
    weights = np.stack([1 - u - v, u, v], axis=-1)[inside]
    for _ in range(50):
        triangle, point = rng.normal(size=(3, 3)), 2 * rng.normal(size=3)
        sampled = np.linalg.norm(weights @ triangle - point, axis=1).min()
        exact = distance(point, triangle)
        assert exact <= sampled + 1e-12
        assert sampled - exact <= np.ptp(triangle, axis=0).sum() / 79


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0), (0, 2, 1), (1, 0, 2)])
def test_segments_and_points(order: tuple[int, int, int]) -> None:
    take = list(order)
    collinear = np.array([[0.0, 0, 0], [1.0, 0, 0], [3.0, 0, 0]])[take]
    assert distance(np.array([2.0, 3, 4]), collinear) == pytest.approx(5.0)
    assert distance(np.array([6.0, 0, 4]), collinear) == pytest.approx(5.0)
    double = np.array([[1.0, 1, 1], [1.0, 1, 1], [1.0, 1, 3]])[take]
    assert distance(np.array([4.0, 5, 2]), double) == pytest.approx(5.0)
    point = np.full((3, 3), 2.0)
    assert distance(np.array([2.0, 5, 6]), point) == pytest.approx(5.0)
    assert distance(np.full(3, 2.0), point) == 0.0
    sliver = np.array([[0.0, 0, 0], [1.0, 1e-13, 0], [3.0, 0, 1e-14]])[take]
    assert distance(np.array([2.0, 3, 4]), sliver) == pytest.approx(5.0)


def test_segment_and_box() -> None:
    assert point_segment_squared(1.0, 2.0, 0.0, 3.0, 0.0, 0.0) == pytest.approx(4.0)
    assert point_segment_squared(-1.0, 2.0, 0.0, 3.0, 0.0, 0.0) == pytest.approx(5.0)
    assert point_segment_squared(1.0, 2.0, 2.0, 0.0, 0.0, 0.0) == pytest.approx(9.0)
    box = (0.0, 0.0, 0.0, 1.0, 2.0, 3.0)
    assert point_box_squared(0.5, 1.0, 3.0, *box) == 0.0
    assert point_box_squared(-2.0, 1.0, 5.0, *box) == pytest.approx(8.0)
    assert point_box_squared(2.0, 4.0, -2.0, *box) == pytest.approx(1 + 4 + 4)
