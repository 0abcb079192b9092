"""The abstract objectives: closed forms on sheets made by hand, and a plain oracle over random play."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.moves import Extend, Place
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.bucket import BucketObjective
from origami_lab.objectives.chair import ChairObjective
from origami_lab.objectives.compiled_objective import CompiledObjective
from origami_lab.objectives.objective import Score, pose
from origami_lab.objectives.packaging import PackagingObjective
from origami_lab.objectives.shelf import ShelfObjective
from origami_lab.objectives.table import TableObjective
from origami_lab.search.problem import Problem
from origami_lab.search.random_search import RandomSearch
from tests.known_designs.game_moves import chair as known_chair
from tests.objectives.references import REFERENCES, farthest, shelf
from tests.objectives.sheets import episodes, hand_made, shuffled

OBJECTIVES: dict[str, type[CompiledObjective]] = {
    "bucket": BucketObjective,
    "shelf": ShelfObjective,
    "table": TableObjective,
    "chair": ChairObjective,
    "packaging": PackagingObjective,
}
PLAIN = Game(13, "none", Square(2))


def score(objective: CompiledObjective, game: Game, states: np.ndarray, above: float = -math.inf) -> Score:
    evaluator = objective.bind(game)
    return evaluator.score(states, evaluator.new_memos(1), 0, above)


def value(objective: CompiledObjective, states: np.ndarray) -> float:
    return score(objective, PLAIN, states).value


def box(degrees: float, mode: int) -> tuple[Game, np.ndarray]:
    """A square of half-width 1 with walls of height 2, its corners pleated inwards (−1) or outwards (+1)."""
    game = Game(13, "xy", Square(1), source_action=False, driving_angle_fixed=degrees)
    return game, game.replay_moves([Place(1, 1), Extend((-1, 1), mode, (-1, 3), (-3, 1), (-2, 2))])


def rim(degrees: float, mode: int) -> tuple[float, float, float, float]:
    """z and ‖xy‖ of the walls' corners and of the pleats' tips: a spherical triangle with two sides of 45 degrees."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    tip_z = s * (2 - mode * math.sqrt(2) * c) / (1 + s * s)
    tip_xy = math.sqrt(2) * (1 + (c + mode * math.sqrt(2) * s * s) / (1 + s * s))
    return 2 * s, math.hypot(1, 1 + 2 * c), tip_z, tip_xy


@pytest.mark.parametrize(
    ("degrees", "mode", "spread", "holds"),
    [
        (40, -1, 2.0, True),
        (40, 1, 2.0, False),  # the tips are too low
        (60, -1, 2.0, False),  # the tips are too near to the axis
        (60, -1, 2.5, True),
        (40, 1, 3.1, True),
        (-40, -1, 2.9, False),  # upside down
    ],
)
def test_a_box_is_a_bucket_up_to_the_lowest_point_of_its_rim(
    degrees: float, mode: int, spread: float, holds: bool
) -> None:
    game, states = box(abs(degrees), mode)
    states["position"][..., 2] *= math.copysign(1, degrees)
    wall_z, wall_xy, tip_z, tip_xy = rim(abs(degrees), mode)
    level = max(wall_z, tip_z) <= spread * min(wall_z, tip_z)
    assert (level and max(wall_xy, tip_xy) <= spread * min(wall_xy, tip_xy) and degrees > 0) == holds
    found = score(BucketObjective(spread), game, states)
    assert found == Score(pytest.approx(min(wall_z, tip_z) if holds else 0.0, abs=1e-12), 9)


@pytest.mark.parametrize("mode", [1, -1])
def test_a_box_as_a_table_and_as_packaging(mode: int) -> None:
    game, states = box(50, mode)
    wall_z, wall_xy, tip_z, tip_xy = rim(50, mode)
    high, low = max(wall_z, tip_z), min(wall_z, tip_z)
    # eight corners of walls, four tips, four corners of the bottom at z = 0
    others = 4 * high + 4 * low if wall_z > tip_z else 8 * low
    expected = -abs(high - 2.5) - others / 12
    assert score(TableObjective(), game, states).value == pytest.approx(expected, abs=1e-12)
    # the bottom, four walls, and eight triangles of area 1 in the pleats
    area = 4 + 4 * 4 + 8
    centroid = (16 * wall_z / 2 + 8 * (wall_z + tip_z) / 3) / area
    radius = max(math.hypot(xy, z - centroid) for z, xy in ((wall_z, wall_xy), (tip_z, tip_xy), (0, math.sqrt(2))))
    assert score(PackagingObjective(), game, states).value == pytest.approx(area / radius**3, abs=1e-12)


def test_a_table_is_perfect_with_four_feet_and_the_rest_in_the_plane() -> None:
    flat = [(x, y) for x in range(-2, 3) for y in range(-2, 2)]
    folded = [(x, y, 2.5 if abs(x) == 2 and y in (-2, 1) else 0.0) for x, y in flat]
    states = hand_made(PLAIN, flat, folded, [(0, 1, 2)])
    assert value(TableObjective(), states) == 0.0
    # another height of the feet costs its difference, one vertex astray its share of the others
    assert value(TableObjective(3.0), states) == -0.5
    states["position"][0, 5, :, 2] = -4.0
    assert value(TableObjective(), states) == -4.0 / 16


def test_a_table_of_four_vertices_has_no_others() -> None:
    flat = [(0, 0), (2, 0), (2, 2), (0, 2)]
    states = hand_made(
        PLAIN, flat, [(x, y, z) for (x, y), z in zip(flat, (2.5, 3.5, 1.5, 0), strict=True)], [(0, 1, 2)]
    )
    assert value(TableObjective(), states) == -(0 + 1 + 1 + 2.5) / 4


def accordion(levels: int, riser: float, tilt: float = 0.0) -> np.ndarray:
    """Levels 2 wide and 2 deep above each other, with risers 1 deep that are as high as is said; turned about y."""
    xs, flat, folded = [0], 0, []
    heights = [0.0]
    ends = [0.0]
    for level in range(levels):
        flat += 2
        xs.append(flat)
        ends.append(0.0 if level % 2 else 2.0)
        heights.append(riser * level)
        if level < levels - 1:
            flat += 1
            xs.append(flat)
            ends.append(ends[-1])
            heights.append(riser * (level + 1))
    places, corners = [], []
    for x, end, height in zip(xs, ends, heights, strict=True):
        for y in (0, 2):
            corners.append((x - 6, y))
            turned = (
                end * math.cos(tilt) - height * math.sin(tilt),
                y,
                end * math.sin(tilt) + height * math.cos(tilt),
            )
            folded.append(turned)
    for i in range(len(xs) - 1):
        a, b, c, d = 2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1
        places += [(a, b, c), (a, c, d)]
    return hand_made(PLAIN, corners, folded, places)


@pytest.mark.parametrize("tilt", [0.0, 0.7, math.pi / 2])
def test_a_shelf_has_the_area_of_its_smallest_level(tilt: float) -> None:
    assert value(ShelfObjective(), accordion(4, 1.0, tilt)) == 4.0
    assert value(ShelfObjective(), accordion(3, 0.6, tilt)) == 4.0
    assert value(ShelfObjective(), accordion(2, 1.0, tilt)) == 0.0
    assert value(ShelfObjective(), accordion(3, 0.4, tilt)) == 0.0  # too near to be levels
    assert value(ShelfObjective(gap=0.3), accordion(3, 0.4, tilt)) == 4.0
    assert value(ShelfObjective(levels=4), accordion(3, 1.0, tilt)) == 0.0
    smaller = accordion(4, 1.0, tilt)
    smaller["n_triangles"] -= 1  # half of the last level away
    assert value(ShelfObjective(), smaller) == 2.0


def test_the_known_chair_by_hand() -> None:
    """Four legs at (±2.00319, ±2, −4), a back whose four vertices and height are the design page's."""
    moves = known_chair(collisions=False)[1]
    game = Game(13, "y", Square(2), source_action=False, collisions=False, driving_angle_fixed=math.degrees(1.57))
    legs, back = 0.1, (abs(1.80192 - 2.1) + abs(1.71794 - 2.1)) / 2
    expected = -legs - (4 - 3.99199) - back
    states = game.replay_moves(moves)
    assert score(ChairObjective(), game, states) == Score(pytest.approx(expected, abs=2e-5), 9)
    # its legs' knees stand at |x| = 4: a little less room and the penalty falls due, once
    tight = score(ChairObjective(extent=3.99), game, states).value
    assert tight == pytest.approx(expected - 12, abs=2e-5)


SEAT = [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0), (0, -2.1, 4)]
LEGS = [(-2, -2.1, -4), (2, -2.1, -4), (0, 2.1, -4)]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, 0.0),
        ({5: (-2, -2.1, -3.95)}, -0.05 / 3),
        ({5: (-2, -2.1, -4.2)}, -0.2 / 3 - 6),  # it wobbles
        ({7: (0, -2.1, -4)}, -6),  # it falls over
        ({5: (-2, 2.1, -4), 6: (2, 2.1, -4)}, -6),
        ({4: (0, -2.1, 3)}, -1),
        ({4: (0, -1.1, 4)}, -1),
        ({5: (-4.1, -2.1, -4)}, -12),  # it sticks out
        ({5: (-4.1, -2.1, -4), 6: (4.1, -2.1, -4)}, -12),  # twice, for once
        ({7: (-4.1, -2.1, -4)}, -18),
        ({4: (0, 0, 0)}, -4),  # a stool
        ({7: (0, -5, -4)}, -2.9 / 3 - 12 - 6),
    ],
)
def test_a_chair_made_by_hand(changes: dict[int, tuple[float, float, float]], expected: float) -> None:
    points = [changes.get(i, point) for i, point in enumerate(SEAT + LEGS)]
    states = hand_made(PLAIN, [(i, 0) for i in range(len(points))], points, [(0, 1, 2)])
    assert value(ChairObjective(), states) == pytest.approx(expected, abs=1e-12)


def test_a_chair_stands_on_all_its_lowest_vertices() -> None:
    """A fourth leg at the same height: which of them the sheet lists first changes nothing."""
    extra = [*SEAT, (-2, -2.1, -4), (2, -2.1, -4), (1, -2.1, -4), (0, 3, -4)]
    rng = np.random.default_rng(0)
    for _ in range(10):
        points = rng.permutation(extra)
        states = hand_made(PLAIN, [(i, 0) for i in range(len(points))], points, [(0, 1, 2)])
        assert value(ChairObjective(), states) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("half", [1, 2, 3])
def test_packaging_of_a_flat_square_and_of_one_folded_in_half(half: int) -> None:
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    flat = hand_made(PLAIN, corners, [(x, y, 0) for x, y in corners], [(0, 1, 2), (0, 2, 3)])
    assert value(PackagingObjective(), flat) == pytest.approx(math.sqrt(2) / half)
    rectangle = [(0, 0), (2, 0), (2, 2), (0, 2), (-2, 2), (-2, 0)]
    upright = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 2, 2), (0, 0, 2)]
    folded = hand_made(PLAIN, rectangle, upright, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    # the centroid is at (½, 1, ½), a far corner 1.5, 1 and 0.5 away from it
    assert value(PackagingObjective(), folded) == pytest.approx(8 / 3.5**1.5)


# --- over random play ---

GAMES = {
    "none": Game(9, "none", Square("choose"), max_crease_length=4),
    "y": Game(13, "y", Square("choose")),
    "x": Game(9, "x", Square("choose")),
    "xy": Game(13, "xy", Square("choose"), max_crease_length=2.9),
    "xyd": Game(13, "xyd", Square("choose")),
    "fixed": Game(9, "xy", Square("choose"), driving_angle_fixed=50),
    "wide": Game(board_width=13, board_height=9, symmetry="y", start=Square("choose")),
}


VARIANTS = {key: (cls, REFERENCES[key]) for key, cls in OBJECTIVES.items()} | {
    # random play seldom makes three levels
    "shelf of two": (partial(ShelfObjective, 2, 0.1), partial(shelf, levels=2, gap=0.1)),
    "bucket by its rim": (partial(BucketObjective, norm_of="leaves"), REFERENCES["bucket by its rim"]),
}


@pytest.mark.parametrize("name", GAMES)
def test_kernels_score_as_the_formulas_say(name: str) -> None:
    game = GAMES[name]
    rewarded = dict.fromkeys(VARIANTS, 0)
    evaluators = {key: [(w, make(compactness=w).bind(game)) for w in (0.0, 0.3)] for key, (make, _) in VARIANTS.items()}
    for states in episodes(game, 7, 80):
        sheet = game.sheet(states)
        usable = range(game.first_angle, sheet.reach)
        away = np.array([farthest(sheet, k) for k in usable])
        for key, (_, reference) in VARIANTS.items():
            values = np.array([reference(sheet, k) for k in usable])
            rewarded[key] += bool(values.max() != 0)
            for weight, evaluator in evaluators[key]:
                found = evaluator.score(states, evaluator.new_memos(1), 0)
                expected = values - weight * away
                assert found.value == pytest.approx(expected.max(), abs=1e-9), key
                # among equals either will do
                assert expected[found.angle - game.first_angle] == pytest.approx(expected.max(), abs=1e-9), key
    # not a comparison of zeros
    assert rewarded["table"] == rewarded["chair"] == rewarded["packaging"] == 80
    assert rewarded["shelf of two"] > 0
    assert rewarded["bucket by its rim"] >= rewarded["bucket"] > 0 or game.symmetry.order < 4


ORDERS = {
    "turned by 90 degrees": (np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), ("bucket", "shelf", "table", "packaging")),
    "mirrored in y": (np.diag([1, -1, 1]), tuple(OBJECTIVES)),
    "upside down": (np.diag([1, 1, -1]), ("shelf", "packaging")),
}


@pytest.mark.parametrize("move", ORDERS)
def test_neither_order_nor_the_board_s_symmetries_change_a_score(move: str) -> None:
    """The whole sheet in any order, without symmetry, scores what its representatives do."""
    matrix, keys = ORDERS[move]
    rng = np.random.default_rng(1)
    for name in ("y", "xy", "xyd"):
        game = GAMES[name]
        plain = Game(13, "none", Square(2))
        # r_min is the board's
        plain = plain if game.board_size == 13 else Game(game.board_size, "none", Square(2))
        for states in episodes(game, 3, 60):
            other = shuffled(game, states, plain, rng, matrix)
            for key in keys:
                objective = OBJECTIVES[key]()
                expected = score(objective, game, states)
                assert score(objective, plain, other).value == pytest.approx(expected.value, abs=1e-9), key


@pytest.mark.parametrize(("inner", "by_vertices", "by_leaves"), [(1.4, 0.0, 1.0), (1.6, 1.0, 1.0), (6.1, 0.0, 1.0)])
def test_a_bucket_may_bulge_only_where_its_rim_counts_alone(inner: float, by_vertices: float, by_leaves: float) -> None:
    """The corners of the start pattern never count, though they are close to the axis."""
    corners = [(2, 2), (-2, 2), (-2, -2), (2, -2)]
    flat = [*corners, (4, 0), (0, 5), (-5, 0)]
    folded = [*((x / 4, y / 4, 0.0) for x, y in corners), (inner, 0.0, 0.2), (0.0, 3.0, 1.0), (-3.0, 0.0, 2.0)]
    states = hand_made(PLAIN, flat, folded, [(0, 1, 2)], extended=[0, 1, 2, 3, 4])
    assert value(BucketObjective(), states) == by_vertices
    assert value(BucketObjective(norm_of="leaves"), states) == by_leaves
    # the vertices do not move, so no continuation is a bucket
    evaluator = BucketObjective().bind(PLAIN)
    assert evaluator.bound(states, evaluator.new_memos(1), 0) == (math.inf if by_vertices else 0.0)


def test_a_bucket_upside_down_is_none() -> None:
    game, found = GAMES["xy"], 0
    for states in episodes(game, 3, 150):
        upright = score(BucketObjective(), game, states)
        if upright.value > 0:
            sheet = game.sheet(states)
            extended = np.flatnonzero(sheet.modes)
            for up in (1, -1):
                points = sheet.points[upright.angle] * [1, 1, up]
                states_then = hand_made(PLAIN, sheet.flat, points, sheet.triangles, extended)
                expected = upright.value if up > 0 else 0.0
                assert value(BucketObjective(), states_then) == pytest.approx(expected, abs=1e-12)
            found += 1
    assert found


def test_a_shelf_stands_on_the_boards_that_count() -> None:
    """Heights along ``up`` of the horizontal triangles fall into levels whose smallest is the score."""
    game = Game(13, "xy", Square(), source_action=False)
    problem = Problem(game, ShelfObjective(), 4_000, certify=False)
    RandomSearch().search(problem, np.random.default_rng(11))
    outcome = problem.outcome()
    assert outcome.value >= 1.0
    design = game.design(outcome.actions, outcome.angle)
    up = pose(problem.objective, design)["up"]
    assert up[2] >= 0.0
    corners = design.folded[design.best][design.triangles]
    heights = corners @ np.array(up)
    flat = np.flatnonzero(np.ptp(heights, axis=1) < 0.05)  # 1.57 rad is not quite a right angle
    flat = flat[np.argsort(heights[flat, 0])]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    levels = np.split(areas[flat], np.flatnonzero(np.diff(heights[flat, 0]) >= 0.5) + 1)
    assert len(levels) >= 3
    assert min(level.sum() for level in levels) == pytest.approx(outcome.value)
    assert pose(TableObjective(), design) == {"up": [0, 0, -1]}
    assert pose(BucketObjective(), design) == {}
