"""A searcher that can be caught in the middle of a trial: named by ``_target_`` in conf/search/napper.yaml."""

from __future__ import annotations

import os
import time

import numpy as np

from origami_lab.search.problem import Problem
from origami_lab.search.random_search import RandomSearch


class Napper(RandomSearch):
    """Sleeps NAP seconds (of its environment: they change nothing that it finds), then plays at random.

    Parameters
    ----------
    skip
        So many random numbers are thrown away first.
    """

    def __init__(self, skip: int = 0) -> None:
        super().__init__()
        self.skip = skip

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        end = time.monotonic() + float(os.environ.get("NAP", "0"))
        while time.monotonic() < end and not problem.done:
            time.sleep(0.05)
        rng.random(self.skip)
        super().search(problem, rng)
