"""The z-buffer against a count pixel by pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from origami_lab.drawing.camera import frame_points
from origami_lab.drawing.z_buffer import NOTHING, fill_z_buffer
from origami_lab.fold_format.fold_file import FoldFile

EMPTY = FoldFile(np.empty((0, 2)), np.empty((0, 2), np.int32), (), np.empty(0), (), None, None, ())


def test_z_buffer_against_barycentric_coordinates() -> None:
    rng = np.random.default_rng(1)
    corners = rng.uniform(-5, 35, (12, 3, 3))
    corners[0] = [(5, 5, 50), (5, 5, 50), (20, 20, 50)]  # no area: never seen
    owners = np.arange(12, dtype=np.int32) * 2
    near, owner = fill_z_buffer(corners, owners, (24, 30))
    assert near.shape == (24, 30)
    for row in range(24):
        for column in range(30):
            found = []
            for t, triangle in enumerate(corners[1:], start=1):
                system = np.vstack([triangle[:, :2].T, np.ones(3)])
                weights = np.linalg.solve(system, [column + 0.5, row + 0.5, 1.0])
                if weights.min() >= 0:
                    found.append((float(weights @ triangle[:, 2]), 2 * t))
            if found:
                best, who = max(found)
                assert abs(near[row, column] - best) < 2e-3
                assert owner[row, column] == who
            else:
                assert owner[row, column] == NOTHING
                assert near[row, column] == -np.inf


def test_panels_in_contact_show_the_first() -> None:
    square = np.array([[(0, 0, 1), (9, 0, 1), (0, 9, 1)], [(0, 0, 1 + 1e-7), (9, 0, 1), (0, 9, 1)]], dtype=float)
    _, owner = fill_z_buffer(square, np.array([4, 5], dtype=np.int32), (8, 8))
    assert set(owner.ravel().tolist()) == {NOTHING, 4}


def test_neighbours_leave_no_gap() -> None:
    corners = np.array([[(1, 1, 0), (9, 2, 0), (8, 9, 0)], [(1, 1, 0), (8, 9, 0), (2, 7, 0)]], dtype=float)
    _, both = fill_z_buffer(corners, np.zeros(2, dtype=np.int32), (10, 10))
    rows = [np.flatnonzero(line == 0) for line in both]
    assert all(len(line) == 0 or len(line) == line[-1] - line[0] + 1 for line in rows)


def test_camera_fills_its_window_without_mirroring() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    camera = frame_points(points, (10, 20, 110, 220))
    seen = camera.project(points)
    assert np.allclose(camera.axes @ camera.axes.T, np.eye(3))
    assert seen[:, 0].min() >= 10 - 1e-9
    assert seen[:, 0].max() <= 110 + 1e-9
    assert seen[:, 1].min() >= 20 - 1e-9
    assert seen[:, 1].max() <= 220 + 1e-9
    assert np.isclose(np.ptp(seen[:, 0]), 100) or np.isclose(np.ptp(seen[:, 1]), 200)
    assert seen[3, 1] < seen[0, 1]  # up is up: rows grow downwards
    x, y = seen[1, :2] - seen[0, :2], seen[2, :2] - seen[0, :2]
    assert x[0] * y[1] - x[1] * y[0] < 0  # from above, y lies counter-clockwise of x (rows grow downwards)
    assert seen[3, 2] > seen[0, 2]  # seen from above


@pytest.mark.parametrize(
    ("up", "front"),
    [((0, 0, -1), (0, -1, 0)), ((1, 0, 0), None), ((0.3, -0.5, 0.1), None), (None, (0, 1, 0)), ((0, -2, 0), (0, 3, 0))],
)
def test_a_sheet_stands_as_it_is_used_without_mirroring(up: tuple[int, ...], front: tuple[int, ...]) -> None:
    says = {name: list(value) for name, value in (("up", up), ("front", front)) if value}
    upright = replace(EMPTY, metadata=says).upright
    np.testing.assert_allclose(upright @ upright.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(upright) == pytest.approx(1)
    up = up or (0, 0, 1)
    np.testing.assert_allclose(upright @ up, (0, 0, np.linalg.norm(up)), atol=1e-12)
    across = np.cross(up, front or (0, -1, 0))
    if np.any(across):  # what is in front has no part to the side
        np.testing.assert_allclose(upright @ across / np.linalg.norm(across), (1, 0, 0), atol=1e-12)
    points = np.random.default_rng(1).normal(size=(50, 3))
    turned = frame_points(points, (0.0, 0.0, 100.0, 100.0), upright=upright)
    plain = frame_points(points @ upright.T, (0.0, 0.0, 100.0, 100.0))
    np.testing.assert_allclose(turned.project(points), plain.project(points @ upright.T), atol=1e-9)


@pytest.mark.parametrize("odd", ["up", [0, 0], [0, 0, 0], [1e400, 0, 0], ["x", 0, 1], None])
def test_a_file_that_does_not_say_what_is_up_is_not_turned(odd: object) -> None:
    np.testing.assert_array_equal(replace(EMPTY, metadata={"up": odd, "front": odd}).upright, np.eye(3))
