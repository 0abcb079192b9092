"""Tables of moves: read, laid again, cut and shifted, against play through the game's own list of legal actions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to, leaf_at
from origami_lab.game.kernels.state import NOT_FOLDABLE, States
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_table import ACTIONS, EXTEND, Moves, Points, lay_move, lay_rest, table_of, take_back
from origami_lab.game.moves import Extend, Move, Point, Source
from origami_lab.game.rules import Rules
from origami_lab.game.start_from_moves import FromMoves
from origami_lab.game.start_laying import empty_board, play_move
from tests.game.test_undo import used_part
from tests.growing import GAMES, grown, make


def read(game: Game, states: States) -> tuple[Moves, Points]:
    return table_of(states, game.rules.record, game.new_states(1))


def lay(
    game: Game, rules: States, moves: Moves, points: Points, goes: NDArray[np.int8] | None = None
) -> tuple[States, NDArray[np.int8]]:
    states, kept = game.new_states(1), np.zeros(len(moves), dtype=np.int8)
    notes = np.empty(ACTIONS, dtype=note_dtype(len(game.angles)))
    goes = np.zeros(len(moves), dtype=np.int8) if goes is None else goes
    assert lay_rest(states, 0, rules, moves, points, goes, notes, kept) == kept.sum()
    return states, kept


@pytest.mark.parametrize("name", GAMES)
def test_a_table_lays_the_state_it_was_read_from(name: str) -> None:
    game, rng = make(name), np.random.default_rng(1)
    sources = 0
    for _ in range(12):
        states = grown(game, rng, int(rng.integers(1, 14)))
        moves, points = read(game, states)
        again, kept = lay(game, game.rules.record, moves, points)
        assert kept.all()
        assert used_part(game, again) == used_part(game, states)
        named = game.moves(game.finished_actions(states))
        assert len(named) == len(moves)
        for move, row in zip(named, moves, strict=True):
            if isinstance(move, Extend):
                assert (tuple(points[row["leaf"]]), int(row["sign"])) == (move.leaf, move.mode)
                assert tuple(points[row["middle"]]) == move.c
            elif isinstance(move, Source):
                sources += 1
                ends = ("start", "end", "next")
                assert (tuple(points[row["leaf"]]), int(row["sign"])) == (move.leaf, move.sign)
                assert ends[row["option"]] == move.end
    assert sources > 0 or game.symmetry.order == 1


def test_a_start_made_of_moves_is_not_in_the_table() -> None:
    plain, rng = make("y"), np.random.default_rng(3)
    before = plain.moves(plain.finished_actions(grown(plain, rng, 4)))
    game = Game(13, "y", FromMoves(tuple(before), symmetry="y"), max_crease_length=3.0)
    states = grown(game, rng, 6)
    moves, points = read(game, states)
    assert len(moves) == len(game.moves(game.finished_actions(states))) - len(before) > 2
    again, kept = lay(game, game.rules.record, moves, points)
    assert kept.all()
    assert used_part(game, again) == used_part(game, states)


def test_an_unfinished_extension_and_the_end_are_left_out() -> None:
    game, rng = make("xyd"), np.random.default_rng(4)
    states = grown(game, rng, 4)
    expected = read(game, states)
    ended = states.copy()
    game.play(ended, 3 * game.rules.points)
    game.play(states, int(game.legal(states)[0]))
    for other in (ended, states):
        for ours, theirs in zip(read(game, other), expected, strict=True):
            assert np.array_equal(ours, theirs)


def shifted(game: Game, move: Move, old: tuple[int, int], new: tuple[int, int]) -> Move:
    """The move with a point, and its images, shifted wherever it names them."""
    ways = {tuple((m @ old).tolist()): tuple((m @ new).tolist()) for m in game.symmetry.matrices}
    names = [name for name in ("leaf", "a", "b", "c") if hasattr(move, name)]
    return replace(move, **{name: ways.get(getattr(move, name), getattr(move, name)) for name in names})


def after(states: States, leaf: Point) -> Point | None:
    """The leaf after one."""
    s = states[0]
    v = int(leaf_at(s, *leaf)) if int(s["head"]) >= 0 else -1
    if v < 0 or int(s["next"][v]) & 7:
        return None
    x, y = s["xy"][int(s["next"][v]) >> 3].tolist()
    return x, y


def other_ends(game: Game, moves: list[Move]) -> list[Point | None]:
    """For each source on the boundary the leaf after its own when it is laid."""
    states = game.new_states(1)
    out: list[Point | None] = []
    for move in moves:
        out.append(after(states, move.leaf) if isinstance(move, Source) and move.end == "next" else None)
        play_move(game.rules, move, states)
    return out


def plain_relay(
    game: Game, moves: list[Move], rules: Rules, goes: NDArray[np.int8], ends: list[Point | None]
) -> list[Move]:
    """The moves that can be laid, by the game's list of legal actions; a source stays between its leaves."""
    states, before = empty_board(game.rules), empty_board(game.rules)
    kept: list[Move] = []
    loose: set[tuple[int, int]] = set()
    for move, cut, end in zip(moves, goes, ends, strict=True):
        copy_to(before, 0, states, 0)
        leaf = getattr(move, "leaf", None)
        gone = bool(cut) or leaf in loose or end in loose
        gone = gone or (leaf is not None and end is not None and after(states, leaf) != end)
        if not gone:
            try:
                play_move(rules, move, states)
                gone = int(states["status"][0]) == NOT_FOLDABLE
                if isinstance(move, Source):  # an action names its end of the domain only
                    gone = game.moves(game.finished_actions(states))[-1] != move
            except ValueError:
                gone = True
        if not gone:
            kept.append(move)
            continue
        copy_to(states, 0, before, 0)
        if isinstance(move, Extend):
            loose |= {move.a, move.b, move.c}
        elif leaf is not None:
            loose |= {leaf} if end is None else {leaf, end}
    return kept


@pytest.mark.parametrize("name", GAMES)
def test_what_is_left_after_a_cut_is_what_plain_play_leaves(name: str) -> None:
    game, rng = make(name), np.random.default_rng(2)
    rules = game.rules.for_start_pattern(shortest_motion=True)
    went = 0
    for _ in range(12):
        states = grown(game, rng, 14)
        moves, points = read(game, states)
        extensions = np.flatnonzero(moves["kind"] == EXTEND)
        goes = np.zeros(len(moves), dtype=np.int8)
        goes[rng.choice(extensions, size=min(len(extensions), int(rng.integers(1, 3))), replace=False)] = 1
        named = game.moves(game.finished_actions(states))
        expected = plain_relay(game, named, rules, goes, other_ends(game, named))
        laid, kept = lay(game, rules.record, moves, points, goes)
        assert game.moves(game.finished_actions(laid)) == expected
        assert [move for move, keeps in zip(named, kept, strict=True) if keeps] == expected
        went += len(named) - len(expected) - int(goes.sum())
    assert went > 3  # some had hung on those that were cut


@pytest.mark.parametrize("name", GAMES)
def test_a_shifted_vertex_takes_along_all_that_names_it(name: str) -> None:
    """Legal where the shifted moves are, one by one; what has become impossible goes."""
    game, rng = make(name), np.random.default_rng(5)
    changed = dropped = 0
    for _ in range(10):
        states = grown(game, rng, 10)
        moves, points = read(game, states)
        named, none = game.moves(game.finished_actions(states)), np.zeros(len(moves), dtype=np.int8)
        for _ in range(12):
            v = int(rng.integers(len(points)))
            if v < game.corners and game.rules.record["picks"][0]:
                continue  # another start pattern
            old = tuple(points[v].tolist())
            new = (old[0] + int(rng.integers(-1, 2)), old[1] + int(rng.integers(-1, 2)))
            if new == old or new in {tuple(p) for p in points.tolist()}:
                continue
            if game.symmetry.order > 1 and not on_same_axes(game, old, new):
                continue  # a move of a leaf that leaves its axis has another number of children
            points[v] = new
            laid, _ = lay(game, game.rules.record, moves, points)
            points[v] = old
            ends = [new if end == old else end for end in other_ends(game, named)]
            expected = plain_relay(game, [shifted(game, move, old, new) for move in named], game.rules, none, ends)
            assert game.moves(game.finished_actions(laid)) == expected
            changed += len(expected) == len(named)
            dropped += len(expected) < len(named)
    assert changed > 3
    assert dropped > 3


def on_same_axes(game: Game, old: tuple[int, int], new: tuple[int, int]) -> bool:
    return bool(np.array_equal(game.symmetry.normals @ old == 0, game.symmetry.normals @ new == 0)) and bool(
        (game.symmetry.normals @ new >= 0).all()
    )


@pytest.mark.parametrize("name", ["xyd", "y"])
def test_a_move_taken_back_leaves_no_trace(name: str) -> None:
    game, rng = make(name), np.random.default_rng(6)
    notes = np.empty(ACTIONS, dtype=note_dtype(len(game.angles)))
    refused = 0
    for _ in range(20):
        moves, points = read(game, grown(game, rng, 8))
        states = game.new_states(1)
        for move in moves:
            before = used_part(game, states)
            laid, played = lay_move(states[0], game.rules.record[0], move, points, notes)
            assert laid
            take_back(states[0], notes, played)
            assert used_part(game, states) == before
            if move["kind"] == EXTEND:
                wrong = move.copy()
                wrong["middle"] = wrong["leaf"]
                assert not lay_move(states[0], game.rules.record[0], wrong, points, notes)[0]
                assert used_part(game, states) == before
                refused += 1
            lay_move(states[0], game.rules.record[0], move, points, notes)
    assert refused > 20
