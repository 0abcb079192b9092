"""Driven creases laid during the game on any boundary segment that has none."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import play_uniform
from origami_lab.game.moves import Extend, Lay, Place, Source
from origami_lab.game.start_from_moves import FromMoves
from origami_lab.game.start_patterns import Panel, Square

SQUARE = ((2, 2), (-2, 2), (-2, -2), (2, -2))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_side_that_gets_a_source_is_a_driven_side(sign: int) -> None:
    """The same creases, in the start pattern or laid one after the other, fold to the same shape."""
    given = Game(13, "none", Panel(SQUARE, (1, sign, 0, 0)))
    game = Game(13, "none", Panel(SQUARE, (1, 0, 0, 0)), source_action="boundary")
    laid = [Lay(SQUARE, (1, 0, 0, 0), 1), Source((-2, 2), "next", sign)]
    rng, compared = np.random.default_rng(0), 0
    for _ in range(60):
        whole = given.replay_moves([Lay(SQUARE, (1, sign, 0, 0), 1)])
        legal = given.legal(whole)
        while len(legal := legal[legal != 3 * given.rules.points]) and int(whole["n_extensions"][0]) < 3:
            legal = given.play(whole, int(rng.choice(legal)))
        _, *grown = given.moves(given.finished_actions(whole))
        states = game.replay_moves([*laid, *grown])
        assert game.moves(game.finished_actions(states)) == [*laid, *grown]
        assert np.array_equal(game.sheet(states).points, given.sheet(whole).points)
        assert game.sheet(states).creases == given.sheet(whole).creases
        compared += len(grown)
    assert compared > 40


def test_one_that_is_never_extended_is_a_plain_boundary_edge() -> None:
    game = Game(13, "y", Square(2), source_action="boundary")
    extension = Extend((-2, 2), 1, (-1, 5), (-5, 1), (-4, 4))
    without = game.design(game.finished_actions(game.replay_moves([Place(2, 1), extension])))
    # (-4, 4) is the middle child, (-5, 1) comes after it
    moves = [Place(2, 1), extension, Source((-4, 4), "next", -1)]
    design = game.design(game.finished_actions(game.replay_moves(moves)))
    for name in ("vertices", "edges", "boundary", "driven", "fold_angles", "folded"):
        assert np.array_equal(getattr(design, name), getattr(without, name)), name


def test_both_ends_lose_it_when_it_is_cut_off() -> None:
    game = Game(13, "none", Square(2), source_action="boundary")
    first = Extend((-2, 2), 1, (-1, 5), (-5, 1), (-4, 4))
    states = game.replay_moves([Place(2, 1), first, Source((-4, 4), "next", 1)])
    legal = game.legal(states)
    leaves = {(int(a) % 13 - 6, int(a) // 13 - 6) for a in legal if a < game.rules.points}
    assert {(-4, 4), (-5, 1)} <= leaves
    rng = np.random.default_rng(0)
    for leaf in ((-4, 4), (-5, 1)):
        for _ in range(200):
            trial = states.copy()
            mode = int(rng.integers(2))
            legal = game.play(trial, (leaf[1] + 6) * 13 + leaf[0] + 6 + mode * game.rules.points)
            while len(legal) and int(trial["unfinished"][0]):
                legal = game.play(trial, int(rng.choice(legal)))
            if int(trial["n_extensions"][0]) == 2:
                break
        moves = tuple(game.moves(game.finished_actions(trial)))
        assert len(moves) == 4
        # with the extension that made its ends the source goes, and what was extended by it
        less = Game(13, "none", FromMoves(moves, remove=((-2, 2),)), source_action="boundary")
        assert less.start_moves == moves[:1]


def test_actions_of_old_games_mean_what_they_meant() -> None:
    old, new = (Game(9, "y", Square("choose"), source_action=sources) for sources in ("axis", "boundary"))
    assert new.rules.n_actions == old.rules.n_actions + 2
    assert Game(9, "y", Square("choose"), source_action=True).rules.record["sources"][0] == 1
    states, legal = old.new_states(60), np.empty(old.rules.max_legal, dtype=np.int32)
    rng, sources = np.random.default_rng(1), 0
    for i in range(len(states)):
        play_uniform(states, i, old.rules.record, rng.random(500), 0, 500, legal)
        actions = old.finished_actions(states, i)
        again = new.replay(actions)
        assert np.array_equal(new.sheet(again).points, old.sheet(old.replay(actions)).points)
        sources += sum(isinstance(move, Source) for move in new.moves(actions))
        assert new.moves(actions) == old.moves(actions)
    assert sources


@pytest.mark.parametrize("symmetry", ["none", "y"])
def test_without_the_setting_there_is_none(symmetry: str) -> None:
    for setting in (False, True):
        game = Game(9, symmetry, Square(2), source_action=setting)
        with pytest.raises(ValueError, match="not legal"):
            game.replay_moves([Place(2, 1), Extend((-2, 2), 1, (-1, 3), (-3, 1), (-3, 3)), Source((-3, 3), "next", 1)])
