"""Start patterns of any size and place: which ones the game offers, how they fold, what is refused."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import PLACEMENT, SELECTION
from origami_lab.game.moves import Extend, Lay, Place, Point, move_from_dict, move_to_dict
from origami_lab.game.start_from_moves import FromFile, FromMoves, saved_start
from origami_lab.game.start_patterns import CHOOSE, Crease, Panel, Rectangle, Square, Start
from tests.growing import grown

Outline = frozenset[tuple[Point, Point, int]]
"""Directed sides with their signs."""


def offered(game: Game) -> list[tuple[Outline, int]]:
    """Every start pattern that can be placed, by playing each way to do it, with the number of actions."""
    found, waiting = [], [()]
    while waiting:
        actions = waiting.pop()
        states = game.replay(actions)
        if int(states["phase"][0]) == SELECTION:
            [move] = game.moves(actions)
            assert isinstance(move, Lay)
            sides = zip(move.corners, move.corners[1:] + move.corners[:1], move.signs, strict=True)
            found.append((frozenset((a, b, move.sign * sign) for a, b, sign in sides), len(actions)))
            # the sheet is that pattern
            sheet = game.sheet(states)
            assert {tuple(point) for point in sheet.flat.tolist()} == set(move.corners)
            continue
        waiting += [(*actions, int(action)) for action in game.legal(states)]
    return found


def images(group: Any, outline: Outline) -> set[Outline]:
    out = set()
    for matrix in group.matrices:
        turned = np.linalg.det(matrix) < 0
        sides = []
        for a, b, sign in outline:
            p, q = (tuple(int(t) for t in matrix @ np.array(point)) for point in (a, b))
            sides.append((q, p, sign) if turned else (p, q, sign))
        out.add(frozenset(sides))
    return out


def rectangles(half: tuple[int, int], square: bool) -> set[Outline]:
    """All within the edge of a board, valley and mountain."""
    xs, ys = (range(1 - h, h) for h in half)
    out = set()
    for (x0, x1), (y0, y1) in itertools.product(itertools.combinations(xs, 2), itertools.combinations(ys, 2)):
        if not square or x1 - x0 == y1 - y0:
            corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
            sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
            out |= {frozenset((a, b, sign) for a, b in sides) for sign in (1, -1)}
    return out


def creases(half: tuple[int, int], upper: bool) -> set[Outline]:
    """All between two points within the edge; the panel that stays lies beyond the way back."""
    points = [(x, y) for x in range(1 - half[0], half[0]) for y in range(1 - half[1], half[1])]
    out = set()
    for a, b in itertools.permutations(points, 2):
        (x0, y0), (x1, y1) = a, b
        left = (y0 - y1, x1 - x0)  # where the panel stays
        is_upper = left[1] > 0 or (left[1] == 0 and left[0] < 0)
        if is_upper == upper:
            out |= {frozenset({(a, b, sign), (b, a, 0)}) for sign in (1, -1)}
    return out


@pytest.mark.parametrize("symmetry", ["none", "y", "x", "xy", "xyd"])
@pytest.mark.parametrize("kind", ["rectangle", "square", "upper", "lower"])
@pytest.mark.parametrize("board", [(7, 7), (9, 7)])
def test_each_pattern_with_the_symmetry_is_offered_once(symmetry: str, kind: str, board: tuple[int, int]) -> None:
    starts = {"rectangle": Rectangle(), "square": Square(CHOOSE, CHOOSE)}
    start: Start = starts[kind] if kind in starts else Crease(ends=CHOOSE, stays=kind)
    if (symmetry == "xyd" and board[0] != board[1]) or (kind in ("upper", "lower") and symmetry in ("xy", "xyd")):
        pytest.skip("there is none")
    game = Game(symmetry=symmetry, start=start, board_width=board[0], board_height=board[1])
    found = offered(game)
    half = (board[0] // 2, board[1] // 2)
    every = creases(half, kind == "upper") if kind not in starts else rectangles(half, kind == "square")
    expected = {outline for outline in every if images(game.symmetry, outline) == {outline}}
    assert {outline for outline, _ in found} == expected
    assert len(found) == len(expected) > 0
    # location actions and one for each sign
    assert max(count for _, count in found) <= 3
    assert game.rules.n_actions == 3 * game.rules.points + 5 + 2


@pytest.mark.parametrize(("start", "sizes"), [
    (Square(2, CHOOSE), {(4, 4)}),
    (Rectangle(3, CHOOSE), {(3, height) for height in range(1, 7)}),
    (Rectangle(CHOOSE, 2), {(width, 2) for width in range(1, 7)}),
    (Rectangle(2, 3), {(2, 3)}),
    (Rectangle(corner=(1, 2)), {(width, height) for width in (1, 2) for height in (1,)}),
    (Rectangle(2, CHOOSE, (0, -3)), {(2, height) for height in range(1, 7)}),
])  # fmt: skip
def test_what_is_given_is_not_chosen(start: Start, sizes: set[tuple[int, int]]) -> None:
    game = Game(9, "none", start)
    found = set()
    for outline, _ in offered(game):
        x, y = np.array([a for a, _, _ in outline]).T
        found.add((int(np.ptp(x)), int(np.ptp(y))))
        if isinstance(start, Rectangle) and start.corner != CHOOSE:
            assert (x.min(), y.min()) == start.corner
    assert found == sizes


# --- how they fold ---------------------------------------------------------------------------------------------------


def folded(game: Game, moves: list[Any]) -> np.ndarray:
    """(K, V, 3) the vertices in the order of their distances from the first corner on the flat sheet."""
    return np.array(game.sheet(game.replay_moves(moves)).points)


def distances(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)


def moved(moves: list[Any], by: Point) -> list[Any]:
    """Moves with all their points shifted."""

    def shift(p: Point) -> Point:
        return p[0] + by[0], p[1] + by[1]

    out = []
    for move in moves:
        if isinstance(move, Lay):
            out.append(Lay(tuple(shift(p) for p in move.corners), move.signs, move.sign))
        else:
            out.append(Extend(shift(move.leaf), move.mode, shift(move.a), shift(move.b), shift(move.c)))
    return out


def test_a_pattern_folds_alike_wherever_it_is_placed() -> None:
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    moves = [Lay(corners, (1,) * 4, 1), Extend((-1, 1), -1, (0, 4), (-4, 0), (-2, 2))]
    centred = Game(13, "none", Square(1)).replay_moves([Place(1, 1), *moves[1:]])
    there = folded(Game(13, "none", Square(1, (1, -2))), moved(moves, (1, -2)))
    order = [0, 1, 2, 3, 4, 5, 6]
    expected = Game(13, "none", Square(1)).sheet(centred).points
    assert np.abs(there[:, order] - [1, -2, 0] - expected).max() < 1e-12
    chosen = folded(Game(13, "none", Rectangle()), moved(moves, (1, -2)))
    assert np.array_equal(chosen, there)
    given = folded(Game(13, "none", Panel(tuple((x + 1, y - 2) for x, y in corners))), moved(moves, (1, -2)))
    assert np.array_equal(given, there)


@pytest.mark.parametrize("mode", [1, -1])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_other_panel_stays_and_the_shape_is_the_same(mode: int, sign: int) -> None:
    """Which panel of a crease stays in the plane turns the whole sheet about the crease by the driving angle."""
    ends = ((-2, -1), (2, 1))  # an oblique crease, of a length that is no whole number
    extension = Extend((2, 1), mode, (5, -1), (4, 4), (5, 2))
    shapes = {}
    for stays in ("upper", "lower"):
        game = Game(13, "none", Crease(ends=ends, stays=stays))
        corners = ends if stays == "upper" else ends[::-1]
        shapes[stays] = folded(game, [Lay(corners, (1, 0), sign), extension])
        flat = game.sheet(game.replay_moves([Lay(corners, (1, 0), sign), extension])).flat
        order = np.lexsort(flat.T)
        shapes[stays] = shapes[stays][:, order]
        # the children of the side that stays lie in the plane
        above = flat[order] @ (-1, 2) > 0
        children = [tuple(p) for p in flat[order].tolist()]
        kept = children.index((4, 4) if stays == "upper" else (5, -1))
        assert bool(above[kept]) == (stays == "upper")
        assert np.abs(shapes[stays][:, kept, 2]).max() < 1e-12
    reach = min(len(shape) for shape in shapes.values())
    assert reach > 1
    assert np.abs(distances(shapes["upper"][:reach]) - distances(shapes["lower"][:reach])).max() < 1e-9
    # not a mirror image
    axis = np.array([2, 1, 0]) / math.sqrt(5)
    for k, (upper, lower) in enumerate(zip(shapes["upper"], shapes["lower"], strict=False)):
        along, across = np.outer(lower @ axis, axis), np.cross(axis, lower)
        cos, sin = math.cos(game.angles[k]), math.sin(game.angles[k])
        turns = [lower * cos + way * across * sin + along * (1 - cos) for way in (1, -1)]
        assert min(np.abs(upper - turned).max() for turned in turns) < 1e-9


def test_sides_turn_by_their_signs() -> None:
    """At each driven side of a panel the flap beside it rises where its sign is that of a valley."""
    corners = ((2, 2), (-2, 2), (-2, -2), (2, -2))
    game = Game(13, "none", Panel(corners, (1, 0, -1, 1)), driving_angle_max=90)
    states = game.new_states()
    assert [int(a) - 3 * game.rules.points - 5 for a in game.legal(states)] == [0, 1]
    sheet = game.replay_moves([Lay(corners, (1, 0, -1, 1), 1)])
    assert {frozenset(map(tuple, pair)) for pair in _driven(game, sheet)} == {
        frozenset(side) for side in (((2, 2), (-2, 2)), ((-2, -2), (2, -2)), ((2, -2), (2, 2)))
    }
    # a corner between two sides of one sign, and one beside the side that is not driven
    moves = [Lay(corners, (1, 0, -1, 1), 1), Extend((2, 2), 1, (5, 1), (1, 5), (4, 4))]
    points = game.sheet(game.replay_moves(moves)).points[0]
    assert points[4, 2] > 0  # beyond valleys
    assert points[5, 2] > 0
    moves = [Lay(corners, (1, 0, -1, 1), -1), Extend((2, 2), -1, (5, 1), (1, 5), (4, 4))]
    assert np.array_equal(game.sheet(game.replay_moves(moves)).points[0], points * [1, 1, -1])


def _driven(game: Game, states: Any) -> list[Any]:
    sheet = game.sheet(states)
    return [sheet.flat[list(pair)].tolist() for pair, sign in sheet.creases.items() if sign]


def test_a_corner_without_a_crease_cannot_be_selected_before_one_leads_to_it() -> None:
    corners = ((2, 2), (-2, 2), (-2, -2), (2, -2))
    game = Game(13, "none", Panel(corners, (0, 0, 1, 1)))
    states = game.replay_moves([Lay(corners, (0, 0, 1, 1), 1)])
    n = game.rules.points

    def selectable() -> set[Point]:
        return {(int(a) % 13 - 6, int(a) // 13 - 6) for a in game.legal(states) if a < n}

    assert selectable() == {(2, 2), (-2, -2), (2, -2)}
    # (2, 2) merges into it along the side that is not driven
    for action in game.encode(Extend((2, 2), 1, (5, 2), (-2, 2), (3, 5)), states):
        game.play(states, action)
    assert int(states["status"][0]) == 0
    assert (-2, 2) in selectable()
    assert game.sheet(states).creases.keys() >= {(0, 1)}


# --- as data ---------------------------------------------------------------------------------------------------------

STARTS: dict[str, tuple[str, Start]] = {
    "rectangle": ("y", Rectangle()),
    "any square": ("none", Square(CHOOSE, CHOOSE)),
    "beside the centre": ("y", Square(CHOOSE, (0, 1))),
    "any crease": ("none", Crease(ends=CHOOSE, stays="lower")),
    "lower crease": ("y", Crease(CHOOSE, stays="lower")),
    "panel": ("y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (1, 0, -1, 0, 1))),
}


@pytest.mark.parametrize("name", STARTS)
def test_a_saved_design_is_a_start_pattern(name: str, tmp_path: Path) -> None:
    symmetry, start = STARTS[name]
    game, rng = Game(11, symmetry, start, max_crease_length=5), np.random.default_rng(4)
    for _ in range(4):
        states = grown(game, rng, 6)
        actions = game.finished_actions(states)
        moves = game.moves(actions)
        again = Game(11, symmetry, FromMoves(tuple(moves)), max_crease_length=5)
        there = again.new_states(1)
        assert np.array_equal(again.sheet(there).points, game.sheet(states).points)
        assert [move_from_dict(json.loads(json.dumps(move_to_dict(move)))) for move in moves] == moves
        # and from a file, whole and with a vertex cut off
        saved = {"symmetry": symmetry, "start": saved_start({}, again)}
        file = tmp_path / "actions.json"
        file.write_text(json.dumps({"game": saved, "moves": [move_to_dict(move) for move in moves]}))
        read = Game(11, symmetry, FromFile(file), max_crease_length=5)
        assert read.start_moves == again.start_moves == tuple(moves)
        extended = [move.leaf for move in moves if isinstance(move, Extend)]
        if extended:
            less = Game(11, symmetry, FromFile(file, [extended[-1]]), max_crease_length=5)
            assert extended[-1] not in [move.leaf for move in less.start_moves if isinstance(move, Extend)]
            assert less.start_moves[0] == moves[0]


def test_an_unfinished_placement_is_no_part_of_a_design() -> None:
    game = Game(9, "none", Rectangle())
    states = game.new_states()
    for done in range(3):
        assert game.finished_actions(states) == ()
        assert int(states["phase"][0]) == PLACEMENT
        assert int(states["n_actions"][0]) == done
        game.play(states, int(game.legal(states)[0]))
    assert len(game.finished_actions(states)) == 3
    assert len(game.bare_start()) == 3
    assert game.corners == 4


@pytest.mark.parametrize(("symmetry", "start", "field", "says"), [
    ("none", Square(1, (3, 0)), "start.position", "too near"),
    ("none", Square(2, (2, 0)), "start.size", "from 1 to 1"),
    ("none", Square(1, (0.5, 0)), "start.position", "board point"),
    ("none", Square(1, "left"), "start.position", "choose"),
    ("y", Square(1, (1, 0)), "start.position", "symmetry=y"),
    ("xyd", Square(1, (0, 1)), "start.position", "symmetry=xyd"),
    ("none", Square(9, CHOOSE), "start.size", "half-width"),
    ("none", Rectangle(0), "start.width", "from 1 to 6"),
    ("none", Rectangle(7), "start.width", "from 1 to 6"),
    ("none", Rectangle(height="tall"), "start.height", "choose"),
    ("y", Rectangle(3), "start.width", "symmetry=y"),
    ("xyd", Rectangle(2, 4), "start.width", "symmetry=xyd"),
    ("none", Rectangle(corner=(4, 0)), "start.corner", "edge"),
    ("none", Rectangle(corner=(3, 0)), "start.corner", "lower left"),
    ("none", Rectangle(4, 1, (0, 0)), "start.corner", "lower left"),
    ("y", Rectangle(corner=(1, 0)), "start.corner", "lower left"),
    ("none", Rectangle(corner="here"), "start.corner", "choose"),
    ("y", Crease(ends=((0, -1), (0, 2))), "start.ends", "mirror axis"),
    ("x", Crease(ends=((-1, 0), (2, 0))), "start.ends", "mirror axis"),
    ("y", Crease(ends=((-1, 0), (2, 0))), "start.ends", "mapped to itself"),
    ("xy", Crease(ends=CHOOSE), "symmetry", "swap"),
    ("none", Crease(ends=((1, 1), (1, 1))), "start.ends", "different"),
    ("none", Crease(ends=((1, 1),)), "start.ends", "two different"),
    ("none", Crease(ends=((-4, 1), (1, 1))), "start.ends", "edge"),
    ("none", Crease(stays="left"), "start.stays", "upper or lower"),
    ("none", Panel(((1, 1), (0, 0))), "start.corners", "three to 16"),
    ("none", Panel(((1, 1), (0, 0), (-1, -1))), "start.corners", "strictly convex"),
    ("none", Panel(((2, 0), (0, 0), (0, 2), (-1, -1))), "start.corners", "strictly convex"),
    ("none", Panel(((2, 0), (-2, 1), (1, -2), (0, 2), (-1, -2))), "start.corners", "strictly convex"),
    ("none", Panel(((2, 0), (0, 4), (0, 0))), "start.corners", "edge"),
    ("none", Panel("square"), "start.corners", "board points"),
    ("none", Panel(((2, 0), (0, 2), (0, 0)), (1, 1)), "start.signs", "each side"),
    ("none", Panel(((2, 0), (0, 2), (0, 0)), (1, 2, 0)), "start.signs", "each side"),
    ("none", Panel(((2, 0), (0, 2), (0, 0)), (0, 0, 0)), "start.signs", "driven"),
    ("y", Panel(((2, 0), (0, 2), (0, 0))), "start.corners", "symmetry=y"),
    ("y", Panel(((2, 0), (0, 2), (-2, 0)), (1, -1, 1)), "start.corners", "signs"),
])  # fmt: skip
def test_what_is_no_start_pattern_is_refused(symmetry: str, start: Start, field: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        Game(9, symmetry, start)
    assert caught.value.field == field
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_capacity_that_is_too_small_for_the_corners_is_refused() -> None:
    corners = ((2, 1), (1, 2), (-1, 2), (-2, 1), (-2, -1), (-1, -2), (1, -2), (2, -1))
    with pytest.raises(InputError, match="capacity=8: must be larger"):
        Game(9, "none", Panel(corners), capacity=8)


def test_corners_may_be_given_clockwise() -> None:
    corners, signs = ((0, 2), (2, 1), (1, -2), (-1, -2), (-2, 1)), (1, -1, 0, -1, 1)
    [(outline, _), _] = offered(Game(9, "y", Panel(corners, signs)))
    sides = {frozenset((a, b)): abs(sign) for a, b, sign in outline}
    for i, sign in enumerate(signs):
        assert sides[frozenset((corners[i], corners[(i + 1) % 5]))] == abs(sign)
