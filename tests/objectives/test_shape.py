"""The shape objective against closed forms and brute force."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from origami_lab.geometry.groups import GROUPS
from origami_lab.geometry.sampling import sample_triangles
from origami_lab.objectives.objective import Score, bind, report
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shape_kernels import folded_triangles_of
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target
from tests.known_designs.game_moves import cube as known_cube
from tests.known_designs.game_moves import pyramid as known_pyramid

PYRAMID = -3 * math.sin(math.acos(-1 / 3) - 1.884)
# the lid's free edge at ρ = 1.57: x = 1 + 2 cos ρ + cos 2ρ beyond the middle, z − 2 above the target
CUBE = -math.hypot(1 + 2 * math.cos(1.57) + math.cos(2 * 1.57), 2 * math.sin(1.57) + math.sin(2 * 1.57) - 2)


def score(objective: ShapeObjective, game: Game, states: np.ndarray) -> Score:
    evaluator = bind(objective, game)
    return evaluator.score(states, evaluator.new_memos(len(states)), 0)


@pytest.mark.parametrize("distance", ["vertex", "surface"])
def test_known_pyramid_scores_its_closed_form(distance: str) -> None:
    game, moves = known_pyramid()
    result = score(ShapeObjective(pyramid(), distance), game, game.replay_moves(moves))
    assert result.angle == 5
    assert result.value == pytest.approx(PYRAMID, abs=1e-9)


def test_known_pyramid_is_exact_towards_its_own_angle() -> None:
    """At the angle itself the flaps' edges coincide and the pleats between them are free to turn."""
    _, moves = known_pyramid()
    game = Game(9, "xy", Square(1), driving_angle_fixed=math.degrees(math.acos(-1 / 3) - 1e-5))
    for distance in ("vertex", "surface"):
        assert score(ShapeObjective(pyramid(), distance), game, game.replay_moves(moves)).value == pytest.approx(
            -3 * math.sin(1e-5), abs=1e-9
        )


def test_known_cube_scores_its_closed_form() -> None:
    game, moves = known_cube()
    result = score(ShapeObjective(cube()), game, game.replay_moves(moves))
    assert result.angle == 4
    assert result.value == pytest.approx(CUBE, abs=1e-12)
    assert result.value == pytest.approx(-2 * math.sqrt(2) * math.cos(1.57), abs=1e-6)


def test_sampled_is_within_its_own_noise_of_vertex() -> None:
    game, moves = known_cube()
    states = game.replay_moves(moves)
    exact = score(ShapeObjective(cube()), game, states).value
    assert -0.2 < score(ShapeObjective(cube(), "sampled"), game, states).value < exact + 0.02


@pytest.mark.parametrize(("target", "symmetry"), [(bowl(), "xyd"), (cube(), "xy"), (bowl(), "none")])
def test_sampled_is_what_the_paper_computes(target: Target, symmetry: str) -> None:
    """Random points on both surfaces and a k-d tree of another library, point by point."""
    game = Game(13, symmetry, Square(1), max_crease_length=4)
    objective = ShapeObjective(target, "sampled", samples=3000, sample_seed=7)
    evaluator = bind(objective, game)
    cloud = target.sampled_points(3000, 7)
    for states in random_states(game, 3, 3):
        sheet = game.sheet(states)
        distances = []
        for k, vertices in enumerate(sheet.points):
            # the sheet's triangles in the evaluator's order: which one a draw falls into depends on it
            triangles = folded_triangles_of(states, 0, game.rules.record, sheet.first + k)
            assert len(triangles) == len(sheet.triangles)
            points = sample_triangles(triangles, 3000, np.random.default_rng(7))
            away = cKDTree(cloud).query(vertices)[0]
            if target.name == "cube":  # of edge 2 on z = 0
                away[(np.abs(vertices[:, :2]) < 1).all(axis=1) & (vertices[:, 2] > 0) & (vertices[:, 2] < 2)] = 0.0
            distances.append(max(away.max(), cKDTree(points).query(cloud)[0].max()))
            assert evaluator.measure(states, 0, sheet.first + k, "sampled") == pytest.approx(distances[-1], abs=1e-12)
        found = evaluator.score(states, evaluator.new_memos(1), 0)
        assert found.value == pytest.approx(-min(distances), abs=1e-12)
        assert found.angle == sheet.first + int(np.argmin(distances))
        assert evaluator.exact_value(states, evaluator.new_memos(1), 0) == pytest.approx(found.value, abs=1e-12)


def test_folds_inside_a_closed_target_never_lower_the_bound() -> None:
    """The cube's pleats lie inside it, far from its surface: no bound may count them."""
    game, moves = known_cube()
    states = game.replay_moves(moves)
    for distance in ("vertex", "surface", "sampled"):
        evaluator = bind(ShapeObjective(cube(), distance), game)
        memos = evaluator.new_memos(1)
        assert evaluator.bound(states, memos, 0) >= evaluator.score(states, evaluator.new_memos(1), 0).value
        # half a cell for a pleat's vertex; a random sample is a tenth away
        assert evaluator.bound(states, memos, 0) > (-0.1 if distance == "sampled" else -0.01)


def test_all_three_distances_are_reported_for_the_design() -> None:
    game, moves = known_pyramid()
    states = game.replay_moves(moves)
    figures = report(ShapeObjective(pyramid(), "sampled"), game, game.finished_actions(states), 5)
    assert figures["return_vertex"] == pytest.approx(PYRAMID, abs=1e-9)
    assert figures["return_surface"] == pytest.approx(PYRAMID, abs=1e-9)
    others = {"chamfer", "likeness", "return_own", "return_percent"}
    assert set(figures) == {"return_vertex", "return_surface", "return_sampled"} | others
    assert figures["return_own"] == figures["return_sampled"]
    height = 2 * math.sqrt(2)  # its longest side
    assert figures["return_percent"] == pytest.approx(100 * figures["return_sampled"] / height)
    assert 0 < figures["chamfer"] < -PYRAMID
    assert figures["likeness"] == 1.0  # each side is less than a degree off its own


def scaled_pyramid() -> Target:
    """The pyramid as if from a file in which a cell is 2.5 units."""
    return replace(pyramid(), units_per_cell=2.5)


def test_returns_stand_in_the_units_of_the_file() -> None:
    game, moves = known_pyramid()
    actions = game.finished_actions(game.replay_moves(moves))
    objective = ShapeObjective(scaled_pyramid(), "auto")
    assert objective.distance == "surface"
    assert ShapeObjective(pyramid(), "auto").distance == "vertex"
    assert report(objective, game, actions, 5)["return_units"] == pytest.approx(2.5 * PYRAMID, abs=1e-9)


def test_the_mean_is_what_points_everywhere_say() -> None:
    """Random points of both surfaces, many, against scipy's nearest ones."""
    game, moves = known_cube()
    states = game.replay_moves(moves)
    target = bowl()
    evaluator = bind(ShapeObjective(target, "mean"), game)
    triangles, rng = folded_triangles_of(states, 0, game.rules.record, 4), np.random.default_rng(1)
    sheet, shape = (sample_triangles(surface, 40_000, rng) for surface in (triangles, target.triangles))
    expected = 0.5 * (cKDTree(shape).query(sheet)[0].mean() + cKDTree(sheet).query(shape)[0].mean())
    assert evaluator.measure(states, 0, 4, "mean") == pytest.approx(expected, abs=0.02)


def test_the_mean_has_no_bound_and_its_score_is_the_best_angle_s() -> None:
    game, moves = known_pyramid()
    states = game.replay_moves(moves)
    for weight in (0.0, 0.01):
        evaluator = bind(ShapeObjective(pyramid(), "mean", compactness=weight), game)
        assert evaluator.bound(states, evaluator.new_memos(1), 0) == math.inf
        vertices = game.sheet(states).points
        values = [
            -evaluator.measure(states, 0, k, "mean") - weight * np.linalg.norm(vertices[k], axis=1).max()
            for k in range(len(vertices))
        ]
        found = evaluator.score(states, evaluator.new_memos(1), 0)
        assert found.angle == int(np.argmax(values))
        assert found.value == pytest.approx(max(values), abs=1e-12)
        assert evaluator.exact_value(states, evaluator.new_memos(1), 0) == pytest.approx(max(values), abs=1e-12)
        above = evaluator.score(states, evaluator.new_memos(1), 0, max(values) + 1e-9)
        assert above.value == -math.inf


def random_states(game: Game, seed: int, want: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    out = []
    while len(out) < want:
        states = game.new_states()
        legal = game.legal(states)
        while len(legal) and states["n_extensions"][0] < 6:
            legal = game.play(states, int(rng.choice(legal)))
        if states["n_extensions"][0] > 0 and not game.is_penalised(states):
            out.append(states)
    return out


def brute_force(game: Game, states: np.ndarray, target: Target, solid: bool) -> tuple[float, float]:
    """d→ and the whole distance, the best over the angles, from dense samples of the target."""
    cloud = target.samples(0.03)
    sheet = game.sheet(states)
    best_stray, best = math.inf, math.inf
    for points in sheet.points:
        away = cKDTree(cloud).query(points)[0]
        if solid:  # the cube of edge 2 on z = 0
            within = (np.abs(points[:, :2]) < 1).all(axis=1) & (points[:, 2] > 0) & (points[:, 2] < 2)
            away[within] = 0.0
        weights = np.array([(i, j, 40 - i - j) for i in range(41) for j in range(41 - i)]) / 40
        folded = np.einsum("wc,tcj->twj", weights, points[sheet.triangles]).reshape(-1, 3)
        covered = cKDTree(folded).query(cloud)[0]
        best_stray = min(best_stray, away.max())
        best = min(best, max(away.max(), covered.max()))
    return best_stray, best


@pytest.mark.parametrize("symmetry", GROUPS)
def test_against_brute_force_for_every_symmetry(symmetry: str) -> None:
    """The cube has every symmetry, so each group takes its own shortcut; the truth takes none."""
    game = Game(9, symmetry, Square(1), max_crease_length=3)
    evaluator = bind(ShapeObjective(cube()), game)
    for states in random_states(game, 1, 4):
        memos = evaluator.new_memos(1)
        strays, distance = brute_force(game, states, cube(), solid=True)
        assert evaluator.bound(states, memos, 0) == pytest.approx(-strays, abs=0.03)
        assert evaluator.score(states, memos, 0).value == pytest.approx(-distance, abs=0.06)


def test_an_asymmetric_target_is_measured_on_every_image() -> None:
    """A tilted square under symmetry xyd: all eight images of a vertex stand at different distances."""
    corners = np.array([[-1.0, -1, 0], [3, -1, 1], [3, 2, 1], [-1, 2, 0]])
    target = Target("tilted", corners, np.array([[0, 1, 2], [0, 2, 3]]), False)
    game = Game(9, "xyd", Square(1))
    evaluator = bind(ShapeObjective(target), game)
    for states in random_states(game, 2, 3):
        strays, distance = brute_force(game, states, target, solid=False)
        memos = evaluator.new_memos(1)
        assert evaluator.bound(states, memos, 0) == pytest.approx(-strays, abs=0.03)
        assert evaluator.score(states, memos, 0).value == pytest.approx(-distance, abs=0.08)


@pytest.mark.parametrize("target", [bowl, cube])
@pytest.mark.parametrize("distance", ["vertex", "surface", "sampled"])
def test_a_bound_is_never_below_what_a_continuation_reaches(distance: str, target: Callable[[], Target]) -> None:
    game = Game(13, "xyd", Square("choose"), max_crease_length=2.9)
    evaluator = bind(ShapeObjective(target(), distance, tolerance=0.05, samples=500), game)
    rng = np.random.default_rng(0)
    for _ in range(8):
        states, memos, bounds = game.new_states(), evaluator.new_memos(1), []
        legal = game.legal(states)
        while len(legal):
            legal = game.play(states, int(rng.choice(legal)))
            bounds.append(evaluator.bound(states, memos, 0))
        assert all(later <= earlier for earlier, later in pairwise(bounds))
        if not game.is_penalised(states):
            assert evaluator.score(states, memos, 0).value <= bounds[-1] + 1e-9


def test_knowing_what_to_beat_changes_nothing_above_it() -> None:
    game = Game(13, "xy", Square(1), max_crease_length=2.9)
    evaluator = bind(ShapeObjective(bowl()), game)
    for states in random_states(game, 3, 8):
        full = evaluator.score(states, evaluator.new_memos(1), 0)
        assert evaluator.score(states, evaluator.new_memos(1), 0, full.value - 1e-6) == full
        assert evaluator.score(states, evaluator.new_memos(1), 0, full.value + 1e-6).value <= full.value + 1e-6


@pytest.mark.parametrize(
    ("target", "symmetry", "options"),
    [
        (bowl, "xyd", {}),
        (cube, "none", {}),  # closed, and every image is measured
        (bowl, "xy", {"compactness": 0.1}),
        (cube, "xy", {"distance": "sampled", "samples": 300}),
    ],
)
def test_the_exact_value_is_the_scores(target: Callable[[], Target], symmetry: str, options: dict[str, Any]) -> None:
    """Whether nothing, the start or everything was measured before; the notes stay as they are."""
    game = Game(13, symmetry, Square(1), max_crease_length=2.9)
    evaluator = bind(ShapeObjective(target(), **options), game)
    several = 0
    for states in random_states(game, 3, 12):
        value = evaluator.score(states, evaluator.new_memos(1), 0).value
        begun, full = evaluator.new_memos(1), evaluator.new_memos(1)
        evaluator.bound(game.new_states(), begun, 0)
        evaluator.bound(states, full, 0)
        for memos in (evaluator.new_memos(1), begun, full):
            before = memos.copy()
            assert evaluator.exact_value(states, memos, 0) == value
            assert (memos == before).all()
        several += int(begun["measured"][0]) < int(full["measured"][0])
    assert several > 5


def test_objects_with_a_score_are_objectives() -> None:
    class Height:
        def score(self, sheet: object) -> float:
            return float(sheet.points[-1, :, 2].max())  # type: ignore[attr-defined]

    game, moves = known_pyramid()
    states = game.replay_moves(moves)
    evaluator = bind(Height(), game)
    result = evaluator.score(states, evaluator.new_memos(1), 0)
    assert result == Score(pytest.approx(3 * math.sin(1.884)), int(states["reach"][0]) - 1)
    assert evaluator.bound(states, evaluator.new_memos(1), 0) == math.inf


def test_what_is_no_objective_is_refused() -> None:
    with pytest.raises(InputError, match="score"):
        bind(object(), Game(9, "xy", Square(1)))
    with pytest.raises(InputError, match=r"objective\.distance"):
        ShapeObjective(cube(), "euclid")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="target"):
        ShapeObjective(None)  # type: ignore[arg-type]
