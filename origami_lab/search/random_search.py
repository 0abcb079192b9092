"""RDM (paper, appendix A.1): uniformly random play, episode after episode."""

from __future__ import annotations

import numpy as np

from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws


class RandomSearch:
    """Samples every action uniformly from the legal ones."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        draws = Draws(rng)
        positions = problem.new_positions(1)
        while not problem.done:
            problem.clear(positions, 0)
            if problem.play_uniform(positions, 0, draws):
                problem.finish(positions, 0)
