"""Designs to be laid on a finer board: the known ones, and some that random play leaves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from origami_lab.game.game import Game
from origami_lab.game.kernels.state import NOT_FOLDABLE, SELECTION
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start
from tests.known_designs import game_moves as known

GROUPS: list[tuple[str, Start]] = [
    *((symmetry, Square("choose")) for symmetry in ("none", "x", "y", "xy", "xyd")),
    *((symmetry, Crease("choose")) for symmetry in ("none", "y")),
    ("y", Rectangle()),
    ("none", Square(1, (0, -1))),
    ("none", Crease(ends="choose", stays="lower")),
    ("y", Crease("choose", stays="lower")),
    ("xy", Panel(((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1)), (0, 0, -1, 0, 0, -1))),
]


def actions_of(game: Game, moves: object) -> tuple[int, ...]:
    return game.finished_actions(game.replay_moves(moves))  # type: ignore[arg-type]


def pyramid(**settings: object) -> tuple[Game, tuple[int, ...]]:
    game = Game(9, "xy", Square(1), **settings)  # type: ignore[arg-type]
    return game, actions_of(game, known.pyramid()[1])


def cube(**settings: object) -> tuple[Game, tuple[int, ...]]:
    game = Game(9, "xy", Square(1), **({"max_crease_length": 2} | settings))  # type: ignore[arg-type]
    return game, actions_of(game, known.cube()[1])


def random_designs(game: Game, count: int, seed: int) -> Iterator[tuple[int, ...]]:
    """Actions of designs with at least two extensions; what does not fold is taken back by playing it again."""
    rng = np.random.default_rng(seed)
    while count > 0:
        states = game.new_states(1)
        legal = game.legal(states)
        kept: tuple[int, ...] = ()
        while len(legal) and len(kept) < 40:
            on = [a for a in legal if a != 3 * game.rules.points]  # never the end
            if not on:
                break
            legal = game.play(states, int(rng.choice(on)))
            if int(states["status"][0]) == NOT_FOLDABLE:
                states = game.replay(kept)
                legal = game.legal(states)
                if rng.random() < 0.1:
                    break
            elif int(states["phase"][0]) == SELECTION:
                kept = game.finished_actions(states)
        if int(game.replay(kept)["n_extensions"][0]) >= 2:
            yield kept
            count -= 1
