"""The comparison against a plain one, a count by hand, and what must hold."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.sweep.held_out_test import compare, difference


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.4])
def test_against_resamples_drawn_one_by_one(shift: float) -> None:
    rng = np.random.default_rng(5)
    left, right = rng.normal(shift, 0.3, 20), rng.normal(0.0, 0.4, 18)
    both = np.concatenate([left, right])
    found = difference(list(left), list(right))
    assert found.mean == pytest.approx(left.mean() - right.mean())
    again = [rng.choice(left, 20).mean() - rng.choice(right, 18).mean() for _ in range(4000)]
    assert (found.low, found.high) == pytest.approx(tuple(np.quantile(again, [0.025, 0.975])), abs=0.03)
    shuffled = [rng.permutation(both) for _ in range(20_000)]
    as_large = np.mean([abs(order[:20].mean() - order[20:].mean()) >= abs(found.mean) - 1e-12 for order in shuffled])
    assert found.p == pytest.approx(as_large, abs=0.02)
    assert difference(list(left), list(right)) == found


def test_a_small_exact_one() -> None:
    """Of the 20 ways to part six numbers two are as far apart as {4, 5, 6} and {1, 2, 3}: p = 0.1."""
    found = difference([4.0, 5.0, 6.0], [1.0, 2.0, 3.0])
    assert found.p == pytest.approx(0.1, abs=0.015)
    assert found.verdict == "no significant difference"


def test_equal_returns_are_no_difference() -> None:
    found = difference([-0.08] * 20, [-0.08] * 20)
    assert (found.mean, found.low, found.high, found.p) == pytest.approx((0, 0, 0, 1), abs=1e-12)


def test_what_is_worse_is_called_worse() -> None:
    summary = compare({"best": [-2.0 - i / 100 for i in range(20)], "defaults": [-1.0 - i / 100 for i in range(20)]})
    result = summary["differences"]["defaults"]
    assert result["verdict"] == "significantly worse"
    assert result["high"] < 0
    assert result["p"] < 0.001
    assert summary["settings"]["best"]["mean"] == pytest.approx(-2.095)
    assert summary["settings"]["best"]["n"] == 20
