"""Triangles against rational arithmetic, on 10,000 pairs in every position to each other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from origami_lab.verification.triangle_separation import crossing_depth, overlap_in_plane, separating, separating_cones
from tests import oracles
from tests.geometry.test_triangles import KINDS, pair_of_triangles

EACH = 1250
"""Pairs of each of the eight kinds."""


@pytest.fixture(scope="module", params=KINDS)
def sample(request: pytest.FixtureRequest) -> tuple[str, NDArray[np.int64], NDArray[np.int64]]:
    rng = np.random.default_rng(KINDS.index(request.param))
    pairs: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    while len(pairs) < EACH:
        p, q = pair_of_triangles(rng, request.param)
        if np.cross(q[1] - q[0], q[2] - q[0]).any():
            pairs.append((p, q))
    return request.param, np.array([p for p, _ in pairs]), np.array([q for _, q in pairs])


def moved(rng: np.random.Generator, p: NDArray[np.int64], q: NDArray[np.int64]) -> tuple[NDArray, NDArray]:
    """The pairs turned and shifted, each in its own way, its corners in another order."""
    turn, _ = np.linalg.qr(rng.normal(size=(len(p), 3, 3)))
    shift = rng.normal(size=(len(p), 1, 3))
    order = rng.permutation(3)
    return p[:, order] @ turn + shift, q @ turn + shift


def test_crossing_equals_exact_arithmetic(sample: tuple[str, NDArray[np.int64], NDArray[np.int64]]) -> None:
    kind, p, q = sample
    exact = np.array([oracles.triangles_cross(a.tolist(), b.tolist()) for a, b in zip(p, q, strict=True)])
    rng = np.random.default_rng(7)
    for a, b in ((1.0 * p, 1.0 * q), (1.0 * q, 1.0 * p), moved(rng, p, q)):
        depth = crossing_depth(a, b)
        np.testing.assert_array_equal(depth > 1e-9, exact)
        assert np.all(depth[exact] > 1e-3)  # integers: no doubtful cases
        assert np.all(depth[~exact] < 1e-13)
    if kind in ("shared edge", "coplanar", "disjoint", "edge in plane"):
        assert not exact.any()
    else:
        assert min(exact.sum(), (~exact).sum()) > 20


def test_distance_is_the_distance(sample: tuple[str, NDArray[np.int64], NDArray[np.int64]]) -> None:
    _, p, q = sample
    found, direction = separating(1.0 * p, 1.0 * q)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0)
    for at in range(0, EACH, 250):
        assert max(found[at], 0.0) == pytest.approx(minimal_distance(1.0 * p[at], 1.0 * q[at]), abs=2e-4)


def minimal_distance(p: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """By minimising over barycentric coordinates."""

    def squared(x: NDArray[np.float64]) -> float:
        a, b = np.append(x[:2], 1 - x[:2].sum()), np.append(x[2:], 1 - x[2:].sum())
        return float(np.sum((a @ p - b @ q) ** 2))

    bounds = {"type": "ineq", "fun": lambda x: np.array([*x, 1 - x[0] - x[1], 1 - x[2] - x[3]])}
    return float(np.sqrt(max(minimize(squared, [1 / 3] * 4, constraints=[bounds], tol=1e-14).fun, 0.0)))


def test_overlap_in_plane() -> None:
    p = np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]] * 5)
    q = np.array([p[0] + shift for shift in ([0.5, 0.5, 0], [2, 0, 0], [1, 1, 0], [0.5, 0.5, 1e-3], [3, 0, 0])])
    assert overlap_in_plane(p, q, 1e-9).tolist() == [True, False, False, False, False]


def test_cones_are_parted_by_the_best_plane() -> None:
    rng = np.random.default_rng(3)
    p, q = rng.normal(size=(300, 2, 3)), rng.normal(size=(300, 2, 3))
    gap, normal = separating_cones(p, q)
    unit = np.concatenate([p / np.linalg.norm(p, axis=2)[..., None], -q / np.linalg.norm(q, axis=2)[..., None]], axis=1)
    np.testing.assert_allclose(np.einsum("nkj,nj->nk", unit, normal).min(axis=1), gap, atol=1e-12)
    tries = rng.normal(size=(20_000, 3))
    tries /= np.linalg.norm(tries, axis=1, keepdims=True)
    best = np.array([(tries @ sides.T).min(axis=1).max() for sides in unit])
    assert np.all(best <= gap + 1e-12)
    positive = gap > 0.05
    assert positive.sum() > 50
    assert (~positive).sum() > 50
    assert np.all(gap[positive] - best[positive] < 0.03)  # the tries are that dense
