"""Random numbers for compiled code: drawn in blocks, because a Generator is costly to hand to a kernel."""

from __future__ import annotations

import numpy as np

BLOCK = 4096


class Draws:
    """A stream of uniform random numbers in [0, 1), reproducible from its generator."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.block = rng.random(BLOCK)
        self.used = 0

    @property
    def available(self) -> int:
        """Numbers left in the block; at least one."""
        if self.used >= BLOCK:
            self.block = self._rng.random(BLOCK)
            self.used = 0
        return BLOCK - self.used

    def use(self, count: int) -> None:
        """Mark numbers of the block as used."""
        self.used += count

    def below(self, n: int) -> int:
        """A random whole number in [0, n)."""
        if self.used >= BLOCK:
            self.block = self._rng.random(BLOCK)
            self.used = 0
        self.used += 1
        return int(self.block[self.used - 1] * n)
