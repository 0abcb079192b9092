"""Points on surfaces: on them, covering them, uniform by area, cut alike on both sides of a mirror."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from origami_lab.geometry import sampling
from origami_lab.geometry.bvh import build_bvh, distances
from origami_lab.geometry.sampling import areas, covering_points, sample_triangles


def test_areas_and_shares() -> None:
    triangles = np.array([[[0.0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 0, 1], [1, 0, 1], [0, 0, 5]], [[7.0, 7, 7]] * 3])
    assert areas(triangles).tolist() == [6, 2, 0]
    points = sample_triangles(triangles, 40_000, np.random.default_rng(0))
    below = points[:, 2] == 0
    assert below.mean() == pytest.approx(0.75, abs=0.01)
    assert points[below].mean(axis=0) == pytest.approx([1, 4 / 3, 0], abs=0.03)  # the centroid
    assert distances(build_bvh(triangles), points).max() < 1e-12


@pytest.mark.parametrize("spacing", [2.0, 0.7, 0.15])
def test_covering_points_cover_random_triangles(spacing: float) -> None:
    rng = np.random.default_rng(1)
    triangles = rng.normal(size=(12, 3, 3)) * [1, 0.2, 2]
    points = covering_points(triangles, spacing)
    assert (points == np.unique(points, axis=0)).all()  # sorted, and each once
    assert distances(build_bvh(triangles), points).max() < 1e-12
    covered = cKDTree(points).query(sample_triangles(triangles, 20_000, rng))[0]
    assert covered.max() <= spacing / np.sqrt(3)


def test_mirror_images_are_cut_alike() -> None:
    half = np.random.default_rng(2).normal(size=(6, 3, 3))
    isosceles = np.array([[[-0.1, 0, 0], [0.1, 0, 0], [0, 3.3, 1]]])  # its own image
    for image in (np.diag([-1.0, 1, 1]), np.eye(3)[[1, 0, 2]], np.diag([-1.0, -1, 1])):
        both = np.concatenate([half, half[:, ::-1] @ image, isosceles, isosceles[:, [1, 2, 0]] @ image])
        points = covering_points(both, 0.1)
        assert (np.unique(points @ image + 0.0, axis=0) == points).all()


def test_too_many_points_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sampling, "MAX_CELLS", 5000)
    with pytest.raises(ValueError, match="5000"):
        covering_points(np.eye(3)[None], 1e-3)
