"""One place at a time: whether a child may lie there, and where it would be in space, without playing it."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game.kernels.boundary import NEXT, PREV, near_side
from origami_lab.game.kernels.extension import middle_place, outer_place
from origami_lab.game.kernels.legal_actions import location_is_legal
from origami_lab.game.kernels.play import leaf_at
from origami_lab.game.kernels.state import FIRST, NOT_FOLDABLE, SECOND, SELECTION, THIRD
from tests.growing import GAMES, grown, make


@pytest.mark.parametrize("name", GAMES)
def test_a_place_is_legal_if_it_is_in_the_list(name: str) -> None:
    game, rng = make(name), np.random.default_rng(0)
    seen = {FIRST: 0, SECOND: 0, THIRD: 0}
    for _ in range(12):
        states = grown(game, rng, int(rng.integers(1, 12)))
        legal = game.legal(states)
        legal = legal[legal < 2 * game.rules.points]
        while len(legal):
            game.play(states, int(rng.choice(legal)))
            legal = game.legal(states)
            phase = int(states["phase"][0])
            if phase == SELECTION:
                break
            columns, rows = (range(-half - 2, half + 3) for half in game.rules.half)
            found = {
                2 * game.rules.points + (y + game.rules.half[1]) * game.board[0] + x + game.rules.half[0]
                for y in rows
                for x in columns
                if location_is_legal(states[0], game.rules.record[0], x, y)
            }
            assert found == set(legal.tolist())
            seen[phase] += len(found)
    assert seen[FIRST] > 0
    assert seen[THIRD] > 0


@pytest.mark.parametrize("name", GAMES)
def test_a_place_is_known_before_it_is_played(name: str) -> None:
    """To the last bit, at every driving angle that the extension reaches."""
    game, rng = make(name), np.random.default_rng(1)
    completed = 0
    for _ in range(40):
        states = grown(game, rng, int(rng.integers(1, 8)))
        legal = game.legal(states)
        legal = legal[legal < 2 * game.rules.points]
        if not len(legal):
            continue
        legal, before = game.play(states, int(rng.choice(legal))), int(states["n_vertices"][0])
        r, expected = game.rules.record[0], {}
        while len(legal) and int(states["phase"][0]) != SELECTION:
            s, phase = states[0], int(states["phase"][0])
            on_axis = int(s["axis"][s["selected"]]) > 0
            side = NEXT if phase == SECOND or (on_axis and near_side(s, r, s["selected"]) == NEXT) else PREV
            action = int(rng.choice(legal))
            row, column = divmod(action - 2 * game.rules.points, game.board[0])
            x, y = column - game.rules.half[0], row - game.rules.half[1]
            reach = int(s["reach"])
            if phase == THIRD:
                expected[x, y] = [middle_place(s, r, k, x, y) for k in range(reach)]
            else:
                expected[x, y] = [(True, *outer_place(s, r, k, side, x, y)) for k in range(reach)]
            legal = game.play(states, action)
        if int(states["phase"][0]) != SELECTION or int(states["status"][0]) == NOT_FOLDABLE:
            continue
        for (x, y), places in expected.items():
            v = leaf_at(states[0], x, y)
            for k in range(int(states["reach"][0])):
                exists, *place = places[k]
                assert exists
                if v < before:  # a merge: the leaf was there before, and rounding may differ
                    assert np.allclose(place, states["position"][0][v, k], rtol=0, atol=1e-9)
                else:
                    assert place == states["position"][0][v, k].tolist()
        completed += 1
    assert completed > 5
