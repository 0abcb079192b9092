"""The board: what it plays is the game, and its timeline brings every state back, bit for bit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from origami_lab.game import Game, Move, Place, Source
from origami_lab.game.kernels.state import NOT_FOLDABLE, SCALARS, States
from origami_lab.objectives import BucketObjective, ShapeObjective
from origami_lab.studio.board_telling import board_view, motion_points, motion_told, pointed_view, sheet_data
from origami_lab.studio.design_board import DesignBoard, Refused
from origami_lab.studio.motion_limits import motion_end
from origami_lab.targets import cube as cube_target
from tests.growing import GAMES, grown, make, on_board
from tests.known_designs.game_moves import cube, pyramid


def used_bytes(states: States) -> bytes:
    """All of a state that means something."""
    s = states[0]
    n, t, c, a, reach = (int(s[name]) for name in ("n_vertices", "n_triangles", "n_creases", "n_actions", "reach"))
    rows = [s[name] for name in SCALARS]
    rows += [s[name][:n] for name in ("xy", "prev", "next", "first", "last", "axis", "modes", "locked")]
    leaves = np.flatnonzero(s["modes"][:n] == 0)
    rows += [s["position"][:n, :reach], *(s[name][leaves, :reach] for name in ("frame_prev", "frame_next"))]
    rows += [s["corners"][:t], s["images"][:t], s["swept"][:t], s["creases"][:c], s["driven"][:c], s["actions"][:a]]
    return b"".join(np.asarray(row).tobytes() for row in rows)


def play(board: DesignBoard, rng: np.random.Generator, actions: int) -> None:
    """Choose what is offered, at random."""
    for _ in range(actions):
        try:
            if outlines := board.placements():
                board.place_start(int(rng.integers(len(outlines))), int(rng.choice([-1, 1])))
            elif board.phase == 1:
                open_leaves = [at for at, reason in board.leaves() if reason is None]
                if (sources := board.sources()) and rng.random() < 0.3:
                    board.lay_source(int(rng.integers(len(sources))), 1)
                elif open_leaves:
                    board.select(open_leaves[int(rng.integers(len(open_leaves)))], int(rng.choice([-1, 1])))
            elif places := board.places():
                board.place(places[int(rng.integers(len(places)))][0])
            else:
                board.back()
        except Refused:
            board.back_to_step()


@pytest.mark.parametrize("name", GAMES)
def test_undo_to_the_start_and_redo_to_the_end(name: str) -> None:
    game = make(name)
    board = DesignBoard(game, BucketObjective())
    play(board, np.random.default_rng(11), 60)
    board.back_to_step()
    ends = []
    while True:
        ends.append((board.actions, used_bytes(board.states), board.leaves(), board.sources()))
        if board.at == 0:
            break
        board.undo()
    assert board.actions == game.start_actions
    with pytest.raises(Refused, match="nothing to undo"):
        board.undo()
    for actions, bits, leaves, sources in reversed(ends):
        assert board.actions == actions
        assert used_bytes(board.states) == bits
        assert used_bytes(game.replay(actions)) == bits
        assert (board.leaves(), board.sources()) == (leaves, sources)
        if board.at + 1 < len(board.steps):
            board.redo()
    with pytest.raises(Refused, match="nothing to redo"):
        board.redo()


@pytest.mark.parametrize("name", ["none", "xyd", "crease y", "rectangle", "any crease", "panel", "boundary", "wide"])
def test_what_is_offered_is_playable_and_what_is_refused_has_a_reason(name: str) -> None:
    game, rng = make(name), np.random.default_rng(12)
    board = DesignBoard(game, BucketObjective())
    for _ in range(25):
        play(board, rng, 2)
        view = board_view(board, 1, sheet_data(game, board.actions), unsaved=False)
        places = {tuple(place.at) for place in view.places}
        half_x, half_y = game.rules.half
        for _ in range(6):
            at = int(rng.integers(-half_x, half_x + 1)), int(rng.integers(-half_y, half_y + 1))
            told = pointed_view(board, 7, at)
            inside = board.playable(at)
            assert tuple(told.at) == inside
            assert told.legal == (board.why_not(inside) is None)
            assert told.legal or told.says
            if view.phase in ("first", "second", "third"):
                assert told.legal == (inside in places)
                assert (told.ghost is not None) == told.legal
        before = used_bytes(board.states)
        if places and view.phase in ("first", "second"):
            board.place(sorted(places)[0])
            assert used_bytes(board.states) != before
            board.back()
            assert used_bytes(board.states) == before
        if view.sheet is not None:
            assert view.panels == len(view.sheet.panels)
            assert view.vertices == len(view.sheet.vertices)
            assert view.creases == sum(letter != "B" for letter in view.sheet.letters)


def test_the_known_cube_and_pyramid() -> None:
    objective = ShapeObjective(cube_target())
    game, moves = cube()
    board = DesignBoard(game, objective)
    board.place_start(0, 1)
    for move in moves[1:-1]:
        board.play_move(move)
    board.terminate()
    score = board.score()
    assert score is not None
    assert score.value == pytest.approx(-0.00225, abs=1e-5)  # docs/how-it-works.md
    assert board.has_ended
    assert board.moves == tuple(moves[:-1])
    with pytest.raises(Refused):
        board.play_move(moves[1])
    board.undo()
    assert not board.has_ended
    # the same by single clicks
    other = DesignBoard(pyramid()[0], objective)
    other.place_start(0, 1)
    other.select((-1, 1), -1)
    other.place((0, 4))
    other.place((-4, 0))
    assert [at for at, _ in other.places()]
    other.place((-2, 2))
    assert other.moves == tuple(pyramid()[1][:-1])


def folds(name: str, moves: tuple[Move, ...], degrees: float, *, collisions: bool) -> bool:
    """Whether a game that has this driving angle alone plays the moves."""
    board, symmetry, start, length = GAMES[name]
    one_angle = {"driving_angle_fixed": degrees, "driving_angle_count": 1, "collisions": collisions}
    sources = "boundary" if name.startswith("boundary") else True
    game = on_board(board, symmetry, start, max_crease_length=length, source_action=sources, **one_angle)
    try:
        return int(game.replay_moves(moves)["status"][0]) != NOT_FOLDABLE
    except ValueError:
        return False


@pytest.mark.parametrize("name", ["none", "y", "xyd", "crease", "boundary"])
def test_where_the_motion_ends_and_why(name: str) -> None:
    """Against games of one driving angle each, with collisions and without."""
    game, seen = make(name), set()
    for seed in range(12):
        moves = tuple(game.moves(game.finished_actions(grown(game, np.random.default_rng(seed), 6))))
        found = motion_end(game, game.finished_actions(game.replay_moves(moves)))
        free_to, ends = found.free_to, found.ends
        seen.add(ends)
        assert (len(found.meeting) > 0) == (ends == "collides")
        if free_to >= 0.1 and ends != "whole":
            assert folds(name, moves, free_to, collisions=True)
        if ends != "whole":
            # exactly where a vertex is folded flat, rounding has it closed or not: looked at on both sides
            end = math.floor(10 * free_to + 1e-6) / 10 + 0.1
            assert not all(folds(name, moves, end + beside, collisions=True) for beside in (-0.01, 0.01))
            behind = [min(end + beyond, 179.99) for beyond in (0, 0.01, 0.1)]
            assert any(folds(name, moves, degrees, collisions=False) for degrees in behind) == (ends == "collides")
    assert "collides" in seen


def test_what_a_place_costs_is_said_before() -> None:
    game, _ = cube()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    board.select((-1, 1), -1)
    board.place((-1, 3))
    board.place((-3, 1))
    # beyond 90° the walls would have to pass through each other
    assert pointed_view(board, 1, (-2, 2)).says == "panels collide at 108°: it folds to 90°"
    assert pointed_view(board, 1, (-3, 3)).says == "longer than max_crease_length = 2 cells"


def test_the_motion_ends_where_a_vertex_no_longer_closes() -> None:
    """A pyramid's corner closes up to arccos(−1/3)."""
    game, moves = pyramid()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    assert motion_end(game, board.actions).ends == "whole"
    board.play_move(moves[1])
    end = motion_end(game, board.actions)
    assert end.ends in ("closes", "collides")
    assert end.free_to == pytest.approx(np.degrees(np.arccos(-1 / 3)), abs=0.11)


def test_the_panels_that_meet_are_those_that_would_pass_through_each_other() -> None:
    """Beyond 90° the four walls of a box without a lid lean over each other; its floor meets nothing."""
    game, moves = cube()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    board.play_move(moves[1])
    end = motion_end(game, board.actions)
    assert end.ends == "collides"
    assert end.free_to == pytest.approx(90.0, abs=0.06)  # the game's own angle there is 89.95°
    told = motion_told(3, game, board.actions)
    sheet = sheet_data(game, board.actions)
    assert sheet is not None
    floor = next(k for k, panel in enumerate(sheet.panels) if {abs(t) for v in panel for t in sheet.vertices[v]} == {1})
    assert told.panels
    assert floor not in told.panels
    turned = {frozenset((y, -x) for v in sheet.panels[k] for x, y in [sheet.vertices[v]]) for k in told.panels}
    assert turned == {frozenset((x, y) for v in sheet.panels[k] for x, y in [sheet.vertices[v]]) for k in told.panels}


@pytest.mark.parametrize("seed", range(6))
def test_the_page_has_the_motion_up_to_its_end(seed: int) -> None:
    game = make("y")
    actions = game.finished_actions(grown(game, np.random.default_rng(seed), 5))
    sheet, told = sheet_data(game, actions), motion_told(1, game, actions)
    assert sheet is not None
    places = [state.at for state in (*sheet.states, *told.further)]
    assert places == sorted(set(places))
    assert places[-1] >= told.free_to - 1e-5
    points = motion_points(game, actions, np.radians([places[-1]]))[0]
    last = [*sheet.states, *told.further][-1]
    assert np.abs(np.array(last.coords).reshape(-1, 3) - points).max() < 2e-5


def test_a_preview_is_what_playing_it_gives() -> None:
    game, moves = cube()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    board.select((-1, 1), -1)
    board.place((-1, 3))
    board.place((-3, 1))
    ghost = pointed_view(board, 1, (2, -2)).ghost  # an image of the place
    assert ghost is not None
    board.place((-2, 2))
    points = motion_points(game, board.actions, np.radians(ghost.angles))
    shown = np.array(ghost.coords).reshape(len(ghost.angles), -1, 3)
    for state, seen in zip(points, shown, strict=True):
        for place in seen:
            assert np.abs(state - place).max(axis=1).min() < 1e-4
    assert len(ghost.creases) == 12
    assert moves


def test_edits_are_steps() -> None:
    game, moves = cube()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    for move in moves[1:-1]:
        board.play_move(move)
    whole, bits = board.actions, used_bytes(board.states)
    assert board.cut([(-3, 1)]) == 1
    assert board.moves == tuple(moves[:3])
    board.undo()
    assert used_bytes(board.states) == bits
    board.cut([(1, 1)])
    assert board.moves == (Place(1, 1),)
    board.undo()
    assert board.shift((-3, 2), (-3, 3)) == 0
    assert board.actions != whole
    for edit, says in (
        (lambda: board.shift((1, 1), (2, 2)), "start pattern"),
        (lambda: board.cut([(4, 4)]), "no vertex"),
    ):
        with pytest.raises(Refused, match=says):
            edit()
    assert isinstance(board.moves[2], Source)


def test_a_thousand_steps() -> None:
    game, moves = pyramid()
    board = DesignBoard(game, BucketObjective())
    board.place_start(0, 1)
    for k in range(1200):
        if k % 2:
            board.cut([(-1, 1)])
        else:
            board.play_move(moves[1])
    assert len(board.steps) == 1202
    for _ in range(1201):
        board.undo()
    for _ in range(1200):
        board.redo()
    assert board.moves == tuple(moves[:2])


def test_a_saved_design_goes_on_where_it_was() -> None:
    game, moves = cube()
    actions = game.finished_actions(game.replay_moves(moves))
    board = DesignBoard(game, BucketObjective(), actions)
    assert board.has_ended
    assert board.moves == tuple(moves[:-1])
    with pytest.raises(Refused, match="cannot be played"):
        DesignBoard(Game(9, "none"), BucketObjective(), actions[1:])
