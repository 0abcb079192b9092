"""The searcher that a design of the studio's names: a person, who cannot be run again."""

from __future__ import annotations

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.search.problem import Problem

METHOD = "studio"
_TARGET = "origami_lab.studio.DesignedByHand"
NODE = {"_target_": _TARGET}
"""What the configuration of a saved design has as its searcher."""


class DesignedByHand:
    """Stands in a run's configuration for whoever designed it in the studio, and refuses to be run."""

    def check_game(self, game: Game) -> None:
        """Refuse a run or its resumption before anything begins; raises InputError."""
        raise InputError("search", METHOD, "a design made by hand cannot be run again: origami-lab studio DIR opens it")

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        """Refuse to be run; raises InputError."""
        self.check_game(problem.game)
