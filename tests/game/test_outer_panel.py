"""An outer panel that collides before its extension is complete, against extensions that are completed."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.kernels.outer_panel import outer_panel_collides
from origami_lab.game.kernels.play import copy_to, legal_of, step
from origami_lab.game.kernels.state import FIRST, NOT_FOLDABLE, RUNNING, SECOND, SELECTION, States
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.jit import kernel

GAMES = {
    "no mirrors": lambda: Game(13, "none", Square(1), max_crease_length=2.9),
    "one mirror": lambda: Game(13, "y", Crease(0), max_crease_length=2.9),
    "two mirrors": lambda: Game(13, "xy", Square(1), max_crease_length=2.9),
    "all mirrors": lambda: Game(13, "xyd", Square(1), max_crease_length=2.9),
}


@kernel
def collides(states: States, rules: States, reach: int, qx: int, qy: int) -> bool:
    return outer_panel_collides(states[0], rules[0], reach, qx, qy)


@pytest.mark.parametrize("name", GAMES)
def test_no_extension_folds_whose_outer_panel_collides(name: str) -> None:
    """Whatever the other children are; and the question leaves the state as it was."""
    game = GAMES[name]()
    (half_x, half_y), rng = game.rules.half, np.random.default_rng(1)
    size = 2 * half_x + 1
    rules = game.rules.record.copy()
    colliding = free = folding = 0
    states, before, trial = game.new_states(1), game.new_states(1), game.new_states(1)
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    for _ in range(150):
        game.clear(states, 0)
        for _ in range(int(rng.integers(40, 160))):
            n = legal_of(states, 0, rules, legal)
            choices = legal[:n][legal[:n] != 3 * game.rules.points]
            if not len(choices) or int(states["status"][0]) != RUNNING:
                break
            action = int(rng.choice(choices))
            if int(states["phase"][0]) in (FIRST, SECOND):
                index = action - 2 * game.rules.points
                point = index % size - half_x, index // size - half_y
                reach = max(rng.integers(1, int(states["reach"][0]) + 1, 2).tolist())
                copy_to(before, 0, states, 0)
                found = collides(states, rules, reach, *point)
                assert all(
                    np.array_equal(before[field], states[field]) for field in ("n_vertices", "n_triangles", "phase")
                )
                ends = completions(game, states, trial, action, reach, rng)
                if found:
                    colliding += 1
                    assert not any(ends)
                else:
                    free += 1
                    folding += any(ends)
            copy_to(before, 0, states, 0)
            step(states, 0, rules, action, legal)
            if int(states["status"][0]) == NOT_FOLDABLE:
                copy_to(states, 0, before, 0)
    assert colliding > 0
    assert free > folding > 5


def completions(
    game: Game, states: States, trial: States, action: int, reach: int, rng: np.random.Generator
) -> list[bool]:
    """Whether extensions that begin with an action fold to an angle, for a few random choices of the rest."""
    rules = game.rules.replaced(min_reach=reach).record
    legal, ends = np.empty(game.rules.max_legal, dtype=np.int32), []
    for _ in range(6):
        copy_to(trial, 0, states, 0)
        n = step(trial, 0, rules, action, legal)
        while n > 0 and int(trial["phase"][0]) != SELECTION:
            n = step(trial, 0, rules, int(rng.choice(legal[:n])), legal)
        if int(trial["phase"][0]) == SELECTION:
            ends.append(int(trial["status"][0]) != NOT_FOLDABLE)
    return ends
