"""Targets: closed-form sizes and areas, exact symmetry, and mesh files good and bad."""

from __future__ import annotations

import base64
import itertools
import json
import logging
import math
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from origami_lab.errors import InputError
from origami_lab.geometry.bvh import distances
from origami_lab.targets.mesh_target import count_open_edges, mesh
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target

Array = NDArray[np.float64]
SQUARE = [
    np.array(m)
    for m in itertools.product([[1, 0], [-1, 0], [0, 1], [0, -1]], repeat=2)
    if abs(np.linalg.det(np.array(m))) == 1
]
BUILT_IN = [pyramid(), cube(), bowl()]


def signed_volume(target: Target) -> float:
    a, b, c = np.moveaxis(target.triangles, 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def test_sizes_and_areas() -> None:
    p, c, b = BUILT_IN
    assert p.vertices.min(axis=0).tolist() == [-1, -1, 0]
    assert p.vertices.max(axis=0).tolist() == [1, 1, math.sqrt(8)]
    assert p.area == pytest.approx(4 + 4 * 3)  # four flaps of height 3
    assert signed_volume(p) == pytest.approx(4 * math.sqrt(8) / 3)
    assert c.vertices.min(axis=0).tolist() == [-1, -1, 0]
    assert c.vertices.max(axis=0).tolist() == [1, 1, 2]
    assert c.area == pytest.approx(24)
    assert signed_volume(c) == pytest.approx(8)
    assert cube(3.0).area == pytest.approx(54)
    assert (p.closed, c.closed, b.closed) == (True, True, False)
    assert b.vertices.min(axis=0) == pytest.approx([-5, -5, -0.088])
    assert b.vertices.max(axis=0) == pytest.approx([5, 5, 4.4])
    # surface of revolution: 2π∫r√(1+(2cr)²)dr plus the disc
    paraboloid = math.pi / (6 * 0.04) * ((1 + 0.16 * 25) ** 1.5 - (1 + 0.16 * 2.56) ** 1.5)
    assert b.area == pytest.approx(paraboloid + math.pi * 1.6**2, rel=1e-3)
    assert b.area < paraboloid + math.pi * 1.6**2


def test_closed_ones_are_watertight() -> None:
    assert count_open_edges(pyramid().faces) == 0
    assert count_open_edges(cube().faces) == 0
    assert len(cube().vertices) == 14
    faces = bowl().faces
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    assert count_open_edges(faces) == (counts == 1).sum() == 128  # the rim and nothing else
    assert counts.max() == 2


def test_bowl_vertices_satisfy_the_equation() -> None:
    target = bowl()
    r = np.hypot(target.vertices[:, 0], target.vertices[:, 1])
    expected = np.where(r >= 1.6 - 1e-9, 0.2 * r**2 - 0.6, 0.2 * 1.6**2 - 0.6)
    np.testing.assert_allclose(target.vertices[:, 2], expected, atol=1e-12)
    normals = np.cross(*(target.triangles[:, 1:] - target.triangles[:, :1]).transpose(1, 0, 2))
    assert (normals[:, 2] > 0).all()  # no overlap seen from above


@pytest.mark.parametrize("error", [0.003, 0.02])
def test_bowl_mesh_is_within_its_error(error: float) -> None:
    target = bowl(error=error)
    rng = np.random.default_rng(0)
    r = np.sqrt(rng.uniform(0, 25, 4000))
    angle = rng.uniform(0, 2 * math.pi, 4000)
    z = 0.2 * np.maximum(r, 1.6) ** 2 - 0.6
    true = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
    assert distances(target.bvh, true).max() <= error
    # the other way round: vertical gap times the cosine of the steepest slope nearby bounds the distance
    points = target.sampled_points(20_000, 0)
    r = np.hypot(points[:, 0], points[:, 1])
    gap = np.abs(points[:, 2] - (0.2 * np.maximum(r, 1.6) ** 2 - 0.6))
    assert (gap / np.hypot(1, 0.4 * np.maximum(r, 1.6))).max() <= error


@pytest.mark.parametrize("target", BUILT_IN, ids=lambda t: t.name)
@pytest.mark.parametrize("matrix", SQUARE, ids=str)
def test_symmetry_is_exact(target: Target, matrix: NDArray[np.int64]) -> None:
    image = np.eye(3)
    image[:2, :2] = matrix
    for points in (target.vertices, target.samples(0.4)):
        images = points @ image.T + 0.0
        assert set(map(tuple, images.tolist())) == set(map(tuple, points.tolist()))
    assert target.is_symmetric(matrix)


def test_asymmetry_is_seen() -> None:
    c = cube()
    moved = Target("moved", c.vertices + np.array([0.001, 0, 0]), c.faces, True)
    assert not moved.is_symmetric([[-1, 0], [0, 1]])
    assert moved.is_symmetric([[1, 0], [0, -1]])
    # a tetrahedron's vertices are at corners of the cube: the quarter turn maps them to the other four
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    tetrahedron = Target("t", corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), True)
    assert tetrahedron.is_symmetric([[-1, 0], [0, -1]])
    assert not tetrahedron.is_symmetric([[0, -1], [1, 0]])


@pytest.mark.parametrize("spacing", [3.0, 0.5, 0.2])
@pytest.mark.parametrize("target", BUILT_IN[:2], ids=lambda t: t.name)
def test_samples_lie_on_the_surface_and_cover_it(target: Target, spacing: float) -> None:
    samples = target.samples(spacing)
    assert distances(target.bvh, samples).max() < 1e-12
    assert len(np.unique(samples, axis=0)) == len(samples)
    assert set(map(tuple, target.vertices.tolist())) <= set(map(tuple, samples.tolist()))
    covered = cKDTree(samples).query(target.sampled_points(5000, 1))[0]
    assert covered.max() <= spacing / math.sqrt(3) + 1e-12
    assert (samples == target.samples(spacing)).all()


def test_samples_of_long_thin_triangles() -> None:
    thin = Target("thin", np.array([[0.0, 0, 0], [10, 0, 0], [10, 0.01, 0]]), np.array([[0, 1, 2]]), False)
    assert len(thin.samples(0.2)) < 1000  # cut lengthwise: four pieces each time would give 2145
    assert cKDTree(thin.samples(0.2)).query(thin.sampled_points(2000, 1))[0].max() <= 0.2 / math.sqrt(3)
    with pytest.raises(InputError, match="spacing=0"):
        thin.samples(0.0)


def test_random_samples_are_reproducible_and_uniform() -> None:
    target = pyramid()
    points = target.sampled_points(20_000, 7)
    assert (points == target.sampled_points(20_000, 7)).all()
    assert not (points == target.sampled_points(20_000, 8)).all()
    assert distances(target.bvh, points).max() < 1e-12
    assert (points[:, 2] == 0).mean() == pytest.approx(4 / 16, abs=0.015)  # the base's share of the area
    sides = points[points[:, 2] > 0]
    assert sides[:, 2].mean() == pytest.approx(math.sqrt(8) / 3, abs=0.02)
    with pytest.raises(InputError):
        target.sampled_points(0, 1)


def test_a_target_is_frozen_and_pickles() -> None:
    target = cube()
    with pytest.raises(ValueError, match="read-only"):
        target.vertices[0, 0] = 5.0
    _ = target.bvh
    again = pickle.loads(pickle.dumps(target))
    assert (again.triangles == target.triangles).all()
    assert again.closed


@pytest.mark.parametrize(
    "call",
    [
        lambda: pyramid(half_width=0),
        lambda: pyramid(apex=-1),
        lambda: cube(edge=math.nan),
        lambda: bowl(inner=6),
        lambda: bowl(error=0),
        lambda: bowl(offset=math.inf),
    ],
)
def test_bad_sizes(call: Any) -> None:
    with pytest.raises(InputError, match=r"^target\.\w+="):
        call()


# --- files


def box(size: tuple[float, float, float] = (4, 2, 1)) -> trimesh.Trimesh:
    return trimesh.creation.box(extents=size)


@pytest.fixture
def stl(tmp_path: Path) -> Path:
    path = tmp_path / "part.stl"
    box().export(path)
    return path


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "off", "glb"])
def test_common_formats(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"part.{kind}"
    box().export(path)
    target = mesh(path, up="z")
    assert target.name == "part"
    assert target.closed
    assert len(target.vertices) == 8  # welded
    assert target.area == pytest.approx(28)
    assert target.vertices.max(axis=0) == pytest.approx([2, 1, 0.5])


def test_ascii_stl_with_capital_suffix(tmp_path: Path) -> None:
    path = tmp_path / "part.STL"
    path.write_text(trimesh.exchange.stl.export_stl_ascii(box()))
    assert mesh(path).area == pytest.approx(28)


def test_several_bodies_are_taken_together(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(box((1, 1, 1)))
    scene.add_geometry(box((1, 1, 1)), transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    scene.export(tmp_path / "two.glb")
    target = mesh(tmp_path / "two.glb")
    assert len(target.faces) == 24
    assert target.closed
    assert np.ptp(target.vertices, axis=0) == pytest.approx([4, 1, 1])


def test_rotate_scale_translate(stl: Path) -> None:
    assert np.ptp(mesh(stl, rotate=(0, 0, 90)).vertices, axis=0).tolist() == [
        2,
        4,
        1,
    ]  # quarter turns are exact
    assert np.ptp(mesh(stl, rotate=[90, 0, 0]).vertices, axis=0).tolist() == [4, 1, 2]
    # x before z: the z extent of 1 goes to y, then to x
    assert np.ptp(mesh(stl, rotate=(90, 0, 90)).vertices, axis=0).tolist() == [1, 4, 2]
    turned = mesh(stl, rotate=(0, 0, 30)).vertices
    matrix = trimesh.transformations.rotation_matrix(math.radians(30), [0, 0, 1])
    expected = trimesh.transform_points(box().vertices, matrix)
    assert cKDTree(expected).query(turned)[0].max() < 1e-6  # STL is single precision
    placed = mesh(stl, scale=2, translate=(1, 2, 3)).vertices
    assert placed.max(axis=0) == pytest.approx([5, 4, 4])


def test_fit_board(tmp_path: Path) -> None:
    path = tmp_path / "far.ply"
    box((400, 200, 100)).apply_translation([1000, -50, 7]).export(path)
    vertices = mesh(path, fit="board", board_size=25).vertices
    width, _, height = np.ptp(vertices, axis=0)
    assert 0.5 * width + height == pytest.approx(0.8 * 12)
    assert vertices.min(axis=0) == pytest.approx([-width / 2, -width / 4, 0])
    half = mesh(path, fit="board", board_size=25, scale=0.5, translate=(0, 0, -1)).vertices
    assert np.ptp(half, axis=0) == pytest.approx(0.5 * np.ptp(vertices, axis=0))
    assert half[:, 2].min() == pytest.approx(-1)


@pytest.mark.parametrize(("wide", "high", "reach"), [(25, 13, 0.8 * 6), (13, 25, 0.8 * 6), (25, 21, 0.8 * 12)])
def test_fit_board_looks_at_both_sides_of_the_board(tmp_path: Path, wide: int, high: int, reach: float) -> None:
    path = tmp_path / "part.ply"
    box((400, 300, 10)).export(path)
    width, depth, height = np.ptp(mesh(path, fit="board", board_width=wide, board_height=high).vertices, axis=0)
    assert width / 400 == pytest.approx(depth / 300)
    binding = depth if wide == 25 and high == 13 else width
    assert 0.5 * binding + height == pytest.approx(reach)
    assert 0.5 * width + height <= 0.8 * (wide - 1) / 2 + 1e-9
    assert 0.5 * depth + height <= 0.8 * (high - 1) / 2 + 1e-9


def test_align_z(tmp_path: Path, stl: Path) -> None:
    assert mesh(stl, align_z=True).vertices[:, 2].max() == pytest.approx(0)
    path = tmp_path / "p.obj"
    trimesh.Trimesh(pyramid().vertices, pyramid().faces, process=False).export(path)
    assert mesh(path, align_z=True).vertices[:, 2].min() == pytest.approx(-math.sqrt(8))
    assert mesh(path, align_z=(0.5, 0)).vertices[:, 2].min() == pytest.approx(-math.sqrt(2))
    with pytest.raises(InputError, match=r"target\.align_z=\[3\.0, 0\.0\]: no part of"):
        mesh(path, align_z=(3, 0))


def test_closed(tmp_path: Path, stl: Path) -> None:
    opened = box()
    opened.update_faces(np.arange(12) > 0)
    opened.export(tmp_path / "open.stl")
    assert not mesh(tmp_path / "open.stl").closed
    assert not mesh(stl, closed=False).closed
    assert mesh(stl, closed=True).closed
    with pytest.raises(InputError, match=r"target\.closed=True: .*open\.stl has 3 open edges"):
        mesh(tmp_path / "open.stl", closed=True)


def _write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def gltf(uri: str | None = None, count: int = 3, nodes: Any = ({"mesh": 0},)) -> str:
    """One triangle as glTF."""
    corners = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 1]], np.float32).tobytes()
    data = "data:application/octet-stream;base64," + base64.b64encode(corners).decode()
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri or data, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": list(nodes),
        "scenes": [{"nodes": list(range(len(nodes)))}],
    }
    return json.dumps(document)


BAD_FILES = {
    "missing.stl": (None, "no such file"),
    "empty.stl": ("", "the file is empty"),
    "broken.glb": ("glTF but not really", "cannot be read as a .glb mesh|no triangles"),
    "broken.stl": ("\x00\x01" * 300, "cannot be read as a .stl mesh|no triangles"),
    "words.ply": ("ply\nformat ascii 1.0\nelement nonsense\n", "cannot be read as a .ply mesh|no triangles"),
    "prose.obj": ("hello\n", "cannot be read as a .obj mesh|no triangles"),
    "cloud.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "cannot be read as a .obj mesh|no triangles"),
    "part.step": ("ISO-10303-21;", "unknown kind of mesh file: must end in .*stl"),
    "nosuffix": ("v 0 0 0", "unknown kind"),
    "nan.obj": ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "must be finite"),
    "inf.off": ("OFF\n3 1 0\n0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n", "must be finite"),
    "huge.obj": ("v 0 0 0\nv 1e200 0 0\nv 0 1e200 0\nf 1 2 3\n", "absurdly large"),
    "line.obj": ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no area"),
    "dot.obj": ("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "no area"),
    "minus.ply": ("ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "cannot be read as a .ply|no triangles"),
    "count.off": ("OFF\n3 999999999999 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "has 999999999999 triangles"),
    "room.ply": ("ply\nformat ascii 1.0\nelement vertex 99999999\nend_header\n", "claims 99999999 vertices"),
    "deep.gltf": ("[" * 200_000, "cannot be read as a .gltf"),
    "outside.gltf": (gltf(uri="../../etc/passwd"), "outside its folder"),
    "device.gltf": (gltf(uri="/dev/zero"), "outside its folder"),
    "web.gltf": (gltf(uri="http://localhost:9/x"), "is missing"),
    "zeros.gltf": (gltf(count=10**12), "has 333333333333 triangles"),
    "many.gltf": (gltf(nodes=[{"mesh": 0}] * 300_000), "has 300000 triangles"),
    "index.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "do not exist|cannot be read"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_files(
    tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    text, message = BAD_FILES[name]
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with caplog.at_level(logging.DEBUG), pytest.raises(InputError, match=message) as caught:
        mesh(path)
    assert caught.value.field == "target.path"
    assert str(caught.value).startswith(f"target.path={path}: ")
    assert "\n" not in str(caught.value)
    out = capfd.readouterr()
    assert out.out + out.err == ""
    assert not [record for record in caplog.records if record.name.startswith("trimesh")]


def test_a_gltf_triangle_is_a_mesh(tmp_path: Path) -> None:
    assert mesh(_write(tmp_path / "one.gltf", gltf())).area == pytest.approx(0.5 * 4 * math.hypot(4, 1))


def test_what_is_no_regular_file_is_not_opened(tmp_path: Path) -> None:
    (tmp_path / "loop.stl").symlink_to(tmp_path / "loop.stl")
    (tmp_path / "zero.stl").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.stl")
    for name, message in (("loop", "no such file"), ("zero", "must be a file"), ("pipe", "must be a file")):
        with pytest.raises(InputError, match=message):
            mesh(tmp_path / f"{name}.stl")
    for name in ("a" * 300, "nul\0"):
        with pytest.raises(InputError, match="no such file"):
            mesh(tmp_path / f"{name}.stl")


@pytest.mark.parametrize("kind", ["stl", "ascii.stl", "obj", "ply", "off", "glb"])
def test_too_many_triangles_are_counted_before_they_are_parsed(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"part.{kind.rpartition('.')[2]}"
    if kind == "ascii.stl":
        path.write_text(trimesh.exchange.stl.export_stl_ascii(box()))
    else:
        box().export(path)
    monkeypatch.setattr(trimesh, "load_scene", None)
    with pytest.raises(InputError, match="has 12 triangles, at most 11"):
        mesh(path, max_faces=11)
    with (tmp_path / "huge.stl").open("wb") as file:
        file.truncate(2**32)
    with pytest.raises(InputError, match=r"is 4\.0 GB large"):
        mesh(tmp_path / "huge.stl")


def test_materials_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "part.mtl")
    path = _write(tmp_path / "part.obj", "mtllib part.mtl\nmtllib /dev/zero\n" + box().export(file_type="obj"))
    assert mesh(path).area == pytest.approx(28)


def test_units_of_the_file_per_cell(tmp_path: Path, stl: Path) -> None:
    for settings in ({}, {"scale": 0.5}, {"fit": "board"}, {"fit": "board", "scale": 0.5}):
        target = mesh(stl, **settings)
        # the box is 4 units long
        assert np.ptp(target.vertices[:, 0]) * target.units_per_cell == pytest.approx(4)
    assert cube().units_per_cell is None


def test_a_folder_is_no_mesh(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be a file"):
        mesh(tmp_path)


def test_size_limits(stl: Path) -> None:
    with pytest.raises(InputError, match=r"target\.scale=0\.001: makes the mesh 0\.004 cells large"):
        mesh(stl, scale=0.001)
    with pytest.raises(InputError, match=r"target\.scale=1000"):
        mesh(stl, scale=1000)
    with pytest.raises(InputError, match=r"target\.translate=.* cells from the board"):
        mesh(stl, translate=(0, 0, 1e6))
    with pytest.raises(InputError, match=r"has 12 triangles, at most 10"):
        mesh(stl, max_faces=10)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("scale", 0),
        ("scale", -1),
        ("scale", math.inf),
        ("scale", "big"),
        ("rotate", 90),
        ("rotate", (0, 90)),
        ("rotate", "xyz"),
        ("translate", (0, 0, math.nan)),
        ("fit", "sheet"),
        ("closed", "yes"),
        ("up", "x"),
        ("up", True),
        ("align_z", (1, 2, 3)),
        ("align_z", "top"),
    ],
)
def test_bad_settings(stl: Path, field: str, value: Any) -> None:
    with pytest.raises(InputError, match=rf"^target\.{field}="):
        mesh(stl, **{field: value})
