"""Planes over intervals: what they show is true all along, whichever was tried first."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.verification.interval_planes import IntervalPlanes
from origami_lab.verification.panel_pairs import Neighbourhood, Pairs
from tests.verification.test_loop_closure import LARGE, folded

INTERVALS = [(12.0, 14.0), (14.0, 17.0), (17.0, 20.0), (20.0, 23.0)]
"""Degrees of driving angle."""


def pairs_of(near: Neighbourhood, name: str) -> list[Pairs]:
    """The pairs that share a vertex, and those that do not: all, or of a large design the near ones."""
    low = near.linkage.flat[near.sheet.triangles].min(axis=1)
    high = near.linkage.flat[near.sheet.triangles].max(axis=1)
    wider = 0.6 if name == LARGE else near.sheet.size
    return [near.neighbours, near.close(low - wider, high + wider)]


@pytest.mark.parametrize("name", ["miura", "pyramid", "cube", LARGE])
def test_gaps_hold_all_along(name: str) -> None:
    motion, rho, driving = folded(name)
    near, here = Neighbourhood(motion.linkage, motion.held), motion.solve(driving, rho)
    kept, kept_turned = IntervalPlanes(near), IntervalPlanes(near)
    for low, high in np.radians(INTERVALS[::-1]):
        b = motion.walk(here, high, 1000)[-1]
        m, a = (motion.walk(b, at, 1000)[-1] for at in ((low + high) / 2.0, low))
        between = [motion.walk(b, low + share * (high - low), 1000)[-1] for share in (0.1, 0.3, 0.7, 0.9)]
        for pairs in pairs_of(near, name):
            if not len(pairs):
                continue
            fresh, apart = IntervalPlanes(near).parted(pairs, a, m, b)
            gap, some = kept.parted(pairs, a, m, b, np.zeros(len(pairs)))
            turned = kept_turned.parted(pairs.turned(), a, m, b, np.zeros(len(pairs)))[0]
            # what was found at once is a lower bound, and where it is not enough it is what a fresh look finds
            np.testing.assert_array_equal(gap > 0.0, fresh > 0.0)
            np.testing.assert_allclose(apart[np.isfinite(some)], some[np.isfinite(some)])
            assert np.isfinite(some).all(axis=1)[gap <= 0.0].all()
            for state in (a, m, b, *between):
                true = near.gap(pairs, state)
                for shown in (gap, fresh, turned):
                    # cones: both sides' distances from the plane are added up
                    assert np.all(true[shown > 0.0] > 0.0) if pairs.hinged else np.all(shown <= true + 1e-12)


def test_what_counts_as_far_enough_is_so_at_every_state() -> None:
    motion, rho, driving = folded(LARGE)
    near, b = Neighbourhood(motion.linkage, motion.held), motion.solve(driving, rho)
    m, a = (motion.walk(b, at, 1000)[-1] for at in (driving - 0.03, driving - 0.06))
    shares = []
    for pairs in pairs_of(near, LARGE):
        true = np.array([near.gap(pairs, state) for state in (a, m, b)])
        for wanted in (0.2, 0.03, 1e-6):
            planes = IntervalPlanes(near)
            for _ in range(2):
                apart = planes.parted(pairs, a, m, b, np.full(len(pairs), wanted))[1]
                assert np.all(true[:, np.isinf(apart[:, 0])] > wanted)
                np.testing.assert_array_equal(np.isinf(apart).any(axis=1), np.isinf(apart).all(axis=1))
                shares.append(np.isinf(apart[:, 0]).mean())
    assert 0.0 < np.mean(shares) < 1.0


def test_a_plane_that_parted_a_pair_mostly_does_so_again() -> None:
    motion, rho, driving = folded(LARGE)
    near, here = Neighbourhood(motion.linkage, motion.held), motion.solve(driving, rho)
    planes = IntervalPlanes(near)
    looked = []
    for low, high in np.radians(INTERVALS[::-1]):
        b = motion.walk(here, high, 1000)[-1]
        m, a = (motion.walk(b, at, 1000)[-1] for at in ((low + high) / 2.0, low))
        pairs = near.neighbours
        apart = planes.parted(pairs, a, m, b, np.zeros(len(pairs)))[1]
        looked.append(np.isfinite(apart).all(axis=1).mean())
    assert looked[0] > max(looked[1:])
    assert max(looked[1:]) < 0.2
