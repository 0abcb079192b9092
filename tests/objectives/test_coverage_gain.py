"""What a sheet covers, kept up to date move by move, against all distances measured from scratch."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.state import SELECTION, States
from origami_lab.geometry.bvh import build_bvh, distances
from origami_lab.objectives.coverage_gain import Coverage, cover_panels, new_coverage
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shape_kernels import folded_triangles_of
from origami_lab.targets.solids import bowl
from tests.growing import GAMES, grown, make

DISTANCE = 0.8


def far_samples(game: Game, states: States, k: int, coverage: Coverage, distance: float) -> set[int]:
    """From scratch: the samples further than that from every triangle of the folded sheet."""
    triangles = folded_triangles_of(states, 0, game.rules.record, k)
    points = coverage.samples.triangles[:, 0].copy()
    found = distances(build_bvh(triangles), points)
    near = np.abs(found - distance) < 1e-9  # either answer is right
    return set(np.flatnonzero((found > distance) & ~near).tolist())


def samples_of(game: Game) -> Coverage:
    return new_coverage(ShapeObjective(bowl()).bind(game).compiled_cover)


def check_sets(coverage: Coverage) -> None:
    assert np.array_equal(np.sort(coverage.order), np.arange(len(coverage.order)))
    assert np.array_equal(coverage.order[coverage.where], np.arange(len(coverage.order)))


@pytest.mark.parametrize("name", GAMES)
def test_gains_add_up_and_are_undone(name: str) -> None:
    """Move by move to what a fresh look finds; and back, the latest first, to exactly the sets before."""
    game, rng = make(name), np.random.default_rng(3)
    coverage = samples_of(game)
    total = len(coverage.order)
    gains = 0
    for number in range(100):
        if number >= 5 and gains > 100:
            break
        states = grown(game, rng, 1)
        k = int(rng.integers(int(states["reach"][0])))
        left = int(cover_panels(states[0], game.rules.record[0], k, 0, coverage, DISTANCE, total))
        history: list[tuple[int, NDArray[np.int32]]] = [(left, np.sort(coverage.order[:left]))]
        for _ in range(6):
            triangles, before = int(states["n_triangles"][0]), states.copy()
            grown_further(game, states, rng)
            if int(states["reach"][0]) <= k:
                copy_to(states, 0, before, 0)
                break
            left = int(cover_panels(states[0], game.rules.record[0], k, triangles, coverage, DISTANCE, left))
            check_sets(coverage)
            gains += history[-1][0] - left
            history.append((left, np.sort(coverage.order[:left])))
            if int(states["n_triangles"][0]):
                far = far_samples(game, states, k, coverage, DISTANCE)
                assert far <= set(coverage.order[:left].tolist())
                assert len(far) >= left - 3
        for left, before_it in reversed(history):
            assert np.array_equal(np.sort(coverage.order[:left]), before_it)
    assert gains > 100


def grown_further(game: Game, states: States, rng: np.random.Generator) -> None:
    """One more random move, if one is found."""
    before = states.copy()
    for _ in range(50):
        legal = game.legal(states)
        while len(choices := legal[legal != 3 * game.rules.points]):
            legal = game.play(states, int(rng.choice(choices)))
            if int(states["phase"][0]) == SELECTION:
                break
        if int(states["phase"][0]) == SELECTION and int(states["status"][0]) == 0:
            return
        copy_to(states, 0, before, 0)
