"""What is known of places against brute force: whatever was asked before, and wherever the search for it began."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, build_bvh
from origami_lab.geometry.wide_tree import MOST_LEVELS, WIDTH, build_wide_tree
from origami_lab.objectives.known_places import Surface, nothing_known, slot_of, strayed_squared
from tests.geometry.test_bvh import brute, random_triangles

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BOX = CORNERS[[corners for a, b, c, d in SQUARES for corners in ((a, b, c), (a, c, d))]]
"""The cube from −1 to 1 in twelve triangles."""


def surface(bvh: Bvh, solid: bool) -> Surface:
    return Surface(build_wide_tree(bvh), bvh, solid, False, 0.0, nothing_known())


def asked(target: Surface, place: NDArray[np.float64], enough_sq: float, start_sq: float, near: int) -> float:
    far = np.empty((MOST_LEVELS, WIDTH))
    return float(strayed_squared(target, *place, enough_sq, start_sq, near, far)[0])


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10**6),
    st.sampled_from(["solid", "triangles", "points"]),
    st.lists(st.tuples(st.integers(0, 5), st.floats(0, 2), st.floats(0, 2)), min_size=1, max_size=40),
)
def test_every_answer_is_that_of_brute_force(seed: int, kind: str, queries: list[tuple[int, float, float]]) -> None:
    rng = np.random.default_rng(seed)
    triangles = BOX if kind == "solid" else random_triangles(seed, 1 + seed % 40, 0.0 if kind == "points" else 0.5)
    bvh, places = build_bvh(triangles), rng.normal(size=(6, 3))
    target = surface(bvh, kind == "solid")
    for i, low, high in queries:
        place = places[i]
        truth = float(brute(triangles, place).min())
        if kind == "solid" and np.abs(place).max() < 1.0:
            truth = 0.0
        # as a search asks: more than one bound is known to be, and less than another one
        enough_sq, start_sq = truth * min(low, high), (truth + 0.1) * max(low, high, 1e-3)
        start_sq = np.inf if high > 1.9 else max(start_sq, enough_sq)
        found = asked(target, place, enough_sq, start_sq, int(rng.integers(len(triangles))))
        if found <= enough_sq:
            assert truth <= enough_sq * (1 + 1e-12)
        elif found < start_sq:
            assert found == pytest.approx(truth, rel=1e-12)
            assert found == asked(surface(bvh, kind == "solid"), place, 0.0, np.inf, 0)  # to the last bit
        else:
            assert found == start_sq
            assert truth >= start_sq * (1 - 1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_place_that_takes_the_slot_of_another_is_measured_anew(axis: int) -> None:
    """Also where they differ in one coordinate only."""
    bvh = build_bvh(random_triangles(1, 5, 0.5))
    target = surface(bvh, False)
    places = np.tile([0.3, -0.4, 0.5], (2000, 1))
    places[:, axis] = np.random.default_rng(0).normal(size=2000)
    by_slot: dict[int, list[int]] = {}
    for i, place in enumerate(places):
        by_slot.setdefault(slot_of(*place), []).append(i)
    crowded = [each for each in by_slot.values() if len(each) > 1]
    assert len(crowded) > 20
    for first, second, *_ in crowded[:100]:
        for i in (first, second, first):
            truth = brute(bvh.triangles, places[i]).min()
            assert asked(target, places[i], 0.0, np.inf, 0) == pytest.approx(truth, rel=1e-12)


def test_images_of_a_place_have_slots_of_their_own() -> None:
    shared = 0
    for x, y, z in np.random.default_rng(0).normal(size=(500, 3)):
        images = [(a * p, b * q, z) for a in (-1, 1) for b in (-1, 1) for p, q in ((x, y), (y, x))]
        shared += 8 - len({slot_of(*image) for image in images})
    assert shared < 40


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_place_strays_by_all_that_is_asked(bad: float) -> None:
    target = surface(build_bvh(BOX), True)
    for _ in range(2):
        assert asked(target, np.array([0.0, bad, 2.0]), 1.0, 4.0, 0) == 4.0
        assert asked(target, np.array([0.0, 0.0, 3.0]), 1.0, 9.0, 0) == 4.0


def test_two_searches_share_nothing() -> None:
    bvh = build_bvh(BOX)
    one, other = surface(bvh, False), surface(bvh, False)
    asked(one, np.array([0.0, 0.0, 3.0]), 0.0, np.inf, 0)
    assert np.isfinite(one.known).any()
    assert not np.isfinite(other.known).any()
