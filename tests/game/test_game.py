"""The game's interface: what it refuses, what it repeats bit for bit, what it translates."""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to, play_uniform
from origami_lab.game.kernels.state import FIRST, FULL, NOT_FOLDABLE, RUNNING, SELECTION, STUCK, TERMINATED, States
from origami_lab.game.moves import Extend, Place, Source, Terminate, move_from_dict, move_to_dict
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square
from tests.known_designs.varied_games import CHAIR, CUBE, PYRAMID, chair_game, cube_game, pyramid_game


@pytest.mark.parametrize(("settings", "field"), [
    ({"board_size": 8}, "board.size"),
    ({"board_size": 3}, "board.size"),
    ({"board_size": 203}, "board.size"),
    ({"board_size": 9.5}, "board.size"),
    ({"board_size": True}, "board.size"),
    ({"board_width": 8}, "board.width"),
    ({"board_width": 203}, "board.width"),
    ({"board_height": 3}, "board.height"),
    ({"board_height": "9"}, "board.height"),
    ({"board_height": 11, "symmetry": "xyd"}, "symmetry"),
    ({"board_size": 11, "board_width": 9, "symmetry": "xyd"}, "symmetry"),
    ({"start": Square(2), "board_height": 5}, "start.size"),
    ({"start": Square(2), "board_width": 5}, "start.size"),
    ({"start": Crease(3), "symmetry": "y", "board_height": 7}, "start.position"),
    ({"symmetry": "z"}, "symmetry"),
    ({"symmetry": "x", "start": Crease()}, "symmetry"),
    ({"start": Square(4), "board_size": 9}, "start.size"),
    ({"start": Square(0)}, "start.size"),
    ({"start": Square("big")}, "start.size"),
    ({"start": Crease(12), "symmetry": "y"}, "start.position"),
    ({"max_crease_length": 0}, "max_crease_length"),
    ({"max_crease_length": -1}, "max_crease_length"),
    ({"max_crease_length": float("nan")}, "max_crease_length"),
    ({"driving_angle_max": 180}, "driving_angle.max"),
    ({"driving_angle_max": float("nan")}, "driving_angle.max"),
    ({"driving_angle_fixed": 0}, "driving_angle.fixed"),
    ({"driving_angle_count": 0}, "driving_angle.count"),
    ({"stuck": "maybe"}, "stuck"),
    ({"source_action": "everywhere"}, "source_action"),
    ({"source_action": 1}, "source_action"),
    ({"source_action": None}, "source_action"),
    ({"capacity": 7}, "capacity"),
])  # fmt: skip
def test_wrong_settings_are_named(settings: dict[str, Any], field: str) -> None:
    with pytest.raises(InputError) as caught:
        Game(**{"board_size": 9, "symmetry": "xy", "start": Square(1)} | settings)
    assert caught.value.field == field
    assert "\n" not in str(caught.value)


def test_the_smallest_board_and_the_largest_square_are_fine() -> None:
    wide = Game(5, "y", Crease(-5), board_height=13), Game(201, "xyd", Square(2), board_width=7, board_height=7)
    for game in (Game(5, "xyd", Square(1)), Game(9, "none", Square(3)), Game(9, "y", Crease(-3)), *wide):
        assert len(game.legal(game.new_states())) == 2


def random_states(game: Game, count: int, seed: int) -> States:
    """Finished random episodes."""
    states, legal = game.new_states(count), np.empty(game.rules.max_legal, dtype=np.int32)
    rng = np.random.default_rng(seed)
    for i in range(count):
        play_uniform(states, i, game.rules.record, rng.random(500), 0, 500, legal)
    return states


GAMES = {
    "none": Game(9, "none", Square("choose")),
    "y": Game(13, "y", Crease("choose"), max_crease_length=2.9),
    "xy": Game(9, "xy", Square("choose")),
    "xyd": Game(25, "xyd", Square("choose"), max_crease_length=2.9),
    "wide": Game(9, "y", Square("choose"), board_width=17),
    "any rectangle": Game(9, "y", Rectangle()),
    "any crease": Game(9, "none", Crease(ends="choose", stays="lower")),
    "beside the centre": Game(11, "y", Square("choose", (0, -1))),
    "sources anywhere": Game(9, "y", Square("choose"), source_action="boundary"),
    "panel": Game(11, "x", Panel(((1, 1), (-2, 2), (-2, -2), (1, -1)), (1, -1, 1, 0))),
}


@pytest.mark.parametrize("name", GAMES)
def test_moves_and_actions_round_trip(name: str) -> None:
    game = GAMES[name]
    states = random_states(game, 40, 1)
    for i in range(len(states)):
        actions = game.finished_actions(states, i)
        moves = game.moves(actions)
        again = game.replay_moves(moves)
        assert game.finished_actions(again) == actions
        assert [move_from_dict(move_to_dict(move)) for move in moves] == moves
        n, reach = int(states[i]["n_vertices"]), int(states[i]["reach"])
        assert np.array_equal(again[0]["position"][:n, :reach], states[i]["position"][:n, :reach])


@pytest.mark.parametrize(("game", "moves"), [(pyramid_game(), PYRAMID), (cube_game(), CUBE)])
def test_known_moves_come_back(game: Game, moves: list[Any]) -> None:
    assert game.moves(game.finished_actions(game.replay_moves(moves))) == moves


def test_moves_are_plain_data() -> None:
    for move in (Place(2, -1), Extend((0, 1), 1, (1, 2), (3, 4), (5, 6)), Source((1, 2), "end", 1), Terminate()):
        assert move_from_dict(move_to_dict(move)) == move
    for bad in ({}, {"kind": "jump"}, {"kind": "place", "value": 1}, {"kind": "terminate", "now": True}):
        with pytest.raises(InputError):
            move_from_dict(bad)


def test_illegal_actions_and_moves_are_refused() -> None:
    game = pyramid_game()
    with pytest.raises(ValueError, match=r"action 1: .*not legal"):
        game.replay([*game.encode(Place(1, 1), game.new_states()), 3 * game.rules.points])  # terminate at once
    with pytest.raises(ValueError, match="not legal"):
        game.replay_moves([Place(1, 1), Extend((-1, 1), 1, (0, 4), (-4, 0), (-3, 0))])
    with pytest.raises(ValueError, match="not a leaf"):
        game.replay_moves([Place(1, 1), Extend((0, 0), 1, (0, 4), (-4, 0), (-2, 2))])
    with pytest.raises(ValueError, match="not on the board"):
        game.replay_moves([Place(1, 1), Extend((-1, 1), 1, (0, 5), (-4, 0), (-2, 2))])
    with pytest.raises(ValueError, match="not legal"):
        game.replay_moves([Place(2, 1)])


def test_placement_is_the_first_decision() -> None:
    game = Game(9, "xy", Square("choose"))
    states = game.new_states()
    assert len(game.legal(states)) == 6  # half-widths 1 to 3, two signs
    for move in (Place(3, -1), Place(2, 1)):
        flat = game.sheet(game.replay_moves([move])).flat
        assert np.abs(flat).max() == move.value
        assert len(flat) == 4
    crease = Game(9, "y", Crease("choose"))
    assert len(crease.legal(crease.new_states())) == 14
    assert crease.sheet(crease.replay_moves([Place(-2, 1)])).flat.tolist() == [[-1, -2], [1, -2]]


def test_nothing_to_do_but_extend_before_the_first_extension() -> None:
    game = pyramid_game()
    legal = game.legal(game.replay_moves([Place(1, 1)]))
    assert 3 * game.rules.points not in legal


@pytest.mark.parametrize("name", GAMES)
def test_same_actions_same_bits(name: str) -> None:
    game = GAMES[name]
    one, two = random_states(game, 20, 4), random_states(game, 20, 4)
    for i in range(20):
        assert_same_use(game, one[i : i + 1], two[i : i + 1])
        again = game.replay(one[i]["actions"][: int(one[i]["n_actions"])])
        assert_same_use(game, one[i : i + 1], again)


def assert_same_use(game: Game, one: States, two: States) -> None:
    """Equal in every row that is in use."""
    s, t = one[0], two[0]
    scalars = ["n_vertices", "n_triangles", "n_creases", "n_actions", "n_extensions", "phase", "status", "reach"]
    scalars += ["unfinished", *(["head"] if s["n_vertices"] else [])]
    if s["phase"] > SELECTION:
        scalars += ["selected", "mode", *(["first_x", "first_y"] if s["phase"] > FIRST else [])]
    assert [s[name] for name in scalars] == [t[name] for name in scalars]
    n, reach = int(s["n_vertices"]), int(s["reach"])
    rows = {"corners": s["n_triangles"], "images": s["n_triangles"], "creases": s["n_creases"]}
    rows |= {"driven": s["n_creases"], "actions": s["n_actions"], "swept": s["n_triangles"]}
    leaves = np.flatnonzero(s["modes"][:n] == 0)
    for name in ("xy", "modes", "locked", "axis"):
        assert np.array_equal(s[name][:n], t[name][:n]), name
    for name in ("prev", "next", "first", "last"):
        assert np.array_equal(s[name][leaves], t[name][leaves]), name
    for name in ("frame_prev", "frame_next"):
        assert np.array_equal(s[name][leaves, :reach], t[name][leaves, :reach]), name
    assert np.array_equal(s["position"][:n, :reach], t["position"][:n, :reach])
    for name, count in rows.items():
        assert np.array_equal(s[name][:count], t[name][:count]), name
    assert np.array_equal(game.legal(one.copy()), game.legal(two.copy()))


@pytest.mark.parametrize("name", GAMES)
def test_a_copy_plays_on_like_the_original(name: str) -> None:
    game = GAMES[name]
    rng = np.random.default_rng(9)
    states, copies = game.new_states(), random_states(game, 1, 5)  # copied over a used state
    for _ in range(60):
        legal = game.legal(states)
        if not len(legal):
            break
        copy_to(copies, 0, states, 0)
        assert_same_use(game, states, copies)
        action = int(rng.choice(legal))
        game.play(states, action)
        game.play(copies, action)
        assert_same_use(game, states, copies)
    assert pickle.loads(pickle.dumps(states)).tobytes() == states.tobytes()


def test_without_the_compiler(tmp_path: Path) -> None:
    """NUMBA_DISABLE_JIT=1 runs the same rules; the last bits may differ where the compiler fuses operations."""
    script = (
        "import sys, numpy as np\n"
        "from tests.game.test_game import GAMES, random_states\n"
        "out = {}\n"
        "for name in ('none', 'xyd'):\n"
        "    s = random_states(GAMES[name], 3, 11)\n"
        "    for f in ('n_vertices', 'n_actions', 'reach', 'status'): out[name + f] = s[f]\n"
        "    for i in range(3): out[f'{name}actions{i}'] = s['actions'][i, : s['n_actions'][i]]\n"
        "    out[name + 'position'] = np.where(np.arange(s['position'].shape[1])[None, :, None, None]\n"
        "        < s['n_vertices'][:, None, None, None], s['position'], 0)\n"
        "np.savez(sys.argv[1], **out)\n"
    )
    results = []
    for off in ("0", "1"):
        path = str(tmp_path / f"{off}.npz")
        environment = os.environ | {"NUMBA_DISABLE_JIT": off}
        subprocess.run([sys.executable, "-c", script, path], check=True, env=environment)
        with np.load(path) as data:
            results.append(dict(data))
    for name, value in results[0].items():
        np.testing.assert_allclose(value, results[1][name], atol=1e-9, err_msg=name)


@pytest.mark.parametrize("name", GAMES)
def test_a_full_state_ends_cleanly(name: str) -> None:
    game = GAMES[name]
    small = Game(
        game.board_size, game.symmetry.name, game.start, capacity=8,
        board_width=game.board[0], board_height=game.board[1],
        max_crease_length=2.9 if name in ("y", "xyd") else None, source_action=True,
    )  # fmt: skip
    states = random_states(small, 200, 3)
    assert (states["n_vertices"] <= 8).all()
    assert (states["n_triangles"] <= states["images"].shape[1]).all()
    assert (states["n_creases"] <= states["driven"].shape[1]).all()
    assert (states["status"] == FULL).any()
    for i in np.flatnonzero(states["status"] == FULL):
        assert not small.is_penalised(states, int(i))
        assert not len(small.legal(states, int(i)))
        design = small.design(small.finished_actions(states, int(i)))
        assert len(design.panels) > 1


def test_sources_fill_no_more_than_there_is_room_for() -> None:
    """Only sources and extensions, to the end of the smallest capacity."""
    game = Game(25, "y", Crease("choose"), max_crease_length=2.9, capacity=8)
    rng = np.random.default_rng(0)
    for _ in range(50):
        states = game.new_states()
        while len(legal := game.legal(states)):
            sources = [a for a in legal if 3 * game.rules.points < a < 3 * game.rules.points + 5]
            wanted = sources or [a for a in legal if a != 3 * game.rules.points] or [int(legal[0])]
            game.play(states, int(rng.choice(wanted)))
        assert int(states["n_creases"][0]) <= states["driven"].shape[1]
        assert int(states["n_actions"][0]) <= states["actions"].shape[1]


@pytest.mark.parametrize("stuck", ["score", "penalise"])
def test_how_an_episode_ends(stuck: Any) -> None:
    game = Game(9, "none", Square("choose"), stuck=stuck)
    assert game.penalty == -8
    states = random_states(game, 300, 6)
    seen = set(states["status"].tolist())
    assert {TERMINATED, STUCK, NOT_FOLDABLE} <= seen
    assert RUNNING not in seen
    for i, state in enumerate(states):
        inside = int(state["unfinished"]) > 0
        failed = state["status"] == NOT_FOLDABLE or (stuck == "penalise" and inside and state["status"] == STUCK)
        assert game.is_penalised(states, i) == failed
        # what remains is the last foldable state, and it can be replayed
        again = game.replay(game.finished_actions(states, i))
        assert int(again["n_extensions"][0]) == int(state["n_extensions"])
        assert int(again["n_vertices"][0]) == int(state["n_vertices"])


def test_a_fixed_driving_angle_needs_the_whole_motion() -> None:
    """Reach 6 of ten angles is foldable up to 108°, not at 150°."""
    assert int(pyramid_game(driving_angle_fixed=100).replay_moves(PYRAMID)["reach"][0]) == 10
    states = pyramid_game(driving_angle_fixed=150).replay_moves(PYRAMID[:-1])
    assert int(states["status"][0]) == NOT_FOLDABLE
    assert int(states["n_extensions"][0]) == 0
    assert pyramid_game(driving_angle_fixed=150).is_penalised(states)
    assert pyramid_game(driving_angle_fixed=100).first_angle == 9
    assert pyramid_game().first_angle == 0


def test_chair_seed_reaches_about_87_degrees() -> None:
    """The seeding pattern (design page, section 6) is free at 86° and blocked at 88°."""
    assert chair_game(driving_angle_fixed=86).replay_moves(CHAIR[:3])["status"][0] == RUNNING
    for degrees in (88, 90):
        with pytest.raises(ValueError, match="not a leaf"):  # its first extension is rolled back
            chair_game(driving_angle_fixed=degrees).replay_moves(CHAIR[:3])


STRAIGHT = Extend((-1, 9), 1, (0, 10), (-2, 8), (-1, 10))
"""Outer creases on one line: the incoming fold continues across it (M = −1), or the sheet is folded shut at once."""


def test_the_motion_starts_at_the_flat_sheet() -> None:
    """At a tiny driving angle all panels still face up."""
    game = Game(25, "y", Crease(9), max_crease_length=2.9, driving_angle_max=0.01, driving_angle_count=1)
    with pytest.raises(ValueError, match="not legal"):
        game.replay_moves([Place(9, -1), STRAIGHT])
    sheet = game.sheet(game.replay_moves([Place(9, -1), dataclasses.replace(STRAIGHT, mode=-1)]))
    a, b, c = (sheet.points[0][sheet.triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] / np.linalg.norm(normals, axis=1) > 0.99).all()


FLAT_MIDDLE: list[Any] = [
    Place(10, 1),
    Extend((-1, 10), 1, (-2, 11), (-3, 9), (-3, 10)),
    Extend((-2, 11), -1, (0, 12), (-4, 12), (-1, 12)),
]
"""γ² vanishes at every angle at (−2, 11): the middle crease stays flat."""


def test_rounding_does_not_decide_whether_a_pattern_folds() -> None:
    for largest in np.linspace(1, 20, 20):
        game = Game(25, "y", Crease(10), max_crease_length=2.9, driving_angle_max=float(largest))
        assert int(game.replay_moves(FLAT_MIDDLE)["reach"][0]) == 10


@pytest.mark.parametrize("name", GAMES)
def test_designs_are_consistent(name: str) -> None:
    """Panels are counter-clockwise polygons that fill the sheet; edges, angles and triangles agree with them."""
    game = GAMES[name]
    states = random_states(game, 60, 8)
    for i in range(len(states)):
        if states[i]["n_extensions"] == 0:
            continue
        design = game.design(game.finished_actions(states, i))
        flat = design.vertices
        areas = np.array([polygon_area(flat[list(panel)]) for panel in design.panels])
        t = flat[design.triangles]
        doubled = [np.linalg.det([b - a, c - a]) for a, b, c in t]
        assert (areas > 0).all()
        assert areas.sum() == pytest.approx(sum(doubled) / 2)
        per_panel = np.bincount(design.triangle_panels, doubled, minlength=len(areas)) / 2
        np.testing.assert_allclose(areas, per_panel, atol=1e-9)
        # Euler: a disc
        assert len(flat) - len(design.edges) + len(design.panels) == 1
        used = {frozenset(side) for panel in design.panels for side in zip(panel, (*panel[1:], panel[0]), strict=True)}
        assert used == {frozenset(edge) for edge in design.edges.tolist()}
        assert (design.fold_angles[:, design.boundary] == 0).all()
        driven = np.abs(design.fold_angles[:, design.driven])
        np.testing.assert_allclose(driven, np.broadcast_to(design.driving_angles[:, None], driven.shape), atol=1e-9)
        assert not (design.driven & design.boundary).any()
        assert design.best == len(design.driving_angles) - 1


def polygon_area(ring: Any) -> float:
    x, y = np.asarray(ring).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
