"""Mesh files as other programs write them: every reader, with any line ends, marks, leavings and losses."""

from __future__ import annotations

import codecs
import struct
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.targets.mesh_reader import axis_up, read_mesh
from origami_lab.targets.mesh_target import mesh
from origami_lab.targets.target import Target
from tests.targets import mesh_files as files

TEXTS = {
    "bar.obj": files.obj(),
    "relative.obj": files.relative_obj(),
    "bar.off": files.off(),
    "coloured.off": files.coloured_off(),
    "bar.stl": files.stl(),
    "bar.ply": files.ply(),
    "bar.gltf": files.gltf(),
}
BINARIES = {
    "bar.stl": files.binary_stl(),
    "unnamed.stl": files.binary_stl(header=b"\0" * 80),
    "little.ply": files.binary_ply("<"),
    "big.ply": files.binary_ply(">"),
    "little_extra.ply": files.binary_ply("<", extra=True),
    "big_extra.ply": files.binary_ply(">", extra=True),
    "triangles.ply": files.binary_ply("<", faces=files.TRIANGLES),
    "big_triangles.ply": files.binary_ply(">", faces=files.TRIANGLES, extra=True),
    "bar.glb": files.glb(),
}
EVERYTHING = {f"text {k}": (k, v.encode()) for k, v in TEXTS.items()} | {
    f"bytes {k}": (k, v) for k, v in BINARIES.items()
}


def read(folder: Path, name: str, data: bytes) -> Target:
    path = folder / name
    path.write_bytes(data)
    return mesh(path)


def volume(target: Target) -> float:
    a, b, c = np.moveaxis(target.triangles, 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def is_the_bar(target: Target) -> bool:
    inside = target.vertices.min(axis=0).tolist() == [0, 0, 0] and target.vertices.max(axis=0).tolist() == [4, 3, 2]
    sizes = target.area == pytest.approx(files.AREA) and volume(target) == pytest.approx(files.VOLUME)
    return inside and sizes and target.closed and len(target.vertices) == 12


def refusal(folder: Path, name: str, data: bytes) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, name, data)
    assert caught.value.field == "target.path"
    assert "\n" not in str(caught.value)
    return str(caught.value.expected)


@pytest.mark.parametrize("key", EVERYTHING)
def test_every_format(tmp_path: Path, key: str) -> None:
    assert is_the_bar(read(tmp_path, *EVERYTHING[key]))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["unix", "windows", "macintosh"])
@pytest.mark.parametrize("name", TEXTS)
def test_line_ends(tmp_path: Path, name: str, end: str) -> None:
    assert is_the_bar(read(tmp_path, name, TEXTS[name].replace("\n", end).encode()))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("name", [name for name in TEXTS if not name.endswith("ply")])
def test_byte_order_marks(tmp_path: Path, name: str, encoding: str) -> None:
    mark = {"utf-8": codecs.BOM_UTF8, "utf-16-le": codecs.BOM_UTF16_LE, "utf-16-be": codecs.BOM_UTF16_BE}[encoding]
    assert is_the_bar(read(tmp_path, name, mark + TEXTS[name].encode(encoding)))


def test_headers_of_ply(tmp_path: Path) -> None:
    assert is_the_bar(read(tmp_path, "bar.ply", codecs.BOM_UTF8 + files.ply().encode()))
    for order in "<>":
        header, _, body = files.binary_ply(order).partition(b"end_header\n")
        for end in (b"\r\n", b"\r"):
            data = (header + b"end_header\n").replace(b"\n", end) + body
            assert is_the_bar(read(tmp_path, "bar.ply", data))
            assert is_the_bar(read(tmp_path, "bar.ply", codecs.BOM_UTF8 + data))


@pytest.mark.parametrize("text", [name for name in TEXTS if not name.endswith("gltf")])
def test_names_that_are_no_utf_8(tmp_path: Path, text: str) -> None:
    comment = {
        "stl": b"solid b\xe4r\xff",
        "obj": b"# b\xe4r\xff",
        "off": b"OFF # b\xe4r\xff",
        "ply": b"comment b\xe4r\xff",
    }
    kind = text.rpartition(".")[2]
    if text == "coloured.off":
        return
    first = {"stl": b"solid bar", "obj": b"# a part", "off": b"OFF # a part", "ply": b"comment a part"}[kind]
    if text == "relative.obj":
        first = b"f "
        comment["obj"] = b"# b\xe4r\xff\nf "
    assert first in TEXTS[text].encode()
    assert is_the_bar(read(tmp_path, text, TEXTS[text].encode().replace(first, comment[kind])))


LEAVINGS = [
    b"\n",
    b"\r\n\r\n",
    b"  ",
    b"\0",
    b"\0" * 50,
    b"\0" * 84,
    b"\0" * 200,
    b"\x1a",
    b"\n\n# the end\n",
    bytes(range(10)),
]


@pytest.mark.parametrize("key", EVERYTHING)
def test_what_follows_the_end(tmp_path: Path, key: str) -> None:
    name, data = EVERYTHING[key]
    for rest in LEAVINGS:
        if name.endswith("obj"):  # it has no end: what follows are lines
            rest = b"\n\n# the end\n" if b"\0" in rest or b"\x1a" in rest else rest
        assert is_the_bar(read(tmp_path, name, data + rest)), rest


@given(rest=st.binary(min_size=1, max_size=300))
def test_anything_may_follow_binary_data(rest: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name in ("bar.stl", "little.ply", "big_triangles.ply", "bar.glb"):
            assert is_the_bar(read(Path(folder), name, BINARIES[name] + rest))


@pytest.mark.parametrize(
    "key", [key for key in EVERYTHING if not key.startswith(("text bar.stl", "text bar.obj", "text rel"))]
)
def test_a_file_that_is_cut_off_says_so(tmp_path: Path, key: str) -> None:
    """Wherever it is cut, but for the white space at its end."""
    name, data = EVERYTHING[key]
    end = len(data.rstrip()) if key.startswith("text") else len(data)
    if name.startswith("coloured"):
        end = data.rindex(b" 3 0.5")  # the colour of the last face is not missed
    for length in sorted({*range(1, end, 7), *range(max(1, end - 20), end)}):
        message = refusal(tmp_path, name, data[:length])
        if name.endswith(("glb", "ply", "stl")) and length > 200:
            assert "cut off" in message
    assert is_the_bar(read(tmp_path, name, data[:end]))


@pytest.mark.parametrize("name", ["bar.stl", "bar.obj", "relative.obj"])
def test_text_without_a_promise_is_read_up_to_where_it_ends(tmp_path: Path, name: str) -> None:
    """What is left of such a file may be a whole one; a face that is not whole is never passed over."""
    data = TEXTS[name].encode()
    face = b"endfacet" if name.endswith("stl") else b"\nf "
    whole = {tuple(map(tuple, t)) for t in mesh_triangles(tmp_path, name, data)}
    for length in range(1, len(data.rstrip()), 5):
        try:
            found = mesh_triangles(tmp_path, name, data[:length])
        except InputError:
            continue
        last = data[:length].rpartition(b"\n")[2]
        if name.endswith("obj") and last.startswith((b"f", b"v")):
            continue  # it may be cut within a number, or before a corner that could be
        assert {tuple(map(tuple, t)) for t in found} <= whole
        assert len(found) >= data[:length].count(face)


def mesh_triangles(folder: Path, name: str, data: bytes) -> list[list[list[float]]]:
    vertices, faces, _ = read_mesh(_written(folder / name, data), 1000)
    return [[list(map(float, corner)) for corner in triangle] for triangle in vertices[faces]]


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


# --- STL


def test_text_stl_without_an_end(tmp_path: Path) -> None:
    text = files.stl()
    assert is_the_bar(read(tmp_path, "bar.stl", text[: text.index("endsolid")].encode()))
    assert is_the_bar(read(tmp_path, "bar.stl", text.replace("solid bar\n", "").encode()))
    assert is_the_bar(read(tmp_path, "bar.stl", text.upper().encode()))
    assert is_the_bar(read(tmp_path, "bar.stl", text.replace("\n", " ").encode()))
    assert is_the_bar(read(tmp_path, "bar.stl", files.stl(name="a vertex on the outer loop solid").encode()))


def test_several_solids(tmp_path: Path) -> None:
    half = len(files.TRIANGLES) // 2
    first, second = files.TRIANGLES[:half], files.TRIANGLES[half:]
    text = files.stl(triangles=first) + files.stl(triangles=second, name="")
    assert is_the_bar(read(tmp_path, "two.stl", text.encode()))
    data = files.binary_stl(triangles=first) + files.binary_stl(triangles=second)
    assert is_the_bar(read(tmp_path, "two.stl", data))


def test_true_reasons_of_stl(tmp_path: Path) -> None:
    data, text = files.binary_stl(), files.stl()
    number = len(files.TRIANGLES)
    assert f"promises {number} triangles, there are {number - 1}" in refusal(tmp_path, "a.stl", data[:-1])
    fewer = data[:80] + struct.pack("<I", 3) + data[84:]
    assert f"promises 3 triangles, {number - 3} more follow" in refusal(tmp_path, "a.stl", fewer)
    none = data[:80] + struct.pack("<I", 0) + data[84:]
    assert f"promises 0 triangles, {number} more follow" in refusal(tmp_path, "a.stl", none)
    assert "no triangles" in refusal(tmp_path, "a.stl", data[:80] + struct.pack("<I", 0))
    assert "no triangles" in refusal(tmp_path, "a.stl", b"solid\nendsolid\n")
    assert "'1,5' is no number" in refusal(tmp_path, "a.stl", text.replace("1.000000e+00", "1,5").encode())
    missing = text.replace("      vertex 0.000000e+00 3.000000e+00 0.000000e+00\n", "", 1)
    assert "does not have three vertices" in refusal(tmp_path, "a.stl", missing.encode())
    assert "no endloop" in refusal(tmp_path, "a.stl", text.replace("endloop", "", 1).encode())
    assert "cut off within triangle" in refusal(tmp_path, "a.stl", text[: text.rindex("endloop")].encode())


# --- OBJ, OFF, PLY


@pytest.mark.parametrize("write", [files.obj, files.relative_obj, files.off, files.ply])
def test_a_concave_face_has_its_own_area(tmp_path: Path, write: object) -> None:
    assert callable(write)
    corners = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)]  # 10, and 14 as a fan
    kind = write.__name__.rpartition("_")[2]
    assert read(tmp_path, f"dart.{kind}", write(corners, [range(5)]).encode()).area == pytest.approx(10)
    assert read(tmp_path, f"dart.{kind}", write(corners, [[4, 3, 2, 1, 0]]).encode()).area == pytest.approx(10)
    arrow = [(0, 0, 0), (1, 3, 0), (0, 2, 0), (-1, 3, 0)]  # a quad, 2 whichever corner is first
    for first in range(4):
        ring = [(first + k) % 4 for k in range(4)]
        assert read(tmp_path, f"arrow.{kind}", write(arrow, [ring]).encode()).area == pytest.approx(2)


def test_lines_of_obj_that_go_on(tmp_path: Path) -> None:
    assert is_the_bar(read(tmp_path, "bar.obj", files.obj().replace("/1/1 ", "/1/1 \\\n").encode()))


def test_true_reasons_of_obj(tmp_path: Path) -> None:
    text = files.obj()
    assert "do not exist" in refusal(tmp_path, "a.obj", (text + "f 1 2 99\n").encode())
    assert "do not exist" in refusal(tmp_path, "a.obj", (text + "f 0 1 2\n").encode())
    assert "do not exist" in refusal(tmp_path, "a.obj", (text + "f -1 -2 -99\n").encode())
    assert "'x' names no vertex" in refusal(tmp_path, "a.obj", (text + "f 1 2 x\n").encode())
    assert "three coordinates" in refusal(tmp_path, "a.obj", (text + "v 1 2\n").encode())
    assert "'one' is no number" in refusal(tmp_path, "a.obj", (text + "v 1 2 one\n").encode())
    assert "free-form" in refusal(tmp_path, "a.obj", b"v 0 0 0\nv 1 0 0\ncstype bspline\nsurf 0 1 0 1 1 2\nend\n")
    assert "no triangles" in refusal(tmp_path, "a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n")


def test_true_reasons_of_off(tmp_path: Path) -> None:
    assert "4OFF" in refusal(tmp_path, "a.off", files.off().replace("OFF", "4OFF").encode())
    assert "binary" in refusal(tmp_path, "a.off", b"OFF BINARY\n" + bytes(100))
    assert "does not begin with OFF" in refusal(tmp_path, "a.off", b"hello\n" + files.off().encode())
    assert "numbers of vertices" in refusal(tmp_path, "a.off", b"OFF\n")
    assert is_the_bar(read(tmp_path, "a.off", files.off().replace("OFF # a part\n", "").encode()))


STRIP = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (2, 0, 0), (2, 1, 0), (5, 0, 0), (5, 1, 0), (6, 0, 0)]


def test_strips(tmp_path: Path) -> None:
    """Three squares in one strip, then a triangle of its own, all of them turned the same way."""
    for strips in (
        [[0, 1, 2, 3, 4, 5, -1, 6, 7, 8]],
        [[0, 1, 2, 3, 4, 5], [6, 7, 8]],
        [[0, 1, 2, 3, 4, 5, -1, 6, 7, 8, -1]],
    ):
        writings = [files.ply(STRIP, strips, "tristrips").encode()]
        writings += [files.binary_ply(order, STRIP, strips, "tristrips") for order in "<>"]
        for data in writings:
            target = read(tmp_path, "strips.ply", data)
            assert target.area == pytest.approx(2.5)
            normals = np.cross(*(target.triangles[:, 1:] - target.triangles[:, :1]).transpose(1, 0, 2))
            assert (normals[:, 2] < 0).all()


def test_strips_that_turn_a_corner(tmp_path: Path) -> None:
    data = files.ply(STRIP, [[0, 1, 2, 3, 3, 6, 6, 7, 8]], "tristrips").encode()
    assert read(tmp_path, "strips.ply", data).area == pytest.approx(1 + 0.5)


def test_true_reasons_of_ply(tmp_path: Path) -> None:
    text = files.ply()
    assert "do not begin" in refusal(tmp_path, "a.ply", b"hello").replace("does not", "do not")
    assert "end_header" in refusal(tmp_path, "a.ply", text[:60].encode())
    assert "no format" in refusal(tmp_path, "a.ply", text.replace("ascii", "morse").encode())
    assert "type that is not known" in refusal(tmp_path, "a.ply", text.replace("double", "quad").encode())
    assert "no x, y and z" in refusal(tmp_path, "a.ply", text.replace("double y", "double w").encode())
    assert "which vertices" in refusal(tmp_path, "a.ply", text.replace("vertex_indices", "colours").encode())
    assert "do not exist" in refusal(tmp_path, "a.ply", text.replace("4 0 1 7 6", "4 0 1 77 6").encode())
    grid = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    grid += "element range_grid 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0\n0\n"
    assert "range grid" in refusal(tmp_path, "a.ply", grid.encode())
    points = grid.partition("element range_grid")[0] + "end_header\n0 0 0\n"
    assert "no triangles" in refusal(tmp_path, "a.ply", points.encode())


# --- glTF


def test_gltf_with_its_data_beside_it(tmp_path: Path) -> None:
    (tmp_path / "the data.bin").write_bytes(files.gltf_data())
    text = files.gltf(uri="the%20data.bin").encode()
    assert is_the_bar(read(tmp_path, "bar.gltf", text))
    (tmp_path / "the data.bin").write_bytes(files.gltf_data()[:-1])
    assert "what it says" in refusal(tmp_path, "bar.gltf", text)


def test_true_reasons_of_gltf(tmp_path: Path) -> None:
    def changed(**values: object) -> bytes:
        return files.gltf(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, **values}]}]).encode()

    assert is_the_bar(read(tmp_path, "a.gltf", changed()))
    assert "fans" in refusal(tmp_path, "a.gltf", changed(mode=6))
    assert "points and lines" in refusal(tmp_path, "a.gltf", changed(mode=1))
    draco = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    assert "compressed (KHR_draco" in refusal(tmp_path, "a.gltf", changed(extensions=draco))
    assert "no scene" in refusal(tmp_path, "a.gltf", files.gltf(scenes=[{"nodes": []}]).encode())
    for extra, reason in (
        ({"sparse": {}}, "sparse"),
        ({"normalized": True}, "quantized"),
        ({"componentType": 5122}, "quantized"),
    ):
        vertices = {"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3", **extra}
        indices = {"bufferView": 1, "componentType": 5125, "count": 3 * len(files.TRIANGLES), "type": "SCALAR"}
        assert reason in refusal(tmp_path, "a.gltf", files.gltf(accessors=[vertices, indices]).encode())
    assert "lacks 'count'" in refusal(tmp_path, "a.gltf", files.gltf().replace('"count"', '"number"').encode())
    data = files.glb()
    assert f"promises {len(data)} bytes and has 100" in refusal(tmp_path, "a.glb", data[:100])
    assert "does not begin" in refusal(tmp_path, "a.glb", b"PK" + data[2:])


# --- which way is up


@pytest.mark.parametrize(
    "settings", [{}, {"fit": "board"}, {"rotate": (30, 20, 10), "scale": 0.5}], ids=["as it is", "fit", "turned"]
)
def test_all_formats_of_one_part_lie_alike(tmp_path: Path, settings: dict[str, object]) -> None:
    found: list[NDArray[np.float64]] = []
    for name, data in EVERYTHING.values():
        target = mesh(_written(tmp_path / name, data), **settings)  # type: ignore[arg-type]
        found.append(target.vertices[np.lexsort(np.round(target.vertices, 6).T)])
    for vertices in found[1:]:
        np.testing.assert_allclose(vertices, found[0], atol=1e-6)


def test_up_is_chosen(tmp_path: Path) -> None:
    stl, glb = (_written(tmp_path / name, BINARIES[name]) for name in ("bar.stl", "bar.glb"))
    assert is_the_bar(mesh(stl, up="z"))
    assert is_the_bar(mesh(glb, up="y"))
    # y of the file is z of the board, z of the file is −y
    assert mesh(stl, up="y").vertices.min(axis=0).tolist() == [0, -2, 0]
    assert mesh(stl, up="y").vertices.max(axis=0).tolist() == [4, 0, 3]
    assert mesh(glb, up="z").vertices.max(axis=0).tolist() == [4, 2, 0]
    assert volume(mesh(stl, up="y")) == pytest.approx(files.VOLUME)  # turned, not mirrored
    assert (axis_up("A.GLB"), axis_up("a.gltf"), axis_up("a.stl"), axis_up("glb")) == ("y", "y", "z", "z")


def test_as_version_0_1_0_read_it(tmp_path: Path) -> None:
    glb = _written(tmp_path / "bar.glb", BINARIES["bar.glb"])
    assert (mesh(glb, up=None).vertices == mesh(glb, up="z").vertices).all()
    corners = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)]
    dart = _written(tmp_path / "dart.obj", files.obj(corners, [range(5)]).encode())
    assert mesh(dart, up=None).area == pytest.approx(14)  # fanned, as it was played then
    assert mesh(dart, up=None).uncertainty == 0.0
