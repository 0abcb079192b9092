"""Meshes of the folded sheet, read back by trimesh: paper keeps its area, and panels their sides."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh

from origami_lab.export.folded_mesh import plates, write_mesh
from origami_lab.fold_format.fold_file import FoldFile
from origami_lab.fold_format.writer import as_fold_file
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs

DESIGNS: dict[str, Callable[[], CreasePattern]] = {
    "asymmetric": designs.degree_four,
    "valley": designs.single_valley,
    "pyramid": designs.pyramid,
}
every_design = pytest.mark.parametrize("make", DESIGNS.values(), ids=DESIGNS)


def flat_area(design: CreasePattern) -> np.ndarray:
    """(F,) the area of each panel on the board."""
    areas = []
    for panel in design.panels:
        x, y = design.vertices[list(panel)].T
        areas.append(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
    return np.array(areas)


def read(path: Path) -> trimesh.Trimesh:
    loaded = trimesh.load(path, process=False)
    return loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded


@every_design
@pytest.mark.parametrize("kind", ["obj", "stl", "ply", "glb"])
def test_the_surface_is_the_folded_sheet(make: Callable[[], CreasePattern], kind: str, tmp_path: Path) -> None:
    design = make()
    fold = as_fold_file(design)
    path = tmp_path / f"a.{kind}"
    write_mesh(fold, fold.best, path, scale=2.0)
    mesh = read(path)
    assert mesh.area == pytest.approx(4 * flat_area(design).sum(), rel=1e-6)
    points = mesh.vertices
    if kind == "glb":  # glTF's y is up: turned, not mirrored
        points = np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])
    folded = 2 * design.folded[design.best]
    near = np.linalg.norm(points[:, None] - folded[None], axis=2)
    assert near.min(axis=1).max() < 1e-6  # every vertex is one of the sheet's, and the other way round
    assert near.min(axis=0).max() < 1e-6
    if kind != "stl":
        assert len(points) == len(folded)
    # the upper side of each triangle is that of a panel
    normals = np.array([designs.panel_normal(folded, panel) for panel in design.panels])
    corners = points[mesh.faces]
    found = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    assert (found @ normals.T).max(axis=1).min() > 1 - 1e-6


@every_design
@pytest.mark.parametrize("kind", ["stl", "glb"])
def test_solid_panels(make: Callable[[], CreasePattern], kind: str, tmp_path: Path) -> None:
    design = make()
    fold = as_fold_file(design)
    path = tmp_path / f"a.{kind}"
    write_mesh(fold, fold.best, path, thickness=0.125)
    assert read(path).volume == pytest.approx(0.125 * flat_area(design).sum(), rel=1e-5)


def test_each_plate_is_closed_and_lies_about_its_panel() -> None:
    """A panel with a vertex in the middle of a side, and one that is not convex."""
    vertices = np.array([(0, 0), (2, 0), (4, 0), (4, 3), (2, 1), (0, 3), (2, -2)], dtype=float)
    panels = ((0, 1, 2, 3, 4, 5), (0, 6, 2, 1))
    turn = designs.rotation((1, 2, 3), 0.7)
    coords = np.column_stack([vertices, np.zeros(7)]) @ turn.T
    edges = np.array([(0, 1), (1, 2)], dtype=np.int32)
    fold = FoldFile(vertices, edges, ("F", "F"), np.zeros(2), panels, None, None, ())
    points, faces = plates(fold, coords, 0.2)
    for body, area, count in zip(_parts(points, faces, [12, 8]), (8.0, 4.0), (12, 8), strict=True):
        assert body.is_watertight
        assert body.is_winding_consistent
        assert body.volume == pytest.approx(area * 0.2)
        heights = body.vertices @ turn[:, 2]
        assert np.sort(heights) == pytest.approx([-0.1] * (count // 2) + [0.1] * (count // 2))


def _parts(points: np.ndarray, faces: np.ndarray, counts: list[int]) -> list[trimesh.Trimesh]:
    first = np.concatenate([[0], np.cumsum(counts)])
    parts = []
    for low, high in pairwise(first):
        mine = faces[(faces >= low).all(axis=1) & (faces < high).all(axis=1)]
        parts.append(trimesh.Trimesh(points[low:high], mine - low, process=False))
    assert sum(len(part.faces) for part in parts) == len(faces)
    return parts
