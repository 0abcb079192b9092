"""What folds is certified: the known designs, closed forms, and what the game makes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

import origami_lab
from origami_lab.fold_format.writer import write_fold
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start
from origami_lab.search.dense_check import certified_reach
from origami_lab.verification.continuation import Motion
from origami_lab.verification.flat_sheet import build_sheet
from origami_lab.verification.fold_document import document_of
from origami_lab.verification.linkage import Linkage
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import known_chair, known_design, strip


@pytest.mark.parametrize(("name", "creases", "sources"), [("pyramid", 16, 4), ("cube", 30, 6)])
def test_known_designs(name: str, creases: int, sources: int) -> None:
    certificate = origami_lab.verify(known_design(name))
    assert certificate.exit_code == 0, certificate.words()
    numbers = certificate["degrees of freedom"].numbers
    assert (numbers["creases"], numbers["freedoms"], numbers["driven"]) == (creases, sources, sources)
    assert numbers["freedoms_when_driven"] == 0
    assert certificate["panels rigid"].numbers["largest_deviation"] < 1e-10
    assert certificate["motion"].numbers["largest_residual"] < 1e-9


def test_the_chair_up_to_86_degrees() -> None:
    certificate = origami_lab.verify(known_chair(20.0, 40.0, 60.0, 80.0, 86.0))
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["motion"].numbers["to"] == pytest.approx(86.0)


def test_the_chair_at_90_degrees_reaches_its_seat() -> None:
    design = known_chair()
    certificate = origami_lab.verify(design)
    assert certificate.exit_code == 1
    # two spikes fold flat and reach the seat at once
    panels = [{tuple(design.vertices[v]) for v in design.panels[panel]} for panel in certificate.panels]
    assert {(2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0), (2.0, -2.0)} in panels or (0.0, -3.0) in set.intersection(*panels)
    assert 86.85 < certificate.angle < 87.01
    assert "panels" in certificate.reason


ANGLES = np.radians([7.0, 31.0, 64.0, 100.0, 140.0, 170.0])
SECTORS = [(alpha, beta, mode) for alpha, beta in ((70.0, 40.0), (110.0, 55.0), (85.0, 20.0)) for mode in "AB"] + [
    (gamma, gamma, "B") for gamma in (30.0, 60.0)
]  # of the Miura's other mode two collinear creases fold alone


@pytest.mark.parametrize(("alpha", "beta", "mode"), SECTORS)
def test_the_solver_agrees_with_closed_forms(alpha: float, beta: float, mode: str) -> None:
    """Flat-foldable vertices of degree 4: tan(ρ₁/2) = k·tan(ρ₀/2), k of the mode (Miura: α = β, mode B)."""
    design = designs.degree_four(alpha, beta, mode)
    document = document_of(design)
    linkage = Linkage(build_sheet(design.vertices, document))
    motion = Motion(linkage, np.zeros(len(design.edges), dtype=bool), 1.0 * design.driven)
    state = motion.solve(design.driving_angles[0], design.fold_angles[0])
    a, b = np.radians([alpha, beta])
    factor = np.sin((a + b) / 2) / np.sin((a - b) / 2) if mode == "A" else -np.cos((a + b) / 2) / np.cos((a - b) / 2)
    by_tip = {int(max(edge)): e for e, edge in enumerate(design.edges) if min(edge) == 0}
    for angle in ANGLES:
        state = motion.walk(state, float(angle), 1000)[-1]
        other = 2 * math.atan(factor * math.tan(angle / 2))
        expected = [angle, other, -angle, other] if mode == "A" else [angle, other, angle, -other]
        np.testing.assert_allclose([state.rho[by_tip[v]] for v in (1, 2, 3, 4)], expected, atol=1e-9)
        # speeds: the derivative of the closed form
        slope = factor * (1 + math.tan(angle / 2) ** 2) / (1 + (factor * math.tan(angle / 2)) ** 2)
        assert state.speed[by_tip[2]] == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("gamma", [30.0, 60.0, 80.0])
def test_a_miura_cell(gamma: float) -> None:
    certificate = origami_lab.verify(designs.miura(gamma))
    assert certificate.exit_code == 0, certificate.words()
    assert certificate["flat-foldable"].numbers == {"vertices": 1, "kawasaki_fails": [], "maekawa_fails": []}
    assert certificate["degrees of freedom"].numbers["freedoms"] == 1


def test_states_in_space() -> None:
    """Positions and velocities between the states are those of a closed form, moved as a whole."""
    design = designs.pyramid()
    document = document_of(design)
    sheet = build_sheet(design.vertices, document)
    linkage = Linkage(sheet)
    motion = Motion(linkage, np.zeros(len(design.edges), dtype=bool), 1.0 * design.driven)
    state = motion.walk(motion.solve(design.driving_angles[0], design.fold_angles[0]), 1.2, 1000)[-1]
    points = linkage.vertices(state)
    tips = points[4:8]
    width, height = 2 * (1 + 3 * math.cos(1.2)), 3 * math.sin(1.2)
    assert np.linalg.norm(tips[0] - tips[2]) == pytest.approx(width)
    np.testing.assert_allclose(tips[:, 2], height)  # the square stays in z = 0
    later = linkage.vertices(motion.walk(state, 1.2 + 1e-6, 10)[-1])
    for panel, face in enumerate(sheet.faces):
        ring = list(face)
        arm = points[ring] - state.shift[panel]
        np.testing.assert_allclose(
            np.cross(state.spin[panel], arm) + state.drift[panel], (later[ring] - points[ring]) / 1e-6, atol=1e-4
        )


def test_a_strip_has_no_interior_vertex() -> None:
    certificate = origami_lab.verify(strip((1.0, 2.0, 1.0), (1, -1), [30.0, 120.0, 179.0]))
    assert certificate.exit_code == 0
    assert certificate["loops close"].numbers["vertices"] == 0
    assert certificate["degrees of freedom"].numbers["freedoms"] == 2


KINDS: list[tuple[str, Start]] = [
    ("none", Square(1)), ("y", Square(1)), ("x", Square(2)), ("xy", Square(1)), ("xyd", Square(1)), ("none", Crease(0)),
    ("y", Crease(0)),
]  # fmt: skip


HEXAGON = ((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1))
ANYWHERE: list[tuple[str, Start]] = [
    ("none", Rectangle()), ("y", Rectangle()), ("xyd", Square("choose", "choose")), ("none", Crease(ends="choose")),
    ("x", Crease(ends="choose", stays="lower")), ("none", Panel(HEXAGON, (1, -1, 1, 0, 0, 1))),
    ("xy", Panel(HEXAGON, (0, 0, 1, 0, 0, 1))),
]  # fmt: skip


def random_designs(
    count: int,
    rng: np.random.Generator,
    *,
    collisions: bool,
    kinds: Sequence[tuple[str, Start]] = KINDS,
    sources: bool | str = True,
) -> Iterator[tuple[Game, tuple[int, ...], int, int]]:
    """Games, actions, and up to which angle each folds at all and, checked densely by the game, without collision.

    With ``collisions`` the game's ten angles are free of them and the dense check agrees; without, it does not.
    """
    games = [
        [
            Game(13, symmetry, start, max_crease_length=4.0, collisions=on, source_action=sources)
            for on in (collisions, True)
        ]
        for symmetry, start in kinds
    ]
    made = tried = 0
    while made < count:
        game, checking = games[tried % len(games)]
        tried += 1
        states = game.new_states(1)
        game.clear(states)
        legal = game.legal(states)
        for _ in range(int(rng.integers(6, 60))):
            if not len(legal):
                break
            legal = game.play(states, int(rng.choice(legal)))
        if states["n_extensions"][0] < 1 or states["reach"][0] < 1:
            continue
        actions = game.finished_actions(states)
        reach = int(game.replay(actions)["reach"][0])
        free = certified_reach(checking, actions, reach)
        if reach and free and (free == reach) == collisions:
            made += 1
            yield game, actions, reach, free


@pytest.mark.slow
def test_a_hundred_random_patterns() -> None:
    sizes = []
    for game, actions, reach, _ in random_designs(100, np.random.default_rng(0), collisions=True):
        design = game.motion(actions, game.angles[:reach], {})
        sizes.append(len(design.panels))
        certificate = origami_lab.verify(design)
        assert certificate.exit_code == 0, f"{actions}\n{certificate.words()}"
    assert max(sizes) > 40


@pytest.mark.slow
def test_random_patterns_from_any_start_with_sources_anywhere() -> None:
    found = random_designs(35, np.random.default_rng(0), collisions=True, kinds=ANYWHERE, sources="boundary")
    freedoms = set()
    for game, actions, reach, _ in found:
        certificate = origami_lab.verify(game.motion(actions, game.angles[:reach], {}))
        assert certificate.exit_code == 0, f"{game.moves(actions)}\n{certificate.words()}"
        freedoms.add(certificate["degrees of freedom"].numbers["freedoms"])
    assert len(freedoms) > 1  # all sources are driven by one angle


@pytest.mark.slow
def test_random_patterns_that_collide() -> None:
    """With collisions ignored by the game the certificate finds them between the same angles as its dense check."""
    agreed = 0
    for game, actions, reach, free in random_designs(12, np.random.default_rng(0), collisions=False):
        certificate = origami_lab.verify(game.motion(actions, game.angles[:reach], {}))
        assert certificate.exit_code == 1, f"{actions}\n{certificate.words()}"
        low, high = np.degrees(game.angles[free - 1]), np.degrees(game.angles[free])
        agreed += low < certificate.angle <= high + 1e-9
        assert origami_lab.verify(game.motion(actions, game.angles[:free], {})).exit_code == 0
    assert agreed >= 11  # behind a branch point the file's next state is the first that is looked at


def test_design_and_file_say_the_same(tmp_path: Path) -> None:
    design = known_design("cube")
    path = tmp_path / "cube.fold"
    write_fold(path, design)
    one, other = origami_lab.verify(design), origami_lab.verify(path)
    assert [(c.name, c.status) for c in one.checks] == [(c.name, c.status) for c in other.checks]
    assert one["clearance"].numbers["clearance"] == pytest.approx(other["clearance"].numbers["clearance"])
