"""Directed surface distances against closed forms and dense sampling."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, build_bvh, distances
from origami_lab.geometry.hausdorff import directed_distance
from origami_lab.geometry.sampling import sample_triangles
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target

Array = NDArray[np.float64]


def square(half: float, z: float = 0.0, x: float = 0.0, diagonal: int = 0) -> Array:
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]) + np.array([x, 0, 0])
    corners = np.roll(corners, diagonal, axis=0)
    return corners[[[0, 1, 2], [0, 2, 3]]]


def directed(source: Array, target: Array, tolerance: float = 1e-4, solid: bool = False, start: float = 0.0) -> float:
    return directed_distance(source, build_bvh(target), tolerance, solid=solid, start=start)


def test_parallel_squares() -> None:
    assert directed(square(1), square(1, z=0.7)) == pytest.approx(0.7, abs=1e-12)
    assert directed(square(1), square(1, z=0.7, diagonal=1)) == pytest.approx(0.7, abs=1e-12)


def test_smaller_and_larger_square() -> None:
    assert directed(square(1), square(2)) == pytest.approx(0.0, abs=1e-4)
    assert directed(square(2), square(1)) == pytest.approx(math.sqrt(2), abs=1e-4)
    assert directed(square(1, x=0.5), square(1)) == pytest.approx(0.5, abs=1e-4)


@pytest.mark.parametrize("make", [cube, pyramid, bowl])
def test_a_surface_is_at_no_distance_from_itself(make: type[Target]) -> None:
    target = make()
    assert directed_distance(target.triangles, target.bvh, 1e-6, solid=False) < 1e-12


def test_the_maximum_may_lie_within_a_face() -> None:
    # one large triangle over two points: the maximum is where both are equally far, on the far side
    triangle = np.array([[[-1.0, 0, 0], [1.0, 0, 0], [0.0, 1.0, 0]]])
    ends = np.array([[[-1.0, 0, 0]] * 3, [[1.0, 0, 0]] * 3, [[0.0, 1.0, 0]] * 3])
    assert directed(triangle, ends, 1e-6) == pytest.approx(1.0, abs=1e-6)  # circumcentre: middle of the long side
    equilateral = np.array([[[math.cos(a), math.sin(a), 0.0] for a in (0, 2 * math.pi / 3, 4 * math.pi / 3)]])
    corners = np.repeat(equilateral[0][:, None], 3, axis=1)
    for tolerance in (0.3, 1e-2, 1e-5):
        value = directed(equilateral, corners, tolerance)
        assert 1.0 - tolerance <= value <= 1.0 + 1e-12


def test_a_cube_around_a_smaller_cube() -> None:
    large, small = cube(4.0), cube(2.0)
    # both stand on z = 0: the furthest corner of the large one is (1, 1, 2) away from the small one's
    assert directed_distance(large.triangles, small.bvh, 1e-4, solid=False) == pytest.approx(math.sqrt(6), abs=1e-4)
    # the middle of the small one's lid is the centre of the large cube, 2 away from all its sides
    assert directed_distance(small.triangles, large.bvh, 1e-4, solid=False) == pytest.approx(2.0, abs=1e-4)
    assert directed_distance(small.triangles, large.bvh, 1e-4, solid=True) == 0.0
    assert directed_distance(large.triangles, small.bvh, 1e-4, solid=True) == pytest.approx(math.sqrt(6), abs=1e-4)


def test_what_sticks_out_of_a_solid_counts() -> None:
    slab = square(0.5, z=1.0, x=1.0)  # half inside the cube, reaching x = 1.5
    assert directed(slab, cube().triangles, 1e-5, solid=True) == pytest.approx(0.5, abs=1e-5)
    deep = square(0.25, z=0.9)  # distance to the nearest wall at most 0.9
    assert directed(deep, cube().triangles, 1e-5, solid=False) == pytest.approx(0.9, abs=1e-5)
    assert directed(deep, cube().triangles, 1e-5, solid=True) == 0.0


def test_within_tolerance_above_dense_sampling() -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        source = rng.normal(size=(8, 3, 3))
        target = build_bvh(rng.normal(size=(20, 3, 3)))
        sampled = distances(target, sample_triangles(source, 20_000, rng)).max()
        fine = directed_distance(source, target, 1e-5, solid=False)
        assert fine >= sampled - 1e-5
        assert fine <= sampled + 0.15  # samples this dense cannot miss more
        for tolerance in (1e-1, 1e-2, 1e-3):
            value = directed_distance(source, target, tolerance, solid=False)
            assert fine - tolerance <= value <= fine + 1e-5


def test_start_is_a_floor_and_prunes() -> None:
    assert directed(square(2), square(1), start=3.0) == 3.0
    assert directed(square(2), square(1), start=1.0) == pytest.approx(math.sqrt(2), abs=1e-4)
    assert directed(np.empty((0, 3, 3)), square(1), start=0.25) == 0.25


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan])
def test_the_tolerance_must_be_positive(tolerance: float) -> None:
    bvh: Bvh = build_bvh(square(1))
    with pytest.raises(ValueError, match="tolerance"):
        directed_distance(square(1), bvh, tolerance, solid=False)


def test_a_tolerance_below_rounding_still_ends() -> None:
    assert directed(square(1, z=1e3), square(0.3, z=-1e3), 1e-300) == pytest.approx(math.hypot(2e3, 0.7 * math.sqrt(2)))


def test_read_only_and_strided_sources() -> None:
    source = np.repeat(square(2), 2, axis=0)[::2]
    source.flags.writeable = False
    assert directed(source, square(1)) == pytest.approx(math.sqrt(2), abs=1e-4)
