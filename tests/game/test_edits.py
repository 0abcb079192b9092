"""Cutting vertices off and moving them: what is left was played, is legal, and is what it was."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game import Extend, Game, with_vertex_moved, without_vertices
from origami_lab.game.kernels.state import States
from tests.growing import GAMES, grown, make
from tests.known_designs.game_moves import cube, pyramid


def board_points(game: Game, beyond: int = 0) -> Iterator[tuple[int, int]]:
    half_x, half_y = (half + beyond for half in game.rules.half)
    return ((x, y) for y in range(-half_y, half_y + 1) for x in range(-half_x, half_x + 1))


def played_out(name: str, moves: int, seed: int = 0) -> tuple[Game, States]:
    game = make(name)
    return game, grown(game, np.random.default_rng(seed), moves)


@pytest.mark.parametrize("name", GAMES)
def test_a_cut_takes_what_grew_from_it_and_nothing_that_does_not_need_it(name: str) -> None:
    game, states = played_out(name, 9, seed=5)
    actions = game.finished_actions(states)
    moves = game.moves(actions)
    extensions = [move for move in moves if isinstance(move, Extend)]
    for gone in extensions:
        left = game.moves(without_vertices(game, actions, [gone.leaf]))
        game.replay_moves(left)  # legal, every one
        assert gone not in left
        kept = iter(moves)
        assert all(move in kept for move in left)  # in the same order
        lost = {point for move in extensions if move not in left for point in (move.a, move.b, move.c)}
        for move in extensions:
            assert move in left or move is gone or move.leaf in lost or _illegal_without(game, left, move)
    for gone in extensions:  # a leaf takes along what placed it
        if all(gone.c != move.leaf for move in extensions):
            assert gone not in game.moves(without_vertices(game, actions, [gone.c]))


def _illegal_without(game: Game, left: list[object], move: Extend) -> bool:
    try:
        game.replay_moves([*left, move])  # type: ignore[list-item]
    except ValueError:
        return True
    return False


def test_any_image_will_do_and_the_start_pattern_stays() -> None:
    game, moves = cube()
    actions = game.finished_actions(game.replay_moves(moves[:-1]))
    assert game.moves(without_vertices(game, actions, [(1, -1)])) == moves[:1]
    assert game.moves(without_vertices(game, actions, [(3, 1)])) == moves[:3]
    for point, says in (((1, 1), "start pattern"), ((4, 4), "no vertex")):
        with pytest.raises(InputError, match=says):
            without_vertices(game, actions[:1], [point])


def test_a_moved_vertex_is_the_same_design_with_another_point() -> None:
    game, moves = pyramid()
    actions = game.finished_actions(game.replay_moves(moves[:-1]))
    [_, extend] = game.moves(with_vertex_moved(game, actions, (2, 2), (3, 3)))  # by an image of it
    assert extend == Extend((-1, 1), -1, (0, 4), (-4, 0), (-3, 3))
    there = with_vertex_moved(game, actions, (-2, 2), (-3, 3))
    assert with_vertex_moved(game, there, (-3, 3), (-2, 2)) == actions
    # off its mirror axis it could not be placed: the move goes
    assert game.moves(with_vertex_moved(game, actions, (0, 4), (0, 1))) == moves[:1]
    for point, to, says in (
        ((-1, 1), (-2, 2), "start pattern"),
        ((0, 4), (0, 5), "on the board"),
        ((3, 0), (0, 0), "no vertex"),
    ):
        with pytest.raises(InputError, match=says):
            with_vertex_moved(game, actions, point, to)


@pytest.mark.parametrize("name", ["none", "xyd", "boundary y"])
def test_moves_that_do_not_name_a_moved_vertex_and_do_not_hang_on_it_may_stay(name: str) -> None:
    game, states = played_out(name, 8, seed=7)
    actions, rng = game.finished_actions(states), np.random.default_rng(8)
    moves = game.moves(actions)
    for move in [move for move in moves if isinstance(move, Extend)]:
        x, y = move.c
        to = (x + int(rng.integers(-1, 2)), y + int(rng.integers(-1, 2)))
        if max(abs(to[0]) - game.rules.half[0], abs(to[1]) - game.rules.half[1]) > 0:
            continue
        left = game.moves(with_vertex_moved(game, actions, move.c, to))
        game.replay_moves(left)
        before = moves[: moves.index(move)]
        assert left[: len(before)] == before
