"""Reasons against the masks: where there is none the action is legal, where there is one it is not."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game import Game, Reason, Square, reaches, why_no_further, why_not_leaf, why_not_place
from origami_lab.game.kernels.state import NOT_FOLDABLE, SELECTION, THIRD
from tests.game.test_edits import board_points, played_out
from tests.growing import GAMES, grown, make

SEEN: set[Reason] = set()


@pytest.mark.parametrize("name", GAMES)
def test_a_place_is_refused_exactly_where_the_mask_is_false(name: str) -> None:
    game, rng = make(name), np.random.default_rng(2)
    for _ in range(8):
        states = grown(game, rng, int(rng.integers(1, 12)))
        legal = game.legal(states)
        n = game.rules.points
        leaves = {p for p in board_points(game) if why_not_leaf(game, states, p) is None}
        assert leaves == {_point(game, a) for a in legal if a < n}
        SEEN.update(filter(None, (why_not_leaf(game, states, p) for p in board_points(game))))
        legal = legal[legal < 2 * n]
        while len(legal):
            game.play(states, int(rng.choice(legal)))
            legal = game.legal(states)
            if int(states["phase"][0]) == SELECTION:
                break
            found = {place: why_not_place(game, states, place) for place in board_points(game, beyond=2)}
            assert {place for place, reason in found.items() if reason is None} == {
                _point(game, a - 2 * n) for a in legal
            }
            SEEN.update(filter(None, found.values()))


def test_the_masks_know_nearly_every_reason() -> None:
    """Those of limits have a game of their own below; what only the motion tells is no mask's."""
    for name in ("none", "xyd", "crease y", "boundary y", "bare"):
        test_a_place_is_refused_exactly_where_the_mask_is_false(name)
    limits = {Reason.TOO_SHORT, Reason.TOO_SHARP, Reason.TOO_NARROW}
    rare = {Reason.COLLIDES, Reason.DOES_NOT_CLOSE, Reason.STRAIGHT_SECTOR, Reason.NO_SIDE_OPEN, Reason.ON_TWO_MIRRORS}
    rare |= {Reason.MERGES_WITH_IMAGE, Reason.OPENS_THE_OTHER_WAY, Reason.CLOSED_SECTOR, Reason.WITHOUT_CREASE}
    assert set(Reason) - SEEN <= limits | rare
    assert all(reason.says and not reason.says.endswith(".") for reason in Reason)


def test_limits_are_named() -> None:
    game = Game(13, "none", Square(2), min_crease_length=2, min_sector_angle=40, min_panel_width=1, max_crease_length=4)
    states = game.replay([3 * game.rules.points + 6])
    game.play(states, int(game.legal(states)[0]))
    found = {why_not_place(game, states, place) for place in board_points(game)}
    assert {Reason.TOO_SHORT, Reason.TOO_SHARP, Reason.TOO_NARROW, Reason.TOO_LONG} <= found


@pytest.mark.parametrize("name", ["none", "y", "xyd", "crease", "boundary"])
def test_how_far_it_folds_is_what_playing_it_says(name: str) -> None:
    game, rng = make(name), np.random.default_rng(3)
    free = Game(**_settings(game), start=game.start, collisions=False)
    seen: set[Reason | None] = set()
    for _ in range(30):
        states = grown(game, rng, int(rng.integers(1, 10)))
        legal = game.legal(states)
        legal = legal[legal < 2 * game.rules.points]
        while len(legal) and int(states["phase"][0]) != THIRD:
            legal = game.play(states, int(rng.choice(legal)))
        if int(states["phase"][0]) != THIRD or not len(legal):
            continue
        found = reaches(game, states, legal)
        for action, reach in zip(legal[:12], found[:12], strict=True):
            after, without = states.copy(), states.copy()
            game.play(after, int(action))
            free.play(without, int(action))
            if int(after["status"][0]) == NOT_FOLDABLE:
                assert reach == 0
            else:
                assert reach == int(after["reach"][0])
            reason, again = why_no_further(game, states, int(action))
            assert again == reach
            seen.add(reason)
            assert (reason is None) == (reach == int(states["reach"][0]))
            if reason is Reason.DOES_NOT_CLOSE:
                assert int(without["reach"][0]) == reach or int(without["status"][0]) == NOT_FOLDABLE
            if reason is Reason.COLLIDES:
                assert int(without["reach"][0]) > reach
    assert len(seen) > 1


def test_no_child_is_placed_between_moves() -> None:
    game, states = played_out("xy", 3)
    with pytest.raises(ValueError, match="no child is being placed"):
        why_not_place(game, states, (0, 0))
    assert why_not_leaf(game, game.new_states(1), (0, 0)) is Reason.NO_LEAF


def _settings(game: Game) -> dict[str, object]:
    width, height = game.board
    longest = float(game.rules.record["max_length_sq"][0]) ** 0.5
    sources = {0: False, 1: True, 2: "boundary"}[int(game.rules.record["sources"][0])]
    return {
        "board_width": width,
        "board_height": height,
        "symmetry": game.symmetry.name,
        "max_crease_length": None if np.isinf(longest) else longest,
        "source_action": sources,
    }


def _point(game: Game, index: int) -> tuple[int, int]:
    row, column = divmod(int(index) % game.rules.points, game.board[0])
    return column - game.rules.half[0], row - game.rules.half[1]
