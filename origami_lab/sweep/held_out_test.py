"""The best of a sweep beside the defaults, on seeds that no trial played: is the difference more than luck?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.runs.trial_row import spread_of

FEW_SEEDS = 10
"""Held-out seeds below which a comparison comes with a warning."""
RESAMPLES = 10_000
CONFIDENCE = 0.95
METHOD = (
    "the difference of the mean returns, its 95 % interval from 10,000 bootstrap resamples of the seeds (percentiles), "
    "and the two-sided p-value of a permutation test of it (10,000 permutations), each by itself: not corrected for "
    "several comparisons"
)


@dataclass(frozen=True)
class Difference:
    """How much better the best is than other settings, in the mean return on the held-out seeds."""

    mean: float
    low: float
    high: float
    """The 95 % confidence interval."""
    p: float
    """Probability of a difference at least as large, either way, if both settings were the same."""

    @property
    def verdict(self) -> str:
        """The outcome of the test in a word."""
        if self.p >= 1 - CONFIDENCE:
            return "no significant difference"
        return "significantly better" if self.mean > 0 else "significantly worse"


def difference(best: Sequence[float], other: Sequence[float], seed: int = 0) -> Difference:
    """Compare the returns of two settings; the seeds are no pairs, as two searches share nothing but a number.

    Parameters
    ----------
    best, other
        One return a seed, at least two each.
    seed
        Of the resamples.
    """
    from scipy import stats

    samples = np.asarray(best, dtype=np.float64), np.asarray(other, dtype=np.float64)
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    interval = stats.bootstrap(
        samples, _of_means, n_resamples=RESAMPLES, confidence_level=CONFIDENCE, method="percentile", rng=rng
    ).confidence_interval
    test = stats.permutation_test(samples, _of_means, vectorized=True, n_resamples=RESAMPLES, rng=rng)
    return Difference(float(test.statistic), float(interval.low), float(interval.high), float(test.pvalue))


def _of_means(left: NDArray[np.float64], right: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    return np.asarray(left.mean(axis=axis) - right.mean(axis=axis))


def compare(returns: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """The entry of the summary for the settings compared.

    Parameters
    ----------
    returns
        The return of each held-out seed by the name of the settings; ``best`` is compared with each other one.
    """
    found: dict[str, Any] = {"settings": {}, "differences": {}, "method": METHOD}
    for name, values in returns.items():
        spread = spread_of(values)
        if spread is not None:
            found["settings"][name] = asdict(spread) | {"median": float(np.median(values)), "returns": list(values)}
    for name, values in returns.items():
        if name != "best" and len(values) > 1 and len(returns.get("best", ())) > 1:
            result = difference(returns["best"], values)
            found["differences"][name] = asdict(result) | {"verdict": result.verdict}
    return found
