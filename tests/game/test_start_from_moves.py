"""Start patterns made of moves: what they lay, what is left when vertices are cut off, what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import play_uniform
from origami_lab.game.kernels.state import FULL, NOT_FOLDABLE
from origami_lab.game.moves import Extend, Move, Place, Source, Terminate, move_to_dict
from origami_lab.game.start_from_moves import FromFile, FromMoves, saved_start
from origami_lab.game.start_laying import play_move
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.search.dense_check import certified_reach
from tests.game.test_game import assert_same_use
from tests.known_designs.varied_games import CHAIR, CUBE, PYRAMID

GAMES: dict[str, dict[str, Any]] = {
    "none": {"board_size": 13, "symmetry": "none", "max_crease_length": 2.9},
    "y": {"board_size": 13, "symmetry": "y", "max_crease_length": 2.9},
    "xyd": {"board_size": 25, "symmetry": "xyd", "max_crease_length": 2.9},
}
CHAIR_GAME: dict[str, Any] = {"board_size": 13, "symmetry": "y", "source_action": False}


def grown(settings: dict[str, Any], start: Any, seed: int, extensions: int = 6) -> list[Move]:
    """The moves of a random game with at least so many extensions."""
    game, rng = Game(start=start, **settings), np.random.default_rng(seed)
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    states = game.new_states()
    while True:
        game.clear(states)
        play_uniform(states, 0, game.rules.record, rng.random(400), 0, 400, legal)
        if int(states["n_extensions"][0]) >= extensions and int(states["status"][0]) not in (NOT_FOLDABLE, FULL):
            return game.moves(game.finished_actions(states))


def positions(game: Game) -> dict[tuple[int, int], NDArray[np.float64]]:
    """Folded positions (reach, 3) of the start pattern's vertices by their places on the board."""
    sheet = game.sheet(game.new_states())
    return {(int(x), int(y)): sheet.points[:, i] for i, (x, y) in enumerate(sheet.flat)}


@pytest.mark.parametrize("name", GAMES)
def test_a_design_as_a_start_is_the_same_sheet(name: str) -> None:
    """Also on a larger board, with shorter creases only, and without sources; no interactions are charged."""
    settings = GAMES[name]
    for seed in range(4):
        moves = grown(settings, Square("choose"), seed)
        plain = Game(start=Square("choose"), **settings)
        ended = [move for move in moves if move != Terminate()]
        state, game = plain.replay_moves(ended), Game(start=FromMoves(tuple(moves)), **settings)
        assert list(game.start_moves) == ended
        assert np.array_equal(plain.sheet(state).points, game.sheet(game.new_states()).points)
        assert np.array_equal(plain.sheet(state).triangles, game.sheet(game.new_states()).triangles)
        larger = settings | {"board_size": 31, "max_crease_length": 1, "source_action": False}
        other = Game(start=FromMoves(tuple(moves)), **larger)
        assert np.array_equal(plain.sheet(state).points, other.sheet(other.new_states()).points)
        assert other.moves(other.start_actions) == ended


@pytest.mark.parametrize("name", GAMES)
def test_play_goes_on_from_it_and_never_undoes_it(name: str) -> None:
    settings = GAMES[name]
    game = Game(start=FromMoves(tuple(grown(settings, Square("choose"), 9, 2))), **settings)
    before, vertices = game.start_actions, positions(game)
    states, legal, rng = game.new_states(60), np.empty(game.rules.max_legal, dtype=np.int32), np.random.default_rng(1)
    further = 0
    for i in range(len(states)):
        play_uniform(states, i, game.rules.record, rng.random(400), 0, 400, legal)
        actions = game.finished_actions(states, i)
        assert actions[: len(before)] == before
        sheet = game.sheet(states, i)
        flat = {(int(x), int(y)): v for v, (x, y) in enumerate(sheet.flat)}
        for place, folded in vertices.items():
            assert np.array_equal(sheet.points[:, flat[place]], folded[: sheet.reach])
        again = game.replay(actions)
        assert game.finished_actions(again) == actions
        assert game.finished_actions(game.replay_moves(game.moves(actions))) == actions
        further += int(again["n_extensions"][0]) > int(game.new_states()["n_extensions"][0])
        game.clear(states, i)
        assert_same_use(game, states[i : i + 1], game.new_states())
    assert further > 5
    with pytest.raises(ValueError, match="do not begin"):
        game.replay(before[:-1])
    with pytest.raises(ValueError, match="do not begin"):
        game.replay_moves([Place(1, 1)])


def ancestors_kept(game: Game, moves: list[Move], kept: list[Move], removed: set[tuple[int, int]]) -> None:
    """The oracle: replayed one by one, a move is kept if and only if all creases into its leaf are, and it is legal."""
    images = [tuple(map(tuple, m.tolist())) for m in game.symmetry.matrices]

    def orbit(p: tuple[int, int]) -> frozenset[tuple[int, int]]:
        return frozenset((m[0][0] * p[0] + m[0][1] * p[1], m[1][0] * p[0] + m[1][1] * p[1]) for m in images)

    # creases (tail, head) between orbits, made by which move
    makers: dict[frozenset[tuple[int, int]], list[int]] = {}
    for number, move in enumerate(moves):
        if isinstance(move, Extend):
            for child in (move.a, move.b, move.c):
                makers.setdefault(orbit(child), []).append(number)
        elif isinstance(move, Source):
            makers.setdefault(orbit(move.leaf), []).append(number)
    kept_numbers = [number for number, move in enumerate(moves) if move in kept]
    assert [moves[number] for number in kept_numbers] == kept
    cut = {orbit(point) for point in removed}
    for number, move in enumerate(moves):
        if isinstance(move, Place):
            assert number in kept_numbers
            continue
        assert isinstance(move, Extend | Source)
        into = [maker for maker in makers.get(orbit(move.leaf), []) if maker < number]
        whole = all(maker in kept_numbers for maker in into)
        asked = isinstance(move, Extend) and orbit(move.leaf) in cut
        if number in kept_numbers:
            assert whole
            assert not asked
        elif whole and not asked:  # then it must be illegal where the others leave it
            state = game.replay_moves([moves[k] for k in kept_numbers if k < number])
            with pytest.raises(ValueError, match=r"not legal|not a leaf"):
                play_move(game.rules, move, state)


@pytest.mark.parametrize("name", GAMES)
def test_cutting_off_leaves_what_does_not_depend_on_it(name: str) -> None:
    settings, count = GAMES[name], 0
    plain = Game(start=Square("choose"), **settings)
    for seed in range(6):
        moves = [move for move in grown(settings, Square("choose"), 20 + seed) if move != Terminate()]
        whole = positions(Game(start=FromMoves(tuple(moves)), **settings))
        for move in moves:
            if not isinstance(move, Extend):
                continue
            image = plain.symmetry.matrices[-1] @ move.leaf  # any image will do
            game = Game(start=FromMoves(tuple(moves), remove=((int(image[0]), int(image[1])),)), **settings)
            kept = list(game.start_moves)
            ancestors_kept(plain, moves, kept, {move.leaf})
            count += len(kept) < len(moves) - 1
            state = plain.replay_moves(kept)
            assert np.array_equal(plain.sheet(state).points, game.sheet(game.new_states()).points)
            left = positions(game)
            assert move.leaf in left  # it is a leaf again
            for place, folded in left.items():
                reach = min(len(folded), len(whole[place]))
                np.testing.assert_allclose(folded[:reach], whole[place][:reach], atol=1e-9)
    assert count > 5


def test_what_is_left_of_the_known_designs() -> None:
    cube = {"board_size": 9, "symmetry": "xy", "max_crease_length": 2}
    chair = CHAIR_GAME | {"collisions": False, "driving_angle_max": 80}
    for moves, settings, remove, left in (
        (CUBE, cube, (-3, 1), 3),  # the lid goes, its source stays
        (CUBE, cube, (1, -1), 1),  # an image of the first extension: the source lies on a crease of its
        (CHAIR, chair, (0, -3), 4),
        (CHAIR, chair, (2, 2), 3),
        (CHAIR, chair, (-5, 2), 4),
    ):
        game = Game(start=FromMoves(tuple(moves), remove=(remove,)), **settings)
        assert len(game.start_moves) == left, remove
        assert set(game.start_moves) <= set(moves)


def test_the_chairs_seeding_pattern() -> None:
    """Its positions where flaps of the seat turn by ρ, and the reach of the driving angle."""
    game = Game(start=FromFile("chair"), driving_angle_fixed="start", **CHAIR_GAME)
    assert list(game.start_moves) == CHAIR[:3]
    rho = game.angles
    found = positions(game)
    for place, axis in (((-3, 1), 0), ((3, 1), 0), ((0, -3), 1)):  # one cell beyond an edge of the seat, downwards
        expected = np.empty((10, 3))
        expected[:, axis], expected[:, 1 - axis] = np.sign(place[axis]) * (2 + np.cos(rho)), place[1 - axis]
        expected[:, 2] = -np.sin(rho)
        np.testing.assert_allclose(found[place], expected, atol=1e-12)
    # the spikes keep their lengths and stand above the seat, where they all but meet
    spike, other = found[(-4, -6)][-1], found[(4, -6)][-1]
    assert np.linalg.norm(spike - found[(0, -3)][-1]) == pytest.approx(5, abs=1e-9)
    assert np.array_equal(spike, other * [-1, 1, 1])
    assert spike[2] > 3.9
    assert -1e-4 < spike[0] < 0
    assert game.driving_angle_fixed == pytest.approx(86.8)
    assert len(game.legal(game.new_states())) > 5
    fine = Game(start=FromFile("chair"), driving_angle_fixed=86.8, **CHAIR_GAME)
    assert certified_reach(fine, fine.start_actions, 10, sub_steps=97) == 10
    with pytest.raises(InputError, match=r"driving_angle.fixed=86.9: .*driving_angle.fixed=start"):
        Game(start=FromFile("chair"), driving_angle_fixed=86.9, **CHAIR_GAME)
    assert Game(start=FromFile("chair"), driving_angle_fixed=40, **CHAIR_GAME).driving_angle_fixed == 40
    free = Game(start=FromFile("chair"), **CHAIR_GAME)
    assert int(free.new_states()["reach"][0]) == 4  # 72 degrees of the ten angles, not 90


@pytest.mark.parametrize(("move", "exact"), [(PYRAMID[1], 180 - math.degrees(math.acos(1 / 3)))])
def test_the_largest_angle_of_the_pyramid(move: Move, exact: float) -> None:
    """Its flaps meet at acos(−1/3) = 109.47°; beyond, they would pass through each other."""
    start = FromMoves((Place(1, 1), move))
    game = Game(9, "xy", start, driving_angle_fixed="start")
    assert game.driving_angle_fixed == pytest.approx(math.floor(10 * exact) / 10)


def written(folder: Path, content: object) -> str:
    file = folder / "actions.json"
    file.write_text(content if isinstance(content, str) else json.dumps(content))
    return str(file)


def test_a_file_may_have_moves_or_actions(tmp_path: Path) -> None:
    for settings, start, node in (
        (GAMES["y"], Square("choose"), {"_target_": "origami_lab.game.Square", "size": "choose"}),
        (GAMES["y"], Crease(2), {"_target_": "origami_lab.game.Crease", "position": 2}),
    ):
        moves = grown(settings, start, 3)
        game = Game(start=start, **settings)
        actions = [int(action) for action in game.finished_actions(game.replay_moves(moves))]
        head = {"game": settings | {"start": node}}
        both = FromFile(written(tmp_path, head | {"moves": [move_to_dict(move) for move in moves], "actions": [1]}))
        numbers = FromFile(written(tmp_path, head | {"actions": actions}))
        (tmp_path / "best.fold").write_text("{}")
        for path in (tmp_path, tmp_path / "best.fold"):
            assert FromFile(path).moves == both.moves == numbers.moves
        assert list(both.moves) == [move for move in moves if move != Terminate()]
        assert (both.first, both.symmetry) == ("square" if isinstance(start, Square) else "crease", "y")
        # what a trial writes of its start pattern needs no other file
        again = saved_start({}, Game(start=both, **settings))
        json.dumps(again)
        assert again.pop("_target_").endswith("FromMoves")
        assert FromMoves(**again).moves == both.moves
    assert saved_start(node, game) == node


PLACE = {"kind": "place", "value": 1, "sign": 1}
HEAD = {"game": {"symmetry": "xy", "start": {"_target_": "origami_lab.game.Square", "size": 1}}}
FLAP = move_to_dict(PYRAMID[1])


@pytest.mark.parametrize("content", [
    "", "[1]", "{", "[" * 100_000, "\x00\xff", {}, {"game": 3}, {"game": {"symmetry": "xy"}, "moves": [PLACE]},
    {"game": {"symmetry": "xy", "start": {"_target_": "mine.Star"}}, "moves": [PLACE]}, HEAD, HEAD | {"moves": []},
    HEAD | {"moves": 3}, HEAD | {"moves": [3]}, HEAD | {"moves": [FLAP]}, HEAD | {"moves": [PLACE, PLACE]},
    HEAD | {"moves": [PLACE | {"value": 1.5}]}, HEAD | {"moves": [PLACE, FLAP | {"mode": 0}]},
    HEAD | {"moves": [PLACE, FLAP | {"leaf": [0]}]}, HEAD | {"moves": [PLACE, FLAP | {"leaf": ["0", 1]}]},
    HEAD | {"moves": [PLACE, {"kind": "terminate"}, FLAP]}, HEAD | {"actions": ["1"]}, HEAD | {"actions": [1]},
    {"game": HEAD["game"] | {"board_size": 9}, "actions": [1, 2, 3]},
    {"game": HEAD["game"] | {"board_size": "9"}, "actions": [1, 2, 3]},
    {"game": HEAD["game"] | {"symmetry": "q"}, "moves": [PLACE]},
])  # fmt: skip
def test_a_file_that_is_not_ours_is_one_line(content: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        FromFile(written(tmp_path, content))
    assert caught.value.field in ("start.path", "start.symmetry")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 700


@pytest.mark.parametrize("path", ["", "no/such", "\0", 3, None, "bowl.fold"])
def test_a_path_to_nothing_is_one_line(path: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bowl.fold").write_text("{}")
    with pytest.raises(InputError, match=r"^start\.path="):
        FromFile(path)
    (tmp_path / "run/seed=4").mkdir(parents=True)
    written(tmp_path / "run/seed=4", HEAD | {"moves": [PLACE]})
    with pytest.raises(InputError, match="did you mean run/seed=4"):
        FromFile("run")
    assert FromFile("run/seed=4").moves == (Place(1, 1),)


@pytest.mark.parametrize(("settings", "remove", "field", "says"), [
    ({"symmetry": "none"}, (), "symmetry", "must be y"),
    ({"board_size": 11}, (), "board.size", "at least 13"),
    ({"board_size": 5}, (), "start.path", "half-width"),
    ({"capacity": 8}, (), "capacity", "larger"),
    ({"driving_angle_fixed": 100}, (), "driving_angle.fixed", "=start"),
    ({"driving_angle_max": 100, "driving_angle_count": 1}, (), "start.path", "first driving angle, 100 degrees"),
    ({}, ((9, 9),), "start.remove", "not a vertex"),
    ({}, ((-3, 1),), "start.remove", "never been extended"),
    ({}, (3,), "start.remove", "list of board points"),
    ({}, ((1, 2, 3),), "start.remove", "list of board points"),
    ({}, ((0.0, 1),), "start.remove", "list of board points"),
])  # fmt: skip
def test_a_start_that_does_not_fit_is_one_line(settings: Any, remove: Any, field: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        Game(start=FromFile("chair", remove=remove), **(CHAIR_GAME | settings))
    assert caught.value.field == field
    assert "\n" not in str(caught.value)


def test_illegal_moves_are_named() -> None:
    wrong = Extend((-1, 1), -1, (0, 4), (-4, 0), (-3, 0))
    with pytest.raises(InputError, match=r"start.moves=2 moves: move 1 is not legal .*\[-1, 1\]"):
        Game(9, "xy", FromMoves((Place(1, 1), wrong)))
    with pytest.raises(InputError, match=r"start\.first"):
        FromMoves((Place(1, 1),), first="circle")
    with pytest.raises(InputError, match="symmetry"):
        Game(9, "xy", FromMoves((Place(1, 1),), first="crease"))
    for start in (Square(1), FromMoves((Place(1, 1),))):  # nothing is there to collide
        with pytest.raises(InputError, match=r"driving_angle.fixed=start: needs a start pattern"):
            Game(9, "xy", start, driving_angle_fixed="start")
    with pytest.raises(InputError, match=r"driving_angle\.fixed"):
        Game(9, "xy", Square(1), driving_angle_fixed="seed")  # type: ignore[arg-type]
