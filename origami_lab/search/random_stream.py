"""Random numbers for compiled code: drawn in blocks, because a Generator is costly to hand to a kernel."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import bare

BLOCK = 4096

Actions = NDArray[np.int32]
Source = Callable[[int], NDArray[np.float64]]


class Draws:
    """A stream of random numbers, reproducible from its generator: uniform in [0, 1), or what ``source(n)`` draws."""

    def __init__(self, rng: np.random.Generator, source: Source | None = None) -> None:
        self._source: Source = rng.random if source is None else source
        self.block = self._source(BLOCK)
        self.used = 0

    @property
    def available(self) -> int:
        """Numbers left in the block; at least one."""
        self.reserve(1)
        return len(self.block) - self.used

    def reserve(self, count: int) -> None:
        """See to it that the block has ``count`` numbers left."""
        if len(self.block) - self.used < count:
            rest = self.block[self.used :]
            self.block = np.concatenate([rest, self._source(max(BLOCK, count))])
            self.used = 0

    def one(self) -> float:
        """The next number."""
        self.reserve(1)
        self.used += 1
        return float(self.block[self.used - 1])

    def below(self, count: int) -> int:
        """A whole number from 0 to count − 1, from the next number of a uniform stream."""
        return int(self.one() * count)

    def use(self, count: int) -> None:
        """Mark numbers of the block as used."""
        self.used += count


@bare
def sample_distinct(pool: Actions, draws: NDArray[np.float64], start: int, chosen: Actions) -> None:
    """Fill ``chosen`` from the pool, without repetition; the pool is permuted."""
    n = pool.shape[0]
    for i in range(chosen.shape[0]):
        j = int(draws[start + i] * n)
        n -= 1
        chosen[i], pool[j] = pool[j], pool[n]
