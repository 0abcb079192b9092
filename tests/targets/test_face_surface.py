"""The face: its size, its symmetry, and that it has what a face has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from origami_lab.errors import InputError
from origami_lab.geometry.sampling import areas
from origami_lab.targets.face_surface import face
from origami_lab.targets.mesh_target import count_open_edges
from origami_lab.targets.target import Target


@pytest.fixture(scope="module")
def target() -> Target:
    return face()


@pytest.fixture(scope="module")
def height(target: Target) -> LinearNDInterpolator:
    """Height over a point (x, y), by another triangulation of the same vertices."""
    return LinearNDInterpolator(target.vertices[:, :2], target.vertices[:, 2])


@pytest.mark.parametrize("spacing", [0.25, 0.11, 1.0])
def test_size_and_symmetry(spacing: float) -> None:
    target = face(spacing)
    size = np.ptp(target.vertices, axis=0)
    np.testing.assert_allclose(size[:2], [13, 18], rtol=1e-12)
    assert size[2] == pytest.approx(7, abs=0.2)
    assert np.abs(target.vertices[:, 1]).max() < 12  # on a board of 25
    mirrored = target.vertices * [-1, 1, 1] + 0.0
    assert {tuple(p) for p in mirrored.tolist()} == {tuple(p) for p in target.vertices.tolist()}  # to the last bit
    assert target.is_symmetric([[-1, 0], [0, 1]])
    assert not target.is_symmetric([[1, 0], [0, -1]])


def test_the_mesh_is_one_sheet_without_folds_or_slivers(target: Target) -> None:
    assert areas(target.triangles).min() > 1e-3
    flat = target.triangles[:, :, :2]
    u, v = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).min() > 1e-4  # a height field, counter-clockwise from above
    assert 200 < target.area < 400
    assert not target.closed
    rim = 8 * 36  # 72 × 72 squares
    assert count_open_edges(target.faces) == rim
    edges = np.sort(target.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert len(target.vertices) - len(np.unique(edges, axis=0)) + len(target.faces) == 1  # a disc


def test_the_nose_is_just_below_the_crease(target: Target, height: Any) -> None:
    assert float(height(0, 0)) == pytest.approx(0, abs=1e-12)
    x, y, z = target.vertices[np.argmax(target.vertices[:, 2])]
    assert (x, z) == (0, pytest.approx(0.6, abs=0.2))
    assert -1.1 < y < -0.5
    assert face(align_z=False).vertices[:, 2].max() == 0
    assert face(align_z=[0, 2]).vertices[:, 2].max() > 1


def test_it_has_what_a_face_has(height: Any) -> None:
    brow, socket, eyeball = height(2, 4), height(1.3, 2.6), height(2.6, 2.6)
    nose, wing, cheek = height(0, -0.8), height(1.1, -1.2), height(3.5, 0)
    assert nose > wing > cheek > height(5.5, 0)
    assert brow > eyeball > socket
    assert height(0, 2.6) > socket  # the back of the nose between the eyes
    assert height(0, 2.6) < nose - 1
    assert cheek > height(3, 2) - 0.5
    line = np.array([height(0, y) for y in np.arange(-1, -8.6, -0.02)])
    peaks = np.flatnonzero((line[1:-1] > line[:-2]) & (line[1:-1] > line[2:])) + 1
    upper, lower, chin = (-1 - 0.02 * peaks).tolist()  # three, from the nose down
    assert -3.6 < upper < -2.9
    assert -4.7 < lower < -4
    assert -7 < chin < -6
    assert line[peaks].max() < nose - 1
    for above, below in ((upper, lower), (lower, chin)):  # the mouth's line, the hollow over the chin
        assert height(0, (above + below) / 2) < min(height(0, above), height(0, below)) - 0.1


@pytest.mark.parametrize("arguments", [
    {"spacing": 0}, {"spacing": 2}, {"spacing": float("nan")}, {"spacing": "fine"}, {"spacing": True},
    {"align_z": [0]}, {"align_z": [20, 0]}, {"align_z": "nose"},
])  # fmt: skip
def test_wrong_settings_are_named(arguments: dict[str, Any]) -> None:
    with pytest.raises(InputError) as caught:
        face(**arguments)
    assert caught.value.field == f"target.{next(iter(arguments))}"
