"""The known designs fold as closed forms say, with one degree of freedom (design page, section 9, items 9, 10)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.moves import Move
from tests.known_designs.varied_games import CHAIR, CUBE, PYRAMID, chair_game, cube_game, pyramid_game
from tests.sheet_checks import rotation_x, rotation_z

EXACT = math.degrees(math.acos(-1 / 3))
"""Fold angle of the pyramid's base edges, degrees."""


def point(sheet: FoldedSheet, x: int, y: int) -> NDArray[np.float64]:
    """(K, 3) positions of the vertex at a board point."""
    (v,) = np.flatnonzero((sheet.flat == (x, y)).all(axis=1))
    return np.asarray(sheet.points[:, v])


def test_pyramid_at_its_best_angle() -> None:
    game = pyramid_game()
    sheet = game.sheet(game.replay_moves(PYRAMID))
    assert sheet.reach == 6
    tip = point(sheet, 0, 4)
    # a flap of height 3 turns about the edge y = 1
    np.testing.assert_allclose(tip[:, 1], 1 + 3 * np.cos(game.angles[:6]), atol=1e-12)
    np.testing.assert_allclose(tip[:, 2], 3 * np.sin(game.angles[:6]), atol=1e-12)
    gap = np.linalg.norm(tip[5] - [0, 0, math.sqrt(8)])
    assert gap == pytest.approx(2 * 3 * math.sin((math.acos(-1 / 3) - 1.884) / 2), abs=1e-12)


def test_pyramid_closes_at_the_exact_angle() -> None:
    game = pyramid_game(driving_angle_max=EXACT - 1e-3, driving_angle_count=3)
    sheet = game.sheet(game.replay_moves(PYRAMID))
    for tip in ((0, 4), (0, -4), (4, 0), (-4, 0)):
        np.testing.assert_allclose(point(sheet, *tip)[-1], [0, 0, math.sqrt(8)], atol=1e-4)


def test_cube_with_a_lid() -> None:
    game = cube_game()
    sheet = game.sheet(game.replay_moves(CUBE))
    rho = game.angles[:5]
    assert sheet.reach == 5
    expected = np.stack([-np.ones(5), 1 + 2 * np.cos(rho), 2 * np.sin(rho)], axis=1)
    np.testing.assert_allclose(point(sheet, -1, 3), expected, atol=1e-12)
    # the lid turns about the far edge of its wall by the same angle again
    lid = np.stack([-(1 + 2 * np.cos(rho) + np.cos(2 * rho)), np.ones(5), 2 * np.sin(rho) + np.sin(2 * rho)], axis=1)
    np.testing.assert_allclose(point(sheet, -4, 1), lid, atol=1e-9)


def test_chair_without_collisions() -> None:
    game = chair_game(collisions=False, driving_angle_max=math.degrees(1.57))
    sheet = game.sheet(game.replay_moves(CHAIR))
    assert sheet.reach == 10
    folded = sheet.points[-1]
    for leg in ((2.00319, 2, -4), (-2.00319, 2, -4), (2.00319, -2, -4), (-2.00319, -2, -4)):
        assert np.abs(folded - leg).max(axis=1).min() < 1e-5
    assert folded[:, 2].max() == pytest.approx(3.99199, abs=1e-5)


def test_chair_with_collisions() -> None:
    game = chair_game()
    assert int(game.replay_moves(CHAIR)["reach"][0]) == 4


DESIGNS = [(pyramid_game(), PYRAMID, 16, 12, 4), (cube_game(), CUBE, 30, 24, 6)]


@pytest.mark.parametrize(("game", "moves", "creases", "rank", "sources"), DESIGNS, ids=["pyramid", "cube"])
def test_degrees_of_freedom(game: Game, moves: list[Move], creases: int, rank: int, sources: int) -> None:
    """DOF = creases − rank of the closure Jacobian; with the source creases removed nothing is left."""
    states = game.replay_moves(moves)
    design = game.design(game.finished_actions(states))
    inner, driven = ~design.boundary, design.driven[~design.boundary]
    assert (int(inner.sum()), int(driven.sum())) == (creases, sources)
    for k in range(len(design.driving_angles)):
        jacobian = closure_jacobian(design, k)[:, inner]
        assert np.linalg.matrix_rank(jacobian, tol=1e-6) == rank
        assert np.linalg.matrix_rank(jacobian[:, ~driven], tol=1e-6) == creases - sources


def closure_jacobian(design: CreasePattern, k: int) -> NDArray[np.float64]:
    """Derivative of ∏ Rx(ρᵢ)Rz(αᵢ) at every interior vertex (3 rows each) by all fold angles (central differences)."""
    rows = []
    for v in np.flatnonzero(design.modes):
        edges = np.flatnonzero((design.edges == v).any(axis=1))
        ends = design.edges[edges].sum(axis=1) - v
        outward = design.vertices[ends] - design.vertices[v]
        heading = np.arctan2(outward[:, 1], outward[:, 0])
        order = np.argsort(heading)
        edges, heading = edges[order], heading[order]
        sectors = np.append(np.diff(heading), heading[0] + 2 * np.pi - heading[-1])
        assert np.linalg.norm(_loop(design.fold_angles[k, edges], sectors)) < 1e-9
        block = np.zeros((3, len(design.edges)))
        for i, edge in enumerate(edges):
            step = np.zeros(len(edges))
            step[i] = 1e-6
            rho = design.fold_angles[k, edges]
            block[:, edge] = (_loop(rho + step, sectors) - _loop(rho - step, sectors)) / 2e-6
        rows.append(block)
    return np.concatenate(rows)


def _loop(rho: NDArray[np.float64], sectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation vector, to first order, by which the loop around a vertex fails to close."""
    product = np.eye(3)
    for r, a in zip(rho, sectors, strict=True):
        product = product @ rotation_x(r) @ rotation_z(a)
    return np.array([product[2, 1] - product[1, 2], product[0, 2] - product[2, 0], product[1, 0] - product[0, 1]]) / 2
