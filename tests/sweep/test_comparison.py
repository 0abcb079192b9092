"""The comparison against scipy's, and against what must hold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from origami_lab.sweep.comparison import compare, difference


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.4])
def test_against_scipy(shift: float) -> None:
    rng = np.random.default_rng(5)
    left, right = rng.normal(shift, 0.3, 20), rng.normal(0.0, 0.4, 18)

    def statistic(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.mean(a) - np.mean(b))

    found = difference(list(left), list(right))
    expected = stats.permutation_test((left, right), statistic, n_resamples=20_000, rng=np.random.default_rng(1))
    assert found.mean == pytest.approx(left.mean() - right.mean())
    assert found.p == pytest.approx(expected.pvalue, abs=0.02)
    bootstrap = stats.bootstrap(
        (left, right), statistic, vectorized=False, method="percentile", n_resamples=4000, rng=np.random.default_rng(2)
    ).confidence_interval
    assert (found.low, found.high) == pytest.approx((bootstrap.low, bootstrap.high), abs=0.03)
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
