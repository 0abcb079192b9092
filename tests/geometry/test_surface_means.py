"""Means over surfaces, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.geometry.bvh import build_bvh
from origami_lab.geometry.sampling import areas
from origami_lab.geometry.surface_means import cells_of, like_share, mean_distance, thinned


def rectangle(width: float, height: float, z: float = 0.0, tilt: float = 0.0) -> NDArray[np.float64]:
    """Two triangles over [0, width] × [0, height], turned about the y axis by so many radians, then raised."""
    corners = np.array([[0.0, 0.0, 0.0], [width, 0.0, 0.0], [width, height, 0.0], [0.0, height, 0.0]])
    turned = corners.copy()
    turned[:, 0], turned[:, 2] = corners[:, 0] * math.cos(tilt), corners[:, 0] * math.sin(tilt) + z
    return turned[[[0, 1, 2], [0, 2, 3]]]


def cube(edge: float) -> NDArray[np.float64]:
    """The surface of [0, edge]³ as twelve triangles."""
    found = []
    for axis in range(3):
        for side in (0.0, edge):
            u, v = [k for k in range(3) if k != axis]
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[[1, 2], u] = edge
            corners[[2, 3], v] = edge
            found += [corners[[0, 1, 2]], corners[[0, 2, 3]]]
    return np.array(found)


triangles = st.lists(st.floats(-5, 5, width=32), min_size=18, max_size=18).map(lambda x: np.array(x).reshape(2, 3, 3))


@given(triangles, st.floats(0.01, 3.0))
def test_cells_are_the_surface_in_pieces(surface: NDArray[np.float64], cell_area: float) -> None:
    """Their areas and first moments add up to those of the triangles, and none is too large."""
    cells, own = cells_of(surface, cell_area), areas(surface)
    assert cells.areas.sum() == pytest.approx(own.sum(), rel=1e-9, abs=1e-9)
    moment = (own[:, None] * surface.mean(axis=1)).sum(axis=0)
    np.testing.assert_allclose((cells.areas[:, None] * cells.points).sum(axis=0), moment, rtol=0, atol=1e-8)
    assert (cells.areas <= cell_area * (1 + 1e-6)).all()
    np.testing.assert_allclose(np.linalg.norm(cells.normals, axis=1), 1.0, rtol=0, atol=1e-9)


def test_a_triangle_without_area_has_no_cell() -> None:
    flat = np.array([[[0.0, 0, 0], [1, 1, 1], [2, 2, 2]]])
    cells = cells_of(flat, 0.1)
    assert len(cells.areas) == 0
    assert mean_distance(cells, build_bvh(rectangle(1, 1)), False, np.inf) == np.inf


@pytest.mark.parametrize("tilt", [0.0, 0.2, 1.0])
def test_the_mean_distance_from_a_plane_is_exact(tilt: float) -> None:
    """Above a far larger plane it is the height of the centroid, as long as no point is below it."""
    plane = rectangle(100, 100) - np.array([50.0, 50, 0])
    above = rectangle(4, 3, z=0.5, tilt=tilt)
    mean = mean_distance(cells_of(above, 1.0), build_bvh(plane), False, np.inf)
    assert mean == pytest.approx(0.5 + 2 * math.sin(tilt), rel=1e-12)


def test_inside_a_solid_nothing_strays() -> None:
    within = rectangle(1, 1, z=1.0) + np.array([0.5, 0.5, 0])
    box = build_bvh(cube(2.0))
    assert mean_distance(cells_of(within, 0.01), box, True, np.inf) == 0.0
    # in the middle plane of the box, less than a half from its sides: the distance is that to the nearest side
    expected = 2 / 3  # of u from 0.5 to 1 over the four triangles of the square: 1 − the mean of max(|x|, |y|) ≤ ½
    assert mean_distance(cells_of(within, 0.0005), box, False, np.inf) == pytest.approx(expected, abs=2e-3)


@given(st.floats(0.0, 2.0))
def test_more_than_enough_is_said_to_be_infinite(enough: float) -> None:
    cells, plane = cells_of(rectangle(1, 1, z=1.0), 0.1), build_bvh(rectangle(9, 9) - np.array([4.0, 4, 0]))
    assert mean_distance(cells, plane, False, enough) == (np.inf if enough < 1 - 1e-9 else pytest.approx(1.0)) or (
        abs(enough - 1) < 1e-9
    )


def test_the_share_that_has_a_like_near_by() -> None:
    """Half of a rectangle is covered; the other half has a panel of another direction, or one too far away."""
    target = cells_of(rectangle(4, 1), 0.001)
    half = rectangle(2, 1)
    cosine = math.cos(math.radians(20))
    assert like_share(target, half, 1e-9, cosine) == pytest.approx(0.5, abs=0.01)
    for degrees, share in ((19.0, 1.0), (21.0, 0.5)):
        tilted = rectangle(1.9, 1, tilt=math.radians(degrees)) + np.array([2.1, 0, 0])
        found = like_share(target, np.concatenate([half, tilted]), 1.0, cosine)
        # a panel that is turned too far is none: but the half that is right still reaches one cell further
        assert found == pytest.approx(1.0 if share == 1.0 else 0.75, abs=0.01)
    upside_down = half[:, ::-1].copy()
    assert like_share(target, upside_down, 1e-9, cosine) == pytest.approx(0.5, abs=0.01)
    assert like_share(target, np.zeros((1, 3, 3)), 10.0, cosine) == 0.0


def test_thinned_cells_share_the_area_evenly() -> None:
    fine = cells_of(np.concatenate([rectangle(1, 1), rectangle(3, 1) + np.array([5.0, 0, 0])]), 0.001)
    few = thinned(fine, 400)
    assert len(few.areas) == 400
    assert few.areas.sum() == pytest.approx(4.0)
    assert (few.points[:, 0] < 2).sum() == pytest.approx(100, abs=1)
    assert thinned(few, 400) is few
