"""Laying designs on a finer board: they fold as in the game, and a moved one that breaks a rule is refused."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.start_from_moves import FromFile
from origami_lab.game.start_patterns import Crease, Square, Start
from origami_lab.polish.finer_board import ANGLES, FineBoard, fine_board
from origami_lab.polish.lay_kernel import lay_design
from origami_lab.polish.tools import Placement, Tools, move
from origami_lab.polish.variables import Variables, variables_of
from tests.polish.designs import GROUPS, actions_of, cube, pyramid, random_designs


def lay(board: FineBoard, points: np.ndarray, angles: np.ndarray, strict: bool = True) -> tuple[bool, np.ndarray]:
    """Whether a design can be laid, and its positions, (V, 10, 3) in cells."""
    states = board.new_states()
    laid = lay_design(states, board.rules.copy(), strict, board.layout, points, board.new_notes(), angles)
    return bool(laid), states["position"][0][: len(points)] / board.finer


def padded(angles: np.ndarray) -> np.ndarray:
    return np.concatenate([angles, np.full(ANGLES - len(angles), angles[-1])])


@pytest.mark.parametrize("finer", [1, 7, 512])
@pytest.mark.parametrize(("symmetry", "start"), GROUPS)
def test_an_unmoved_design_folds_as_in_the_game(symmetry: str, start: Start, finer: int) -> None:
    game = Game(9, symmetry, start)
    for actions in random_designs(game, 4, seed=finer):
        state = game.replay(actions)[0]
        board = fine_board(game, actions, finer)
        reach, n = int(state["reach"]), int(state["n_vertices"])
        laid, positions = lay(board, board.points, padded(game.angles[:reach]))
        assert laid
        assert np.abs(positions[:, :reach] - state["position"][:n, :reach]).max() < 1e-9


@pytest.mark.parametrize("start", [Square(2), Crease("choose")], ids=["square", "crease"])
def test_a_finer_board_is_as_wide_and_as_high_as_the_game_s(start: Start) -> None:
    game, finer, seen = Game(symmetry="y", start=start, board_width=7, board_height=11), 8, 0
    for actions in random_designs(game, 4, seed=3):
        board = fine_board(game, actions, finer)
        angles = padded(game.angles[: int(game.replay(actions)[0]["reach"])])
        assert lay(board, board.points, angles)[0]
        for side, half in enumerate((3, 5)):
            for vertex in np.flatnonzero(np.abs(board.points[board.layout.corners :, side]) == half * finer):
                beyond = board.points.copy()
                beyond[board.layout.corners + vertex, side] *= 1 + 1 / (half * finer)  # one part of a cell
                assert not lay(board, beyond, angles)[0]
                seen += 1
    assert seen


def test_a_start_from_a_file_is_exempt_from_the_crease_length() -> None:
    game = Game(13, "y", FromFile("chair"), max_crease_length=2, source_action=False, driving_angle_fixed=80.0)
    board = fine_board(game, game.start_actions, 64)
    assert board.layout.exempt == len(game.start_moves) == len(board.layout.moves)
    laid, positions = lay(board, board.points, padded(game.angles))
    state = game.new_states(1)[0]
    assert laid
    assert np.abs(positions - state["position"][: len(positions)]).max() < 1e-9


PYRAMID_ANGLE = 0.9 * np.arccos(-1 / 3)


def moved(board: FineBoard, vertex: tuple[int, int], to: tuple[float, float]) -> np.ndarray:
    """The points with the vertex at a board point moved to another place, in cells."""
    points = board.points.copy()
    found = np.flatnonzero((points == np.array(vertex) * board.finer).all(axis=1))
    assert len(found) == 1
    points[found[0]] = np.round(np.array(to) * board.finer)
    return points


@pytest.mark.parametrize(
    ("vertex", "to", "why"),
    [
        ((0, 4), (0, 4.1), "longer than the longest crease, √10.2"),
        ((-2, 2), (-1.5, 0.5), "the middle child within the sheet: sectors of π or more"),
        ((-4, 0), (-0.5, 0.5), "a child within the sheet"),
        ((-4, 0), (-3.9, 0.1), "off its axis: no longer the vertex it was"),
        ((-2, 2), (-2.1, 3.9), "U3 > U1 + U2: no spherical triangle"),
        ((-2, 2), (0, 4), "on another vertex"),
    ],
)
def test_a_planted_move_that_breaks_a_rule_is_refused(
    vertex: tuple[int, int], to: tuple[float, float], why: str
) -> None:
    game = Game(11, "xy", Square(1), max_crease_length=10.2**0.5)
    board = fine_board(game, actions_of(game, game_moves()), 100)
    angles = PYRAMID_ANGLE * np.arange(1, 11) / 10
    assert lay(board, board.points, angles)[0]
    assert not lay(board, moved(board, vertex, to), angles)[0], why


def game_moves() -> list[object]:
    from tests.known_designs import game_moves as known

    return list(known.pyramid()[1])


def test_a_move_that_only_just_keeps_the_crease_length_is_legal() -> None:
    game = Game(11, "xy", Square(1), max_crease_length=10.2**0.5)
    board = fine_board(game, actions_of(game, game_moves()), 100)
    angles = 0.3 * np.arange(1, 11) / 10
    assert lay(board, moved(board, (0, 4), (0, 4.03)), angles)[0]  # 1 + 3.03² = 10.1809
    assert not lay(board, moved(board, (0, 4), (0, 4.04)), angles)[0]  # 1 + 3.04² = 10.2416


def test_panels_that_cross_are_refused_only_where_that_is_asked_for() -> None:
    game, actions = pyramid()
    board = fine_board(game, actions, 64)
    closed = np.arccos(-1 / 3)  # beyond, the flaps cross at the apex
    for factor, free in ((0.999, True), (1.001, False)):
        angles = factor * closed * np.arange(1, 11) / 10
        assert lay(board, board.points, angles, strict=True)[0] is free
        assert lay(board, board.points, angles, strict=False)[0]


def test_vertices_leave_neither_their_axes_nor_the_board() -> None:
    game, actions = pyramid()
    board = fine_board(game, actions, 64)
    variables = variables_of(board)
    tools = tools_of(board, variables)
    for j in range(len(variables.members)):
        for first, second in ((0.1, 0.3), (-0.1, -0.3), (0.2, 0.0)):
            place = Placement(board.points.copy(), np.array([1.0]))
            steps = np.zeros((len(variables.members), 2))
            steps[j] = first, second
            if move(tools, place, steps) > 0:
                on_axis = board.layout.axis > 0
                assert ((place.points == 0).any(axis=1) == on_axis).all()
                assert np.abs(place.points).max() <= 4 * 64
    place = Placement(board.points.copy(), np.array([1.0]))
    away = np.zeros((len(variables.members), 2))
    away[:, 0] = 10.0
    assert move(tools, place, away) < 0


def tools_of(board: FineBoard, variables: Variables) -> Tools:
    from origami_lab.objectives.shape import ShapeObjective
    from origami_lab.polish.energy import yardstick_of
    from origami_lab.targets.solids import pyramid as target

    stick = yardstick_of(ShapeObjective(target()), board)
    nearest = np.zeros(len(stick.samples), dtype=np.int64)
    return Tools(
        board.new_states(), board.rules.copy(), board.layout, board.new_notes(), variables, stick, nearest, np.pi
    )


def test_what_the_settings_fix_is_no_variable() -> None:
    for start, corners_move in ((Square(1), False), (Square("choose"), True)):
        game = Game(9, "xy", start)
        board = fine_board(game, actions_of(game, game_moves()), 8)
        variables = variables_of(board)
        of_corner = (variables.members == 0).any(axis=1)
        assert of_corner.any() == corners_move
        assert (variables.members[:, 0] < 0).sum() == 1  # the driving angle
    game, actions = pyramid(driving_angle_fixed=100.0)
    assert (variables_of(fine_board(game, actions, 8)).members[:, 0] >= 0).all()


def test_a_crease_moves_as_a_whole_and_its_ends_along_it() -> None:
    game = Game(9, "none", Crease("choose"))
    actions = next(random_designs(game, 1, seed=3))
    board = fine_board(game, actions, 16)
    variables = variables_of(board)
    start = [
        (row[row >= 0].tolist(), directions[row >= 0].tolist())
        for row, directions in zip(variables.members, variables.directions, strict=True)
        if row[0] in (0, 1)
    ]
    assert start == [([0, 1], [[0, 1], [0, 1]]), ([0], [[1, 0]]), ([1], [[1, 0]])]
    moved = board.points.copy()
    moved[0, 0] *= 2
    laid, positions = lay(board, moved, 1e-6 * np.arange(1, 11))
    if laid:  # the longer crease may cut into a crease of the design
        assert np.abs(positions[0, 0, :2] * 16 - moved[0]).max() < 1e-3


def test_a_start_alone_and_a_board_without_parts_are_refused() -> None:
    game, actions = cube()
    with pytest.raises(InputError, match="nothing to move"):
        fine_board(game, game.bare_start(), 8)
    for finer in (0, 100_000, 2.5, True):
        with pytest.raises(InputError, match="finer"):
            fine_board(game, actions, finer)  # type: ignore[arg-type]
