"""Polish and simplify for every kind of shape task, start and symmetry: certified, no worse, and measured anew."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from trimesh.triangles import closest_point

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.fold_format.writer import write_fold
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.geometry.groups import GROUPS
from origami_lab.polish import Polished, PolishedDesign, polish_design, simplify_design
from origami_lab.search import NeighbourhoodSearch
from origami_lab.search.problem import Outcome, Problem
from origami_lab.verification.verify_design import verify

ROOF = """\
v -2 -2 0
v 2 -2 0
v 2 2 0
v -2 2 0
v -2 0 1
v 2 0 1
f 1 2 6
f 1 6 5
f 3 4 5
f 3 5 6
"""
"""A roof without gables: symmetric in x and y, open."""
DISH = {
    "game": {"symmetry": "xyd", "start": {"_target_": "origami_lab.game.Square", "size": "choose"}},
    "moves": [
        {"kind": "place", "value": 1, "sign": 1},
        {"kind": "extend", "leaf": [-1, 1], "mode": 1, "a": [0, 3], "b": [-3, 0], "c": [-2, 2]},
    ],
}
TASKS = [
    "target=pyramid",
    "target=cube",
    "target=bowl",
    "target=face",
    "target=mesh target.path=roof.obj symmetry=none start=crease",
    "target=mesh target.path=roof.obj symmetry=x",
    "target=mesh target.path=roof.obj target.scale=2 target.rotate=[0,0,30] symmetry=y",
    "target=bowl symmetry=none",
    "target=bowl symmetry=xyd start=file start.path=dish.json",
    "target=face objective.distance=surface",
    "target=bowl objective.distance=sampled symmetry=y start=crease",
    "target=pyramid driving_angle.fixed=60",
    "target=bowl objective.compactness=0.1 symmetry=xy",
]
STEPS = 90


def found(words: str) -> tuple[Parts, Outcome]:
    """The parts of a task and a design that a short search finds."""
    parts = build_parts(compose_settings(words.split()))
    problem = Problem(parts.game, parts.objective, budget=1500)
    NeighbourhoodSearch().search(problem, np.random.default_rng(5))
    outcome = problem.outcome()
    assert outcome.succeeded
    return parts, outcome


@pytest.mark.parametrize("words", TASKS)
def test_what_comes_of_it_is_certified_and_measures_what_it_says(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("roof.obj").write_text(ROOF)
    Path("dish.json").write_text(json.dumps(DISH))
    parts, outcome = found(words)
    game, objective = parts.game, parts.objective
    polished = polish_design(game, objective, outcome.actions, outcome.angle, steps=STEPS, seed=1)
    assert polished.returns_before["return"] == pytest.approx(outcome.value, abs=1e-9)
    assert polished.returns["return"] >= polished.returns_before["return"]
    assert polished.driving_angle <= math.degrees(game.angles[-1]) + 1e-9
    angle = float(polished.design.driving_angles[-1])
    simple = simplify_design(PolishedDesign(polished.board, angle, objective), 0.05)
    assert simple.value >= polished.returns["return"] - 0.05
    for name, design in (("polished", polished.design), ("simplified", simple.design)):
        write_fold(tmp_path / f"{name}.fold", design)
        assert verify(tmp_path / f"{name}.fold").verdict == "certified"
        assert_symmetric(design, game.symmetry.name)
        assert (np.abs(design.vertices) <= np.array(game.rules.half) + 1e-9).all()
    assert_measured(parts, polished)


def assert_symmetric(design: CreasePattern, symmetry: str) -> None:
    """Every vertex has its images, flat and folded alike."""
    for matrix in GROUPS[symmetry].matrices:
        images = np.column_stack(
            [design.vertices @ matrix.T, design.folded[-1, :, :2] @ matrix.T, design.folded[-1, :, 2]]
        )
        own = np.column_stack([design.vertices, design.folded[-1]])
        assert np.abs(images[:, None] - own[None]).max(axis=2).min(axis=1).max() < 1e-12


def assert_measured(parts: Parts, polished: Polished) -> None:
    """The vertex distance from the design's own folded coordinates, by trimesh, triangle by triangle."""
    design, objective = polished.design, parts.objective
    assert parts.target is not None
    points = design.folded[-1]
    sheet, samples = points[design.triangles], objective.cover.triangles[:, 0]
    covered = max_distance(samples[::5], sheet)  # some of them: all are no nearer
    assert covered <= -polished.returns["return_vertex"] + 1e-9
    if not parts.target.closed:
        strays = max_distance(points, parts.target.triangles)
        assert strays <= -polished.returns["return_vertex"] + 1e-9
        assert max(strays, max_distance(samples, sheet)) == pytest.approx(-polished.returns["return_vertex"], abs=1e-9)


def max_distance(points: np.ndarray, triangles: np.ndarray) -> float:
    """How far the furthest of (n, 3) points is from (T, 3, 3) triangles."""
    nearest = np.full(len(points), np.inf)
    for triangle in triangles:
        closest = closest_point(np.broadcast_to(triangle, (len(points), 3, 3)), points)
        nearest = np.minimum(nearest, np.linalg.norm(closest - points, axis=1))
    return float(nearest.max())
