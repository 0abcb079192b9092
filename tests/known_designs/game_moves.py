"""The known designs of the literature and of our own, as games and moves."""

from __future__ import annotations

import math

from origami_lab.game.game import Game
from origami_lab.game.moves import Extend, Move, Place, Source, Terminate
from origami_lab.game.start_patterns import Square


def pyramid() -> tuple[Game, list[Move]]:
    """Four flaps of height 3 that meet at the apex √8."""
    game = Game(9, "xy", Square(1))
    return game, [Place(1, 1), Extend((-1, 1), -1, (0, 4), (-4, 0), (-2, 2)), Terminate()]


def cube() -> tuple[Game, list[Move]]:
    """A cube with a lid in two halves: it has a merge and a source in it."""
    game = Game(9, "xy", Square(1), max_crease_length=2)
    return game, [
        Place(1, 1),
        Extend((-1, 1), -1, (-1, 3), (-3, 1), (-2, 2)),
        Source((-3, 1), "end", 1),
        Extend((-3, 1), -1, (-2, 2), (-4, 1), (-3, 2)),
        Terminate(),
    ]


def chair(*, collisions: bool, largest: float = 3.14) -> tuple[Game, list[Move]]:
    """The authors' published chair, mirrored in z; its panels reach the seat shortly before 90°."""
    game = Game(
        13,
        "y",
        Square(2),
        source_action=False,
        collisions=collisions,
        driving_angle_max=math.degrees(largest),
    )
    return game, [
        Place(2, -1),
        Extend((-2, -2), 1, (-3, 1), (0, -3), (-5, -4)),
        Extend((0, -3), 1, (-4, -6), (4, -6), (0, -4)),
        Extend((-2, 2), -1, (-4, 4), (-5, 2), (-6, 3)),
        Extend((-5, 2), 1, (-6, 3), (-6, -2), (-6, 2)),
        Terminate(),
    ]
