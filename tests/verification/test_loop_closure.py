"""The closure of loops and systems with it, against finite differences and dense linear algebra."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from origami_lab.verification.claimed_states import claims, held_flat
from origami_lab.verification.continuation import Motion
from origami_lab.verification.flat_sheet import build_sheet
from origami_lab.verification.fold_document import document_of
from origami_lab.verification.linkage import Linkage
from origami_lab.verification.plane_graph import Array
from origami_lab.verification.singular_values import rank
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import known_chair, known_design

ROOT = Path(__file__).parents[2]
LARGE = "results/paper/designs/bowl-dfts-seed4.fold"
DESIGNS = ["miura", "pyramid", "chair", "cube", LARGE]


def folded(name: str) -> tuple[Motion, Array, float]:
    """The motion of a design with its flat edges held, and its last fold angles and driving angle."""
    made = {"pyramid": designs.pyramid, "chair": lambda: known_chair(20.0, 40.0, 60.0), "miura": designs.miura}
    document = document_of(ROOT / LARGE if name == LARGE else made[name]() if name in made else known_design(name))
    sheet = build_sheet(document.flat, document)
    states = claims(sheet, document)
    last = max(states, key=lambda claim: claim.driving)
    drive = np.where(document.driven, np.sign(last.rho), 0.0)
    return Motion(Linkage(sheet), held_flat(sheet, document, states), drive), last.rho, last.driving


@pytest.mark.parametrize("name", DESIGNS)
def test_the_jacobian_is_the_derivative(name: str) -> None:
    motion, rho, _ = folded(name)
    linkage = motion.linkage
    jacobian = linkage.closure(rho).jacobian(motion.free)
    for at, e in enumerate(motion.free):
        ends = [linkage.closure(rho + step * (np.arange(len(rho)) == e)).error for step in (1e-5, -1e-5)]
        np.testing.assert_allclose(jacobian[:, at], (ends[0] - ends[1]).ravel() / 2e-5, atol=1e-9)


@pytest.mark.parametrize("name", DESIGNS)
def test_a_single_turn_opens_its_loops_by_as_much(name: str) -> None:
    """A loop whose one crease is turned too far by an angle fails to close by that angle."""
    motion, rho, _ = folded(name)
    linkage = motion.linkage
    assert linkage.closure(rho).angle.max() < 1e-10
    for e in motion.free[:5]:
        opened = linkage.closure(rho + 0.3 * (np.arange(len(rho)) == e)).angle
        around = [e in fan.edges for fan in linkage.sheet.fans]
        np.testing.assert_allclose(opened, np.where(around, 0.3, 0.0), atol=1e-9)


@pytest.mark.parametrize("name", DESIGNS)
def test_solutions_are_those_of_dense_least_squares(name: str) -> None:
    motion, rho, _ = folded(name)
    linkage = motion.linkage
    closure, free, rng = linkage.closure(rho), motion.free, np.random.default_rng(1)
    jacobian = closure.jacobian(free)
    values = np.linalg.svd(jacobian, compute_uv=False)
    assert closure.smallest(free) == pytest.approx(values[-1], rel=1e-5)
    within = (jacobian @ rng.normal(size=len(free))).reshape(-1, 3)
    for right, exact in ((within, 1e-13), (rng.normal(size=within.shape), 1e-9)):
        expected = np.linalg.lstsq(jacobian, right.ravel(), rcond=None)[0]
        found = closure.solve(free, right)
        assert np.abs(found - expected).max() <= exact * values[0] / values[-1] * np.abs(expected).max()
    speed = rng.normal(size=len(rho))
    every = np.arange(len(rho))
    np.testing.assert_allclose(closure.change(speed).ravel(), closure.jacobian(every) @ speed, atol=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
def test_in_the_flat_sheet_the_nearest_is_found_all_the_same(name: str) -> None:
    """There the Jacobian has no full rank: all creases turn about lines in one plane."""
    motion, rho, _ = folded(name)
    linkage = motion.linkage
    closure, free, rng = linkage.closure(0.0 * rho), motion.free, np.random.default_rng(2)
    jacobian, right = closure.jacobian(free), rng.normal(size=(len(linkage.sheet.fans), 3))
    found = closure.solve(free, right)
    expected = np.linalg.lstsq(jacobian, right.ravel(), rcond=1e-11)[0]
    left, least = (np.linalg.norm(jacobian @ x - right.ravel()) for x in (found, expected))
    assert left == pytest.approx(least, rel=1e-9)


@pytest.mark.parametrize("name", DESIGNS)
def test_ranks_and_the_spaces_they_leave(name: str) -> None:
    motion, rho, _ = folded(name)
    linkage = motion.linkage
    creases = np.flatnonzero(linkage.sheet.inner)
    for angles in (rho, 0.0 * rho):
        closure = linkage.closure(angles)
        jacobian, found = closure.jacobian(creases), rank(closure, creases)
        assert found.rank == np.linalg.matrix_rank(jacobian, tol=1e-8)
        assert np.abs(jacobian @ found.directions.T).max(initial=0.0) < 1e-7
        assert np.abs(found.stresses @ jacobian).max(initial=0.0) < 1e-7
        assert len(found.directions) - len(found.stresses) == jacobian.shape[1] - jacobian.shape[0]
        right = jacobian @ np.random.default_rng(3).normal(size=len(creases))
        expected = np.linalg.pinv(jacobian, rcond=1e-8) @ right
        np.testing.assert_allclose(found.solve(right), expected, atol=1e-7 * np.abs(expected).max())
    # the flat sheet: every loop may turn about any line in the plane, none about its normal
    assert found.rank <= 2 * len(linkage.sheet.fans)


@pytest.mark.parametrize("name", DESIGNS)
def test_panels_meet_and_move_as_their_speeds_say(name: str) -> None:
    motion, rho, driving = folded(name)
    linkage = motion.linkage
    here = motion.solve(driving, rho)
    states = [motion.solve(driving + step, here.rho + step * here.speed) for step in (-1e-5, 0.0, 1e-5)]
    for index, face in enumerate(linkage.sheet.faces):
        flat = linkage.flat[list(face)]
        there = [flat @ state.turn[index].T + state.shift[index] for state in states]
        arm = flat @ here.turn[index].T
        speed = np.cross(here.spin[index], arm) + here.drift[index]
        np.testing.assert_allclose(speed, (there[2] - there[0]) / 2e-5, atol=1e-6)
        # each vertex is where all of its panels say
        np.testing.assert_allclose(there[1], linkage.vertices(here)[list(face)], atol=1e-9)
