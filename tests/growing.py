"""Random designs that grow: uniform play that never ends the episode and takes back what cannot be completed."""

from __future__ import annotations

from typing import Any

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.state import PLACEMENT, RUNNING, SELECTION, States
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start

GAMES: dict[str, tuple[int | tuple[int, int], str, Start, float | None]] = {
    "none": (9, "none", Square("choose"), None),
    "x": (9, "x", Square("choose"), None),
    "y": (13, "y", Square(2), 3.0),
    "xy": (13, "xy", Square("choose"), None),
    "xyd": (25, "xyd", Square("choose"), 2.9),
    "crease": (13, "none", Crease("choose"), None),
    "crease y": (13, "y", Crease("choose"), 4.0),
    "wide": ((13, 7), "xy", Square("choose"), None),
    "high": ((7, 11), "y", Crease("choose"), 4.0),
    "rectangle": ((11, 9), "none", Rectangle(), 4.0),
    "rectangle y": (11, "y", Rectangle(), None),
    "any crease": (9, "none", Crease(ends="choose"), 4.0),
    "panel": (11, "y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (1, 0, -1, 0, 1)), None),
    "boundary": (11, "none", Square("choose"), 4.0),
    "boundary y": (11, "y", Crease("choose"), None),
    "boundary xy": (9, "xy", Rectangle(), None),
    "bare": (11, "y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (0, 0, 1, 0, 0)), None),
}
"""Board, symmetry, start and maximum crease length: one game for each kind of boundary."""


def make(name: str) -> Game:
    board, symmetry, start, length = GAMES[name]
    sources = "boundary" if name.startswith("boundary") else True
    return on_board(board, symmetry, start, max_crease_length=length, source_action=sources)


def on_board(board: int | tuple[int, int], *rules: Any, **settings: Any) -> Game:
    """A game on a board of N×N points, or of so many along x and along y."""
    width, height = board if isinstance(board, tuple) else (board, board)
    # another size than the sides shall have no say
    size = board if isinstance(board, int) else 101
    sides = {} if isinstance(board, int) else {"board_width": width, "board_height": height}
    return Game(size, *rules, **sides, **settings)


def grown(game: Game, rng: np.random.Generator, moves: int) -> States:
    """A running state between two moves, after so many random ones (the placement among them) at most."""
    states, before = game.new_states(1), game.new_states(1)
    done = failed = 0
    while done < moves and failed < 200:
        copy_to(before, 0, states, 0)
        legal = game.legal(states)
        while True:
            choices = legal[legal != 3 * game.rules.points]
            placing = int(states["phase"][0]) == PLACEMENT
            if not len(choices):
                break
            legal = game.play(states, int(rng.choice(choices)))
            if (placing or int(states["phase"][0]) == SELECTION) and int(states["phase"][0]) != PLACEMENT:
                break
        if int(states["phase"][0]) == SELECTION and int(states["status"][0]) == RUNNING and len(choices):
            done += 1
        else:
            copy_to(states, 0, before, 0)
            failed += 1
    return states
