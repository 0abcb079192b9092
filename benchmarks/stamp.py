"""A random search that notes when it begins: how long a start-up takes is measured with it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from origami_lab.search.problem import Problem
from origami_lab.search.random_search import RandomSearch


class StampedSearch(RandomSearch):
    """Random search; writes the time after its first interaction to the file named by ORIGAMI_LAB_STAMP."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        first = problem.new_positions(1)
        problem.play(first, 0, int(problem.clear(first, 0)[0]))
        Path(os.environ["ORIGAMI_LAB_STAMP"]).write_text(repr(time.time()), encoding="utf-8")
        super().search(problem, rng)
