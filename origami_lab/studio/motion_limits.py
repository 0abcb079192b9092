"""How far a design's motion goes, between the game's driving angles too, and what ends it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import replay_unchecked
from origami_lab.game.start_laying import largest_angle

End = Literal["collides", "closes", "whole"]


def motion_end(game: Game, actions: Sequence[int]) -> tuple[float, End]:
    """The largest driving angle, in tenths of a degree, up to which a design folds without collisions, and its end.

    ``collides`` if panels meet then, ``closes`` if a vertex no longer closes, ``whole`` if nothing ends it before the
    game's own largest angle.
    """
    most = math.degrees(float(game.angles[-1]))
    free = min(largest_angle(game.rules, game.replay(actions)), most)
    if free > most - 0.1:
        return most, "whole"
    record, states = (
        game.rules.for_start_pattern(shortest_motion=True).replaced(collisions=0).record,
        game.new_states(1),
    )
    record["angles"][0] = math.radians(free + 0.1)
    closes = int(replay_unchecked(states, 0, record, np.array(actions, dtype=np.int32))) > 0
    return free, "collides" if closes else "closes"
