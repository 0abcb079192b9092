"""Triangle intersection against rational arithmetic (design page, section 9, item 7)."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.geometry.triangles import CONTACT_TOLERANCE, triangles_cross
from tests import oracles

Pair = tuple[NDArray[np.int64], NDArray[np.int64]]


def _triangle(rng: np.random.Generator, size: int = 4) -> NDArray[np.int64]:
    while True:
        t = rng.integers(-size, size + 1, (3, 3))
        if np.cross(t[1] - t[0], t[2] - t[0]).any():
            return t


def pair_of_triangles(rng: np.random.Generator, kind: str) -> Pair:
    """A random pair of integer triangles in a given position to each other."""
    p, q = _triangle(rng), _triangle(rng)
    if kind == "shared vertex":
        q[0] = p[rng.integers(3)]
    elif kind == "shared edge":
        q[:2] = p[rng.permutation(3)[:2]]
    elif kind == "coplanar":
        u, v = p[1] - p[0], p[2] - p[0]
        q = p[0] + np.array([a * u + b * v for a, b in rng.integers(-2, 3, (3, 2))])
    elif kind == "vertex in plane":  # a corner of q in p's plane, often on the triangle itself
        p, q = 2 * p, 2 * q
        i, j = rng.permutation(3)[:2]
        q[0] = rng.choice([(p[i] + p[j]) // 2, (p[i] + p[j]) - p[3 - i - j]])
    elif kind == "edge in plane":
        p, q = 4 * p, 4 * q
        q[0], q[1] = (p[0] + p[1]) // 2, (p[0] + p[1] + 2 * p[2]) // 4
    elif kind == "crossing":  # q's side pierces p near its middle
        p = 3 * p
        step = rng.integers(-4, 5, 3)
        q[0], q[1] = p.sum(axis=0) // 3 + step, p.sum(axis=0) // 3 - step
    elif kind == "disjoint":
        q = q + np.array([0, 0, 12])
    return p, q


KINDS = (
    "any", "shared vertex", "shared edge", "coplanar", "vertex in plane", "edge in plane", "crossing", "disjoint",
)  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_equals_exact_arithmetic(kind: str) -> None:
    rng = np.random.default_rng(KINDS.index(kind))
    found = {False: 0, True: 0}
    for _ in range(400):
        p, q = pair_of_triangles(rng, kind)
        if not np.cross(q[1] - q[0], q[2] - q[0]).any():
            continue
        exact = oracles.triangles_cross(p.tolist(), q.tolist())
        found[exact] += 1
        # all orders of corners, both orders of triangles
        for order in permutations(range(3)):
            assert triangles_cross(1.0 * p[list(order)], 1.0 * q, CONTACT_TOLERANCE) == exact, (p, q)
            assert triangles_cross(1.0 * q, 1.0 * p[list(order)], CONTACT_TOLERANCE) == exact, (p, q)
        # rotated and moved: contact stays contact
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        shift = rng.normal(size=3)
        assert triangles_cross(p @ rotation + shift, q @ rotation + shift, CONTACT_TOLERANCE) == exact, (p, q)
    if kind in ("shared edge", "coplanar", "disjoint"):
        assert not found[True]
    elif kind in ("any", "crossing", "shared vertex"):
        assert min(found.values()) > 10


@pytest.mark.parametrize(("depth", "crosses"), [(0.0, False), (1e-10, False), (1e-8, True), (0.5, True)])
def test_penetration_within_the_tolerance_is_contact(depth: float, crosses: bool) -> None:
    floor = np.array([[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 2.0, 0.0]])
    spike = np.array([[-0.3, 0.0, 1.0], [0.3, 0.0, 1.0], [0.0, 0.0, -depth]])
    assert triangles_cross(floor, spike, CONTACT_TOLERANCE) == crosses
