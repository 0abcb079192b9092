"""The best of a sweep beside the defaults, on seeds that no trial played: is the difference more than luck?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.reporting.tables import Spread, spread_of

RESAMPLES = 10_000
CONFIDENCE = 0.95
METHOD = (
    "the difference of the mean returns, its 95 % interval from 10,000 bootstrap resamples of the seeds (percentiles), "
    "and the two-sided p-value of a permutation test of it (10,000 permutations)"
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
        """What it says, in a word."""
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
    left, right = np.asarray(best, dtype=np.float64), np.asarray(other, dtype=np.float64)
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    observed = float(left.mean() - right.mean())
    resampled = _means(left, rng) - _means(right, rng)
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(resampled, [tail, 1 - tail])
    return Difference(observed, float(low), float(high), _p_value(left, right, observed, rng))


def _means(values: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Means of resamples with replacement."""
    chosen = rng.integers(0, len(values), (RESAMPLES, len(values)))
    return np.asarray(values[chosen].mean(axis=1))


def _p_value(left: NDArray[np.float64], right: NDArray[np.float64], observed: float, rng: np.random.Generator) -> float:
    """The part of the permutations with a difference as large; the observed order is one of them."""
    together = np.concatenate([left, right])
    shuffled = rng.permuted(np.tile(together, (RESAMPLES, 1)), axis=1)
    differences = shuffled[:, : len(left)].mean(axis=1) - shuffled[:, len(left) :].mean(axis=1)
    # equal ones may differ in their last bits
    as_large = np.count_nonzero(np.abs(differences) >= abs(observed) - 1e-12)
    return float((as_large + 1) / (RESAMPLES + 1))


def compare(returns: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    """What the summary says of the settings compared.

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


def spread_text(values: Sequence[float]) -> str:
    """Mean ± std."""
    spread: Spread | None = spread_of(values)
    return "–" if spread is None else str(spread)
