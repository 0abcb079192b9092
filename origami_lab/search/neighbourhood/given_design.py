"""A search that goes on from a design that it has not found itself."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from origami_lab.game.edits import start_vertices
from origami_lab.game.game import Game
from origami_lab.game.move_table import table_of
from origami_lab.search.neighbourhood.method_numbers import MethodNumbers
from origami_lab.search.neighbourhood.one_run import LocalRun, RunDesign
from origami_lab.search.neighbourhood.saved_runs import run_arrays


def state_of_design(
    settings: MethodNumbers, game: Game, actions: Sequence[int], angle: int, value: float, budget: int
) -> Mapping[str, ArrayLike]:
    """What ``lns`` takes up (:meth:`~.search.NeighbourhoodSearch.load`) to change this design first.

    One run stands at it, with its distance as threshold and nothing left uncovered; it goes on until it finds nothing
    more, and the rounds after it have fresh runs of full length.

    Parameters
    ----------
    actions
        The design in the same game, with an extension at least.
    angle, value
        Index of its best driving angle, and its return there.
    budget
        Interactions that the search has.
    """
    states = game.replay(actions)
    moves, points = table_of(states, game.rules.record, game.new_states(1))
    places = states["position"][0][: len(points), angle].copy()
    own = start_vertices(game, actions)
    design = RunDesign(moves, points, places, own, np.empty(0, dtype=np.int32))
    run = LocalRun(angle, threshold=max(-value, 0.0), design=design, value=value, accepted=deque([value]))
    found: dict[str, ArrayLike] = {
        "length": float(max(settings.first_run, round(settings.run * budget))),
        "factor": settings.threshold,
        "best_angles": np.array([angle], dtype=np.int64),
    }
    return found | {f"0.{name}": array for name, array in run_arrays(run)}
