"""Thin-walled solids against the sheets that they are thickened from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from trimesh.creation import box, icosphere

from origami_lab.errors import InputError
from origami_lab.parts.analysis import PartAnalysis, analyse_part
from origami_lab.targets import mesh
from origami_lab.targets.skins import find_walls


def block(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> trimesh.Trimesh:
    low, high = zip(x, y, z, strict=True)
    return box(bounds=[low, high])


def bracket(t: float) -> trimesh.Trimesh:
    return block((0, 80), (0, 50), (0, t)).union(block((0, 80), (50 - t, 50), (0, 40)))


def channel(t: float) -> trimesh.Trimesh:
    return block((-100, 100), (-30, 30), (0, 50)).difference(block((-101, 101), (t - 30, 30 - t), (t, 51)))


def lid(t: float) -> trimesh.Trimesh:
    return block((-60, 60), (-40, 40), (0, 20)).difference(block((t - 60, 60 - t), (t - 40, 40 - t), (t, 21)))


PARTS: dict[str, tuple[Callable[[float], trimesh.Trimesh], Callable[[float], float], Callable[[float], float]]] = {
    # the areas of the outer and of the inner skin
    "bracket": (bracket, lambda t: 80 * (50 + 40), lambda t: 80 * (50 + 40 - 2 * t)),
    "channel": (channel, lambda t: 200 * (60 + 2 * 50), lambda t: 200 * (60 - 2 * t + 2 * (50 - t))),
    "lid": (
        lid,
        lambda t: 120 * 80 + 2 * 20 * (120 + 80),
        lambda t: (120 - 2 * t) * (80 - 2 * t) + 2 * (20 - t) * (200 - 4 * t),
    ),
}


@settings(max_examples=12, deadline=None)
@given(
    st.sampled_from(sorted(PARTS)),
    st.floats(1.0, 3.0),
    st.integers(0, 10_000),
    st.booleans(),
    st.booleans(),
)
def test_skins_are_what_was_thickened(name: str, thickness: float, seed: int, finer: bool, rounded: bool) -> None:
    make, outer, inner = PARTS[name]
    solid = make(thickness)
    if finer:
        solid = solid.subdivide_to_size(25.0)
    rng = np.random.default_rng(seed)
    vertices = solid.vertices @ Rotation.random(random_state=int(seed)).as_matrix().T + rng.uniform(-50, 50, 3)
    precision = 0.0
    if rounded:
        vertices = vertices.astype(np.float32).astype(np.float64)
        precision = 1e-5
    faces = solid.faces[rng.permutation(len(solid.faces))]
    walls = find_walls(vertices, faces, precision)
    assert walls is not None
    areas = trimesh.Trimesh(vertices, faces, process=False).area_faces
    assert areas[walls.outer].sum() == pytest.approx(outer(thickness), rel=1e-5)
    assert areas[walls.inner].sum() == pytest.approx(inner(thickness), rel=1e-5)
    assert walls.thickness == pytest.approx(thickness, rel=0.06)
    assert not (walls.outer & walls.inner).any()


@pytest.mark.parametrize("turned", [False, True])
def test_a_curved_shell(turned: bool) -> None:
    """A cap of a hollow ball: its skins are the caps of two balls, up to their facets."""
    outer, inner, cut = 116.0, 113.0, 91.0
    shell = (
        icosphere(4, outer).difference(icosphere(4, inner)).intersection(block((-200, 200), (-200, 200), (cut, 200)))
    )
    vertices = shell.vertices @ Rotation.from_euler("xyz", [0.3, 0.4, 0.5]).as_matrix() if turned else shell.vertices
    walls = find_walls(np.asarray(vertices), np.asarray(shell.faces))
    assert walls is not None
    for faces, radius in ((walls.outer, outer), (walls.inner, inner)):
        assert shell.area_faces[faces].sum() == pytest.approx(2 * np.pi * radius * (radius - cut), rel=0.02)
        assert np.linalg.norm(shell.triangles[faces].reshape(-1, 3), axis=1).min() > 0.99 * radius
    assert walls.thickness == pytest.approx(outer - inner, rel=0.06)


@pytest.mark.parametrize(
    "solid",
    [
        block((0, 80), (0, 60), (0, 40)),
        icosphere(3, 50.0),
        icosphere(3, 50.0).difference(icosphere(3, 48.0)),  # hollow: its skins have no rim
        bracket(20.0),
        block((0, 200), (0, 5), (0, 5)),  # a rod is thin both ways
        trimesh.Trimesh([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 4)], [(0, 1, 2), (0, 2, 3)]),  # open
    ],
    ids=["block", "ball", "hollow ball", "thick", "rod", "open"],
)
def test_other_bodies_have_no_walls(solid: trimesh.Trimesh, tmp_path: Path) -> None:
    assert find_walls(np.asarray(solid.vertices), np.asarray(solid.faces)) is None
    solid.export(file := tmp_path / "part.stl")
    with pytest.raises(InputError, match=r"target\.skin"):
        mesh(file, fit="board", skin="outer")
    assert analyse_part(file).skin is None


def of_file(solid: trimesh.Trimesh, file: Path) -> PartAnalysis:
    solid.export(file)
    return analyse_part(file)


def test_thin_walls_are_laid_as_the_sheet_that_they_are(tmp_path: Path) -> None:
    """A thickened bracket has the setup of the bracket without thickness, a single fold."""
    sheet = trimesh.Trimesh(
        [(0, 0, 0), (80, 0, 0), (80, 50, 0), (0, 50, 0), (80, 50, 40), (0, 50, 40)],
        [(0, 1, 2), (0, 2, 3), (3, 2, 4), (3, 4, 5)],
    )
    thin, without = of_file(bracket(3.0), tmp_path / "thin.stl"), of_file(sheet, tmp_path / "sheet.stl")
    assert (thin.skin, without.skin) == ("outer", None)
    assert thin.setup == without.setup
    target = mesh(tmp_path / "thin.stl", fit="board", skin="inner")
    assert not target.closed
