"""Checking an incumbent's folding motion densely, between the ten angles that decide during the search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import replay_unchecked
from origami_lab.game.kernels.state import States

SUB_STEPS = 10
"""Checked steps between two driving angles (the last one is the upper angle itself)."""


def certified_reach(
    game: Game, actions: Sequence[int], reach: int, sub_steps: int = SUB_STEPS, scratch: States | None = None
) -> int:
    """How many of a design's first ``reach`` driving angles can be reached through a motion without collisions.

    Every one of ``sub_steps`` equal steps between neighbouring driving angles, and from the flat state to the first, is
    checked for the spherical triangle inequality and for collisions.

    Parameters
    ----------
    actions
        Legal actions of the design, without an unfinished extension.
    scratch
        One state of the game to work in.
    """
    count = len(game.angles)
    edges = np.concatenate([[0.0], game.angles[:reach]])
    steps = np.arange(1, sub_steps + 1) / sub_steps
    fine = (edges[:-1, None] + steps * np.diff(edges)[:, None]).ravel()
    fine[sub_steps - 1 :: sub_steps] = game.angles[:reach]
    rules = game.rules.record.copy()
    states = scratch if scratch is not None else game.new_states(1)
    rules["min_reach"] = 1
    log = np.array(actions, dtype=np.int32)
    for start in range(0, len(fine), count):
        chunk = fine[start : start + count]
        rules["angles"][0] = np.concatenate([chunk, np.full(count - len(chunk), chunk[-1])])
        free = int(replay_unchecked(states, 0, rules, log))
        if free < len(chunk):
            return (start + free) // sub_steps
    return reach
