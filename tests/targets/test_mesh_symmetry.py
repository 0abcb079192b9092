"""Symmetry of mesh files at the precision that they have: rounded halves are alike, moved ones are not."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.geometry.groups import GROUPS
from origami_lab.targets.mesh_precision import coordinate_precision
from origami_lab.targets.mesh_target import mesh
from origami_lab.targets.solids import bowl, cube
from origami_lab.targets.target import Target
from tests.targets import mesh_files as files

Array = NDArray[np.float64]


def dome(rings: int = 6, around: int = 24, height: float = 1.0) -> tuple[Array, list[tuple[int, int, int]]]:
    """A paraboloid of radius 3 about the z axis: the same in all eight symmetries of the square, but for rounding.

    Its quads are flat trapezoids, so that it does not matter which way they are cut, and cut they are all one way.
    """
    angles = 2.0 * math.pi * (np.arange(around) + 0.5) / around
    points = [(0.0, 0.0, height)]
    faces = [(0, 1 + k, 1 + (k + 1) % around) for k in range(around)]
    for ring in range(1, rings + 1):
        r = 3.0 * ring / rings
        points += [(r * math.cos(a), r * math.sin(a), height * (1.0 - r * r / 9.0)) for a in angles]
        if ring > 1:
            inner, outer = 1 + (ring - 2) * around, 1 + (ring - 1) * around
            for k in range(around):
                n = (k + 1) % around
                faces += [(inner + k, outer + k, outer + n), (inner + k, outer + n, inner + n)]
    return np.array(points), faces


def frustum() -> tuple[Array, list[tuple[int, ...]]]:
    """A square lid with sloping sides: few vertices, on no grid."""
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    points = [(2.7182818 * x, 2.7182818 * y, 0.0) for x, y in corners] + [
        (1.234567 * x, 1.234567 * y, 0.7654321) for x, y in corners
    ]
    return np.array(points), [(4, 5, 6, 7), *[(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]]


WRITINGS = ("float32", "%.6g", "%.4f", "%.3f", "double")


def written(folder: Path, points: Array, faces: list[tuple[int, ...]], writing: str) -> Path:
    """A file of a part, its coordinates rounded as ``writing`` says."""
    if writing == "float32":
        path = folder / "part.stl"
        fans = [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]
        path.write_bytes(files.binary_stl(points.tolist(), fans))
        return path
    shown = "%.17g" if writing == "double" else writing
    path = folder / "part.obj"
    lines = ["v " + " ".join(shown % c for c in point) for point in points]
    path.write_text("\n".join([*lines, *("f " + " ".join(str(k + 1) for k in f) for f in faces)]) + "\n")
    return path


def is_symmetric(target: Target) -> bool:
    return target.has_symmetry(GROUPS["xyd"])


PARTS = {"dome": dome(), "frustum": frustum()}


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("writing", WRITINGS)
@settings(max_examples=20)
@given(size=st.floats(0.5, 200.0), shift=st.tuples(*[st.floats(-100.0, 100.0)] * 3))
def test_rounded_parts_are_symmetric(part: str, writing: str, size: float, shift: tuple[float, float, float]) -> None:
    points, faces = PARTS[part]
    # decimals are worth what they are of the part: a thousandth of it at least
    size = max(size, 2.0) if writing == "%.3f" else size
    shift_by = np.array(shift) if writing != "%.6g" else np.array(shift) * min(1.0, size / 100.0)
    with tempfile.TemporaryDirectory() as folder:
        path = written(Path(folder), size * points + shift_by, faces, writing)
        assert is_symmetric(mesh(path, fit="board"))
        # also where it was moved to the middle by hand
        back = mesh(path, scale=1.0 / size, translate=(-shift_by / size).tolist())
        assert is_symmetric(back)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("writing", WRITINGS)
@settings(max_examples=20)
@given(size=st.floats(0.5, 200.0), which=st.integers(0, 7), axis=st.integers(0, 2), sign=st.sampled_from([-1, 1]))
def test_a_dent_is_seen(part: str, writing: str, size: float, which: int, axis: int, sign: int) -> None:
    points, faces = PARTS[part]
    size = max(size, 2.0) if writing == "%.3f" else size
    dented = points.copy()
    at = which + (len(points) - 8)  # at the rim, where sideways shows, too
    # what the file can tell: half a unit here, half a unit there, in three coordinates. Of few values it does not show
    # whether their last digits are zeros by chance.
    unit = {
        "float32": 2.0**-23 * 3,
        "double": 2.0**-23 * 3,
        "%.6g": 1e-5 * 3,
        "%.4f": 1e-4 / size,
        "%.3f": 1e-3 / size,
    }[writing]
    dented[at, axis] += sign * (12.0 if part == "dome" else 120.0) * max(unit, 2.0**-23 * 10)
    with tempfile.TemporaryDirectory() as folder:
        target = mesh(written(Path(folder), size * dented, faces, writing), scale=1.0 / size)
        assert not is_symmetric(target)


def test_symmetry_is_of_the_group_only(tmp_path: Path) -> None:
    points, faces = dome()
    target = mesh(written(tmp_path, points * [1.5, 1.0, 1.0], faces, "float32"))
    assert target.has_symmetry(GROUPS["xy"])
    assert not is_symmetric(target)
    moved = mesh(written(tmp_path, points + np.array([1e-4, 0, 0]), faces, "float32"))
    assert moved.has_symmetry(GROUPS["x"])
    assert not moved.has_symmetry(GROUPS["y"])


@pytest.mark.parametrize("step", [1.0, 0.5, 0.1])
def test_a_designed_grid_is_no_rounding(tmp_path: Path, step: float) -> None:
    """A tray of whole steps, one wall a step thicker: that is how it was meant."""
    outer, inner = (0, 40, 0, 30), (2, 37, 2, 28)
    ring = lambda x0, x1, y0, y1, z: [(x, y, z) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]  # noqa: E731
    points = np.array(ring(*outer, 0) + ring(*outer, 5) + ring(*inner, 5) + ring(*inner, 2)) * step
    walls = [(a + k, a + (k + 1) % 4, a + 4 + (k + 1) % 4, a + 4 + k) for a in (0, 4, 8) for k in range(4)]
    faces = [(3, 2, 1, 0), *walls, (12, 13, 14, 15)]
    for writing in ("float32", "double"):
        target = mesh(written(tmp_path, points, faces, writing), fit="board")
        assert target.closed
        assert target.has_symmetry(GROUPS["x"])
        assert not target.has_symmetry(GROUPS["y"])


def test_precision_of_coordinates() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(-50.0, 50.0, (400, 3))
    single = 2.0**-23 * np.abs(points).max()
    assert coordinate_precision(points) == pytest.approx(single)
    assert coordinate_precision(points.astype(np.float32).astype(np.float64)) == pytest.approx(single, rel=1e-6)
    for digits in (1, 2, 3, 4):
        rounded = np.round(points, digits)
        assert coordinate_precision(rounded) == pytest.approx(0.5 * 10.0**-digits)
        # a converter's float32 hides nothing
        assert coordinate_precision(rounded.astype(np.float32).astype(np.float64)) == pytest.approx(0.5 * 10.0**-digits)
        inches = coordinate_precision(25.4 * rounded + 1 / 3)
        assert inches == pytest.approx(25.4 * 0.5 * 10.0**-digits, rel=1e-3 if digits < 4 else 1.0)
    six = np.array([[float(f"{c:.6g}") for c in point] for point in points])
    assert coordinate_precision(six) == pytest.approx(0.5e-4)
    assert coordinate_precision(1e-30 * points) == pytest.approx(1e-30 * single)
    assert coordinate_precision(np.zeros((3, 3))) == 0.0
    assert coordinate_precision(np.zeros((0, 3))) == 0.0
    x, y = (axis.reshape(-1) for axis in np.meshgrid(np.linspace(0, 3, 61), np.linspace(0, 4, 91)))
    sampled = np.column_stack([x, y, 0.1 * math.pi * (x * x + y)])
    assert coordinate_precision(sampled) == 2.0**-23 * sampled.max()  # points in rows are no rounding
    box = np.array(np.meshgrid([0, 40], [0, 30], [0, 5])).T.reshape(-1, 3).astype(np.float64)
    assert coordinate_precision(box) == 2.0**-23 * 40  # whole millimetres are no rounding


def test_built_in_targets_are_exact() -> None:
    assert cube().uncertainty == bowl().uncertainty == 0.0
    moved = Target("moved", cube().vertices + np.array([1e-7, 0, 0]), cube().faces, True)
    assert not moved.has_symmetry(GROUPS["y"])
