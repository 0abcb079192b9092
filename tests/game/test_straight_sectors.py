"""Vertices with a sector of exactly π: the sheet folds along one line there, and the other creases stay flat."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

import origami_lab
from benchmarks.random_play import makes_half_turn
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import STRAIGHT, States
from origami_lab.game.moves import Extend, Lay, Move, Place, Source
from origami_lab.game.start_from_moves import FromMoves
from origami_lab.game.start_patterns import Crease, Panel, Square, Start
from origami_lab.polish.finer_board import ANGLES, fine_board
from origami_lab.polish.flat_creases import without_flat_creases
from origami_lab.polish.lay_kernel import lay_design
from origami_lab.search.dense_check import certified_reach
from tests.sheet_checks import rotation_x, rotation_z

CORNER = [Place(2, 1), Extend((-2, 2), 1, (-1, 5), (-5, 1), (-4, 4))]
"""A square whose corner is extended: into (-4, 4) comes one crease, along the diagonal."""
MERGED: list[Move] = [
    Place(0, -1),
    Extend((-1, 0), -1, (-3, 4), (-2, -3), (-3, -4)),
    Extend((-2, -3), -1, (-3, -4), (0, -3), (-1, -4)),
    Extend((0, -3), -1, (-1, -4), (1, -4), (0, -4)),
]
"""A crease that ends on the axis x = 0, which it meets at a right angle: so its mirror image goes straight on there."""


def fold_angles(design: CreasePattern, u: tuple[int, int], v: tuple[int, int]) -> NDArray[np.float64]:
    """(K,) fold angles of the crease between two board points."""
    ends = [int(np.flatnonzero((design.vertices == point).all(axis=1))[0]) for point in (u, v)]
    [edge] = np.flatnonzero((np.sort(design.edges, axis=1) == sorted(ends)).all(axis=1))
    return np.asarray(design.fold_angles[:, edge])


def design_of(game: Game, moves: list[Move]) -> CreasePattern:
    return game.design(game.finished_actions(game.replay_moves(moves)))


@pytest.mark.parametrize("mode", [1, -1])
@pytest.mark.parametrize(("a", "b"), [((-5, 5), (-5, 3)), ((-3, 5), (-5, 5))], ids=["first child", "second child"])
def test_a_crease_that_goes_straight_on_folds_as_before(a: tuple[int, int], b: tuple[int, int], mode: int) -> None:
    game = Game(13, "none", Square(2), source_action=False)
    c = (-5, 4) if a == (-5, 5) else (-4, 5)
    design = design_of(game, [*CORNER, Extend((-4, 4), mode, a, b, c)])
    before = design_of(game, CORNER)
    reach = len(design.driving_angles)
    assert reach > 3
    into, on = fold_angles(design, (-2, 2), (-4, 4)), fold_angles(design, (-4, 4), (-5, 5))
    assert np.abs(into[0]) > 0.1
    np.testing.assert_allclose(into, fold_angles(before, (-2, 2), (-4, 4))[:reach], rtol=0, atol=1e-12)
    np.testing.assert_allclose(on, into, rtol=0, atol=1e-12)
    for child in ({a, b} - {(-5, 5)}) | {c}:
        np.testing.assert_allclose(fold_angles(design, (-4, 4), child), 0.0, atol=1e-12)
    assert origami_lab.verify(game.motion(design.actions, game.angles[:reach], {})).exit_code == 0


def test_its_mode_changes_nothing() -> None:
    game = Game(13, "none", Square(2), source_action=False)
    one, other = (
        design_of(game, [*CORNER, Extend((-4, 4), mode, (-5, 5), (-5, 3), (-5, 4))]).folded for mode in (1, -1)
    )
    assert np.array_equal(one, other)


def test_two_creases_that_meet_on_an_axis_are_one_line() -> None:
    game = Game(9, "y", Crease(0), source_action=False)
    states = game.replay_moves(MERGED)
    v = int(np.flatnonzero((states["xy"][0] == (0, -3)).all(axis=1))[0])
    assert states["locked"][0][v] == STRAIGHT
    design = design_of(game, MERGED)
    left, right = fold_angles(design, (-2, -3), (0, -3)), fold_angles(design, (2, -3), (0, -3))
    assert np.abs(left).min() > 0.05
    np.testing.assert_allclose(left, right, rtol=0, atol=1e-12)
    for child in ((-1, -4), (0, -4), (1, -4)):
        np.testing.assert_allclose(fold_angles(design, (0, -3), child), 0.0, atol=1e-12)
    assert origami_lab.verify(game.motion(design.actions, game.angles[: len(left)], {})).exit_code == 0


@pytest.mark.parametrize("sign", [1, -1])
def test_a_straight_line_whose_halves_fold_otherwise_does_not_fold(sign: int) -> None:
    """A child inside a boundary segment, and a driven crease from there on: the two have angles of their own."""
    corners = ((2, 2), (-2, 2), (-2, -2), (2, -2))
    game = Game(13, "none", Panel(corners, (1, 0, 0, 0)), source_action="boundary")
    moves: list[Move] = [Lay(corners, (1, 0, 0, 0), 1), Extend((-2, 2), 1, (0, 4), (-2, 0), (-4, 3))]
    design = design_of(game, moves)
    into = fold_angles(design, (-2, 2), (-2, 0))
    assert (np.abs(into - sign * design.driving_angles) > 0.05).all()
    states = game.replay_moves(moves)
    assert (-2, 0) in leaves(game, states)
    states = game.replay_moves([*moves, Source((-2, 0), "next", sign)])
    v = int(np.flatnonzero((states["xy"][0] == (-2, 0)).all(axis=1))[0])
    assert states["locked"][0][v] == STRAIGHT
    assert (-2, 0) not in leaves(game, states)


def leaves(game: Game, states: States) -> set[tuple[int, int]]:
    """Board points of the leaves that can be chosen."""
    wide, (half_x, half_y) = game.board[0], game.rules.half
    return {(int(a) % wide - half_x, int(a) // wide - half_y) for a in game.legal(states) if a < game.rules.points}


def has_half_turn(design: CreasePattern) -> bool:
    """Whether a sector of an interior vertex is π: whole numbers."""
    for v in np.flatnonzero(design.modes):
        edges = design.edges[(design.edges == v).any(axis=1)]
        x, y = (design.vertices[edges.sum(axis=1) - v] - design.vertices[v]).T
        order = np.argsort(np.arctan2(y, x))
        x, y = x[order], y[order]
        if (x * np.roll(y, -1) == y * np.roll(x, -1)).any():  # one direction is never that of two creases
            return True
    return False


def seeking(count: int, seed: int, **settings: object) -> Iterator[tuple[Game, tuple[int, ...]]]:
    """Random designs with sectors of π that fold without collisions."""
    kinds: list[tuple[str, Start]] = [
        *((symmetry, Square(2)) for symmetry in ("none", "y", "xyd")),
        *((symmetry, Crease(0)) for symmetry in ("none", "y")),
        ("x", Panel(((2, 0), (0, 2), (-2, 0), (0, -2)))),
    ]
    rng, made = np.random.default_rng(seed), 0
    games = [Game(13, *kind, max_crease_length=4.0, source_action="boundary", **settings) for kind in kinds]  # type: ignore[arg-type]
    while made < count:
        game = games[int(rng.integers(len(games)))]
        states = game.new_states(1)
        legal = game.legal(states)
        for _ in range(int(rng.integers(8, 40))):
            if not len(legal):
                break
            sought = [int(a) for a in legal if makes_half_turn(states[0], game.rules.record[0], int(a))]
            legal = game.play(states, int(rng.choice(sought if sought and rng.random() < 0.6 else legal)))
        actions = game.finished_actions(states)
        again = game.replay(actions)
        reach = int(again["reach"][0])
        if reach and has_half_turn(game.design(actions)) and certified_reach(game, actions, reach) == reach:
            made += 1
            yield game, actions


def test_designs_are_certified_and_flat_creases_are_no_freedoms() -> None:
    for game, actions in seeking(6, 3):
        reach = int(game.replay(actions)["reach"][0])
        certificate = origami_lab.verify(game.motion(actions, game.angles[:reach], {}))
        assert certificate.exit_code == 0, certificate.words()
        assert not certificate["degrees of freedom"].numbers.get("flat_edges_could_fold", False)


def test_they_lie_on_a_finer_board_and_lose_their_flat_creases() -> None:
    for game, actions in seeking(6, 4):
        state = game.replay(actions)[0]
        reach, n = int(state["reach"]), int(state["n_vertices"])
        board = fine_board(game, actions, 64)
        angles = np.concatenate([game.angles[:reach], np.full(ANGLES - reach, game.angles[reach - 1])])
        states = board.new_states()
        assert lay_design(states, board.rules.copy(), True, board.layout, board.points, board.new_notes(), angles)
        places = states["position"][0][:n, :reach] / board.finer
        assert np.abs(places - state["position"][:n, :reach]).max() < 1e-9
        design = game.motion(actions, game.angles[:reach], {})
        less = without_flat_creases(design)
        assert len(less.edges) < len(design.edges)
        assert origami_lab.verify(less).exit_code == 0


def test_without_the_setting_they_are_not_legal() -> None:
    for moves, game in (
        ([*CORNER, Extend((-4, 4), 1, (-5, 5), (-5, 3), (-5, 4))], Game(13, "none", Square(2), straight_sectors=False)),
        (MERGED, Game(9, "y", Crease(0), straight_sectors=False)),
    ):
        with pytest.raises(ValueError, match="not legal"):
            game.replay_moves(moves)
        game.replay_moves(moves[:-1])


def test_a_start_made_of_moves_has_them_whatever_the_game_says() -> None:
    last = Extend((-4, 4), 1, (-5, 5), (-5, 3), (-5, 4))
    for setting in (True, False):
        game = Game(13, "none", FromMoves((*CORNER, last)), straight_sectors=setting)
        assert game.start_moves[-1] == last
        assert int(game.new_states(1)["n_extensions"][0]) == 2
        less = Game(13, "none", FromMoves((*CORNER, last), remove=((-4, 4),)), straight_sectors=setting)
        assert less.start_moves == tuple(CORNER)
    # a leaf with a sector of π, left by a start pattern, can be chosen only where the game knows such sectors
    for setting in (True, False):
        game = Game(
            9, "y", FromMoves(tuple(MERGED[:-1]), first="crease"), source_action=False, straight_sectors=setting
        )
        assert ((0, -3) in leaves(game, game.new_states(1))) == setting


# --- what the spherical polygon of a vertex allows, by the closure of its loop alone ---------------------------------


EXACT = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 400}
CLOSED = 1e-13
"""Half the square of what is left where a loop closes."""


def residual(angles: NDArray[np.float64], sectors: NDArray[np.float64], first: float) -> NDArray[np.float64]:
    """How far ∏ Rx(ρᵢ)Rz(αᵢ) is from closing, for the fold angles that follow a given first one."""
    product = np.eye(3)
    for rho, alpha in zip([first, *angles], sectors, strict=True):
        product = product @ rotation_x(np.array(rho)) @ rotation_z(np.array(alpha))
    return np.asarray((product - np.eye(3)).ravel())


@pytest.mark.parametrize("seed", range(6))
def test_the_loop_closes_along_the_line_and_not_otherwise(seed: int) -> None:
    """Degree 4, the first crease given; the sector from the last crease to it is π, so those two fold alike."""
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.uniform(0.3, math.pi - 0.3, 2))
    sectors = np.array([cuts[0], cuts[1] - cuts[0], math.pi - cuts[1], math.pi])
    first, closed = float(rng.uniform(0.4, 2.6)), 0
    for _ in range(12):
        found = least_squares(residual, rng.uniform(-2.8, 2.8, 3), args=(sectors, first), **EXACT)
        if found.cost < CLOSED:
            closed += 1
            # the loop closes to second order in the flat ones: half its square is of fourth order
            np.testing.assert_allclose(np.exp(1j * found.x), np.exp(1j * np.array([0.0, 0.0, first])), atol=2e-3)
    assert closed


@pytest.mark.parametrize("excess", [0.02, 0.3, 1.0])
def test_beyond_a_half_turn_no_loop_closes(excess: float) -> None:
    rng = np.random.default_rng(0)
    rest = math.pi - excess
    sectors = np.array([0.3 * rest, 0.45 * rest, 0.25 * rest, math.pi + excess])
    assert np.abs(residual(np.zeros(3), sectors, 0.0)).max() < 1e-12
    for first in (0.3, 1.0, 2.0):
        for _ in range(8):
            found = least_squares(residual, rng.uniform(-2.8, 2.8, 3), args=(sectors, first), **EXACT)
            assert found.cost > 1e4 * CLOSED
