"""Polishing designs whose best is known in closed form, and what must hold of any."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from origami_lab.geometry.groups import GROUPS
from origami_lab.objectives.shape import Distance, ShapeObjective
from origami_lab.objectives.table import TableObjective
from origami_lab.polish import Polished, polish_design
from origami_lab.targets.solids import bowl
from origami_lab.targets.solids import cube as cube_target
from origami_lab.targets.solids import pyramid as pyramid_target
from origami_lab.targets.target import Target
from tests.known_designs import game_moves as known
from tests.polish.designs import actions_of, cube, pyramid, random_designs

CLOSED = math.degrees(math.acos(-1 / 3))
"""The driving angle at which the pyramid's flaps meet at the apex."""


def polish_pyramid(steps: int = 400, distance: Distance = "vertex", **settings: Any) -> Polished:
    game, actions = pyramid()
    objective = ShapeObjective(pyramid_target(), distance)
    return polish_design(game, objective, actions, 5, steps=steps, **settings)


def test_the_pyramid_becomes_exact() -> None:
    """On the grid it is −3·sin(arccos(−1/3) − 1.884) at best; off it the flaps meet at the apex."""
    polished = polish_pyramid()
    assert polished.returns_before["return"] == pytest.approx(-3 * math.sin(math.radians(CLOSED) - 1.884), abs=1e-9)
    assert -1e-3 < polished.returns["return"] <= 0
    assert polished.driving_angle == pytest.approx(CLOSED, abs=0.05)
    assert polished.certificate.verdict == "certified"
    assert polished.design.driving_angles[-1] == pytest.approx(math.radians(polished.driving_angle))


def test_the_cube_becomes_exact() -> None:
    """Its faces close at 90°; the grid's angle is 1.57 rad, which leaves 0.00225 at the lid's free edge."""
    game, actions = cube()
    angle = int(np.argmin(np.abs(game.angles - np.pi / 2)))
    polished = polish_design(game, ShapeObjective(cube_target()), actions, angle, steps=800)
    assert polished.returns_before["return"] == pytest.approx(-0.00225, abs=1e-5)
    assert polished.returns["return"] > polished.returns_before["return"] / 2


@pytest.mark.parametrize("distance", ["vertex", "surface", "sampled"])
def test_never_worse_by_the_objective_s_own_measure(distance: Distance) -> None:
    polished = polish_pyramid(200, distance)
    assert polished.returns["return"] == polished.returns[f"return_{distance}"]
    assert polished.returns["return"] >= polished.returns_before["return"]


def test_the_angle_stays_within_its_limits() -> None:
    game, actions = pyramid(driving_angle_max=109.0)  # the exact pyramid needs 109.47°
    objective = ShapeObjective(pyramid_target())
    free = polish_design(game, objective, actions, 9, steps=200)
    assert free.driving_angle <= 109.0
    game, actions = pyramid(driving_angle_fixed=100.0)
    fixed = polish_design(game, objective, actions, 9, steps=200)
    assert fixed.driving_angle == pytest.approx(100.0, abs=1e-12)


def test_the_same_seed_gives_the_same_bits_and_another_one_another_design() -> None:
    one, same, other = (polish_bowl(seed, steps=1200) for seed in (1, 1, 2))
    assert np.array_equal(one.design.folded, same.design.folded)
    assert one.returns == same.returns
    assert not np.array_equal(one.design.vertices, other.design.vertices)


def polish_bowl(seed: int = 0, compactness: float = 0.0, steps: int = 700) -> Polished:
    game = Game(25, "xyd", Square("choose"), max_crease_length=2.9)
    objective = ShapeObjective(bowl(), compactness=compactness)
    scored = []
    for actions in random_designs(game, 6, seed=4):
        states = game.replay(actions)
        evaluator = objective.bind(game)
        score = evaluator.score(states, evaluator.new_memos(1), 0)
        scored.append((score.value, score.angle, actions))
    _, angle, actions = max(scored)
    return polish_design(game, objective, actions, angle, steps=steps, seed=seed)


def test_a_symmetric_design_stays_symmetric() -> None:
    design = polish_bowl().design
    for matrix in GROUPS["xyd"].matrices:
        lifted = np.eye(3)
        lifted[:2, :2] = matrix
        for points, image in ((design.vertices, design.vertices @ matrix.T), (design.folded[-1], None)):
            image = points @ lifted.T if image is None else image
            nearest = np.abs(image[:, None, :] - points[None, :, :]).max(axis=2).min(axis=1)
            assert nearest.max() < 1e-12


def test_creases_stay_within_their_length_and_panels_keep_their_shape() -> None:
    design = polish_bowl().design
    inner = ~design.boundary & ~design.driven
    u, v = design.edges[inner].T
    assert np.linalg.norm(design.vertices[u] - design.vertices[v], axis=1).max() <= 2.9 + 1e-9
    for a, b in design.edges:
        flat = np.linalg.norm(design.vertices[a] - design.vertices[b])
        assert np.linalg.norm(design.folded[:, a] - design.folded[:, b], axis=1) == pytest.approx(flat, abs=1e-9)


def test_compactness_counts() -> None:
    polished = polish_bowl(compactness=0.1, steps=400)
    for returns, points in ((polished.returns, polished.design.folded[-1]),):
        penalty = 0.1 * np.linalg.norm(points, axis=1).max()
        assert returns["return"] == pytest.approx(returns["return_vertex"] - penalty, abs=1e-9)
    assert polished.returns["return"] > polished.returns_before["return"]


def test_a_target_without_the_game_s_symmetry_is_measured_whole() -> None:
    """A flat square off the centre: its far corner decides, whatever part of the board is playable."""
    corners = np.array([(-1, -1, 0), (2, -1, 0), (2, 1, 0), (-1, 1, 0)], dtype=float)
    target = Target("plate", corners, np.array([(0, 1, 2), (0, 2, 3)]), closed=False)
    game, actions = pyramid()
    polished = polish_design(game, ShapeObjective(target), actions, 0, steps=300)
    objective = ShapeObjective(target)
    state = game.replay(actions)
    measured = -objective.bind(game).measure(state, 0, 0, "vertex")
    assert polished.returns_before["return_vertex"] == pytest.approx(measured, abs=1e-9)
    assert polished.returns["return"] > polished.returns_before["return"]


def test_a_time_limit_ends_it_and_is_recorded() -> None:
    polished = polish_pyramid(10**6, seconds=1e-3)
    assert not polished.whole
    assert polished.steps < 10**6
    assert polished.returns["return"] >= polished.returns_before["return"]


def test_what_cannot_be_polished_is_refused_in_one_line() -> None:
    game, actions = known.chair(collisions=True)[0], ()
    with pytest.raises(InputError, match="TableObjective: cannot be polished"):
        polish_design(game, TableObjective(), actions, 0)
    for wrong in ({"steps": 0}, {"seed": -1}, {"seconds": 0.0}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            polish_pyramid(**({"steps": 10} | wrong))


def test_what_is_not_certified_to_begin_with_is_refused() -> None:
    """Without the rule against collisions the pyramid may be closed beyond its apex."""
    game = Game(9, "xy", Square(1), collisions=False)
    with pytest.raises(InputError, match="certified before"):
        polish_design(game, ShapeObjective(pyramid_target()), actions_of(game, known.pyramid()[1]), 6, steps=10)
