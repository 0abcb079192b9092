"""The known designs of :mod:`tests.known_designs.game_moves` with the settings of their games to vary."""

from __future__ import annotations

from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from tests.known_designs import game_moves as known

PYRAMID = known.pyramid()[1]
CUBE = known.cube()[1]
CHAIR = known.chair(collisions=True)[1]


def pyramid_game(**settings: object) -> Game:
    return Game(9, "xy", Square(1), **settings)  # type: ignore[arg-type]


def cube_game(**settings: object) -> Game:
    return Game(9, "xy", Square(1), max_crease_length=2, **settings)  # type: ignore[arg-type]


def chair_game(**settings: object) -> Game:
    return Game(13, "y", Square(2), source_action=False, **settings)  # type: ignore[arg-type]
