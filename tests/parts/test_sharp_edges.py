"""Parts with rounded edges against the same parts with sharp ones."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.parts import shapes
from origami_lab.parts.analysis import analyse_part
from origami_lab.parts.sharp_edges import sharpened
from origami_lab.parts.surface import surface_of

WIDTH, FLOOR, WALL = 80.0, 50.0, 40.0


def bent(radius: float, angle: float, count: int) -> NDArray[np.float64]:
    """(F, 3, 3) a bracket whose wall rises at an angle (rad), bent in so many steps about a radius."""
    back = radius * math.tan(angle / 2)
    points = [(0.0, 0.0)]
    points += [
        (FLOOR - back + radius * math.sin(t), radius * (1 - math.cos(t))) for t in np.linspace(0.0, angle, count + 1)
    ]
    points.append((FLOOR + WALL * math.cos(angle), WALL * math.sin(angle)))
    quads = [[(0.0, *a), (WIDTH, *a), (WIDTH, *b), (0.0, *b)] for a, b in pairwise(points)]
    return shapes.flat(*quads)


@settings(max_examples=20, deadline=None)
@given(st.floats(1.0, 7.0), st.floats(0.6, 1.9), st.integers(3, 12), st.integers(0, 1000))
def test_a_bend_becomes_the_line_that_both_planes_have(radius: float, angle: float, count: int, seed: int) -> None:
    turn = Rotation.random(random_state=seed).as_matrix()
    triangles = bent(radius, angle, count) @ turn.T
    surface = surface_of(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), 1e-9)
    sharp = sharpened(surface)
    assert sharp is not None
    assert len(sharp.regions) == 2
    assert sum(region.area for region in sharp.regions) == pytest.approx(WIDTH * (FLOOR + WALL), rel=1e-9)
    (hinge,) = (side for side in sharp.regions[0].outline if side.neighbour >= 0)
    assert hinge.length == pytest.approx(WIDTH, rel=1e-9)
    assert abs(hinge.fold) == pytest.approx(math.degrees(angle), abs=1e-3)
    # the vertices of an even number of steps have the middle of the arc among them
    step = angle / (2 * count) if count % 2 else 0.0
    middle = radius / math.cos(angle / 2) - radius
    far = math.hypot(radius / math.cos(angle / 2) - radius * math.cos(step), radius * math.sin(step))
    assert middle - 1e-9 <= sharp.off == pytest.approx(far, rel=1e-6)


def test_it_is_laid_as_the_sharp_one(tmp_path: Path) -> None:
    setups = []
    for name, triangles in (("sharp", shapes.l_bracket()), ("round", bent(4.5, math.pi / 2, 8))):
        (tmp_path / f"{name}.stl").write_bytes(shapes.stl(triangles))
        part = analyse_part(tmp_path / f"{name}.stl")
        assert part.is_flat_faced
        setups.append(part.setup)
    assert setups[0].scale == pytest.approx(setups[1].scale)
    for what in ("symmetry", "start", "board", "driving_angle_max", "max_crease_length"):
        assert getattr(setups[0], what) == getattr(setups[1], what)


def test_corners_where_three_roundings_meet(tmp_path: Path) -> None:
    """A block with all its edges rounded: the hull of eight balls."""
    ball = trimesh.creation.icosphere(2, 3.0)
    half = np.array([40.0, 30.0, 10.0]) - 3.0
    corners = np.array(np.meshgrid(*([-1, 1],) * 3)).reshape(3, -1).T * half
    block = trimesh.convex.convex_hull(np.concatenate([ball.vertices + corner for corner in corners]))
    surface = surface_of(np.asarray(block.vertices), np.asarray(block.faces), 1e-9)
    sharp = sharpened(surface)
    assert sharp is not None
    assert len(sharp.regions) == 6
    assert np.ptp(sharp.surface.vertices, axis=0) == pytest.approx([80.0, 60.0, 20.0], abs=0.1)
    assert sharp.off == pytest.approx(3.0 * (math.sqrt(3.0) - 1.0), rel=0.1)


@pytest.mark.parametrize("name", ["shallow_dome", "half_vault", "saddle", "car_seat", "lampshade", "l_bracket"])
def test_curved_parts_and_sharp_ones_are_left_alone(name: str) -> None:
    triangles = shapes.PARTS[name]()
    surface = surface_of(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), 1e-9)
    assert sharpened(surface) is None
