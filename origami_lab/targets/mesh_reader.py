"""Mesh files: what they hold is found out before it is parsed, because a stranger's file may hold anything.

A file is refused for what it is (no regular file, too large), then for what its header promises (too many triangles),
and only then read: kinds whose faces may be polygons by our own readers, the others by trimesh, without its materials
and without what lies outside its folder.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import re
import stat
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, NamedTuple
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.files import expanded, regular_bytes
from origami_lab.lengths import MILLIMETRES
from origami_lab.targets.mesh_formats import READERS
from origami_lab.targets.mesh_formats.gltf import whole_gltf
from origami_lab.targets.mesh_formats.polygons import triangulate
from origami_lab.targets.mesh_precision import coordinate_precision

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

KINDS = ("glb", "gltf", "obj", "off", "ply", "stl")
"""Kinds that need nothing but trimesh itself; it may read more, with other packages."""
BYTES_PER_FACE = 500
"""More than any format takes for a triangle with its share of normals, colours and texture coordinates."""
SMALLEST_LIMIT = 16 * 2**20
"""Bytes that are accepted however few triangles are: a small part may come with large textures."""
GLTF = ("glb", "gltf")
"""Kinds whose y axis points up, by their standard; those of the others point wherever their program's does."""


def axis_up(path: str | Path) -> Literal["y", "z"]:
    """The axis that points up in a file of this name, as far as its kind says: z where it does not."""
    return "y" if Path(path).suffix.lower().lstrip(".") in GLTF else "z"


def unit_of(path: str | Path, unit: str | None = None) -> str:
    """The unit of a file: the one that is said (``mm``, ``cm``, ``m``, ``in``), else that of its kind.

    By glTF's standard that is a metre; other kinds do not say, so it is a millimetre.

    Raises
    ------
    InputError
        If there is no such unit.
    """
    if unit is None:
        return "m" if Path(path).suffix.lower().lstrip(".") in GLTF else "mm"
    if unit not in MILLIMETRES:
        raise InputError("target.unit", unit, f"must be auto, {', '.join(MILLIMETRES)} or null")
    return unit


def millimetres_per_unit(path: str | Path, unit: str | None = None) -> float:
    """A unit of a file, as of :func:`unit_of`, in millimetres."""
    return MILLIMETRES[unit_of(path, unit)]


def read_mesh(path: Path, max_faces: int, as_first: bool = False) -> tuple[Array, Indices, float]:
    """All triangles of a file in one frame, in units and axes of the file.

    Parameters
    ----------
    path
        The file.
    max_faces
        More triangles than this are refused.
    as_first
        Read it as version 0.1.0 did: by trimesh alone, which fans every polygon, and as if it were exact.

    Returns
    -------
    vertices (V, 3), faces (F, 3), F ≥ 1, and how far a coordinate may be from what it was meant to be

    Raises
    ------
    InputError
        If the file is missing, no regular file, empty, far larger than ``max_faces`` triangles can be, of an unknown
        kind, unreadable, without triangles or with too many, or if its coordinates are not finite.
    """
    path = expanded(path)
    size = _check_file(path)
    if size > (limit := max(SMALLEST_LIMIT, BYTES_PER_FACE * max_faces)):
        fact = f"is {_bytes(size)} large, more than {max_faces} triangles take ({_bytes(limit)})"
        raise InputError("target.path", path, fact + _SMALLER)
    kind = path.suffix.lower().lstrip(".")
    formats = KINDS if kind in KINDS else _all_kinds()
    if kind not in formats:
        raise InputError("target.path", path, f"unknown kind of mesh file: must end in .{', .'.join(formats)}")
    try:
        data = regular_bytes(path, limit)
        if kind in GLTF and not as_first:
            data = whole_gltf(kind, data)
        triangles, vertices = _promised(kind, data)
        _check_count(path, triangles, max_faces)
        if vertices > 4 * max_faces:
            fact = f"claims {vertices} vertices, more than {max_faces} triangles have"
            raise InputError("target.path", path, fact + _SMALLER)
        if zipfile.is_zipfile(io.BytesIO(data)):
            unpacked = sum(item.file_size for item in zipfile.ZipFile(io.BytesIO(data)).infolist())
            if unpacked > limit:
                raise InputError("target.path", path, f"holds {_bytes(unpacked)}, packed" + _SMALLER)
        if as_first or kind not in READERS:
            parts = _parse(path, kind, data, max_faces, limit)
        else:
            parts = _polygons(path, kind, data, max_faces)
    except InputError:
        raise
    except Exception as error:  # a broken file can raise anything in any of trimesh's readers
        lacks = "it lacks " if isinstance(error, KeyError) else ""
        reason = lacks + " ".join(str(error).split())[:200] or "its data are not what it says they are"
        raise InputError("target.path", path, f"cannot be read as a .{kind} mesh ({reason})") from error
    if not parts:
        raise InputError("target.path", path, "the file has no triangles")
    for part in parts:
        if part.faces.min() < 0 or part.faces.max() >= len(part.vertices):
            raise InputError("target.path", path, _NO_VERTEX)
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts])
    everything = np.concatenate([part.placed for part in parts])
    faces = np.concatenate([part.faces + offset for part, offset in zip(parts, offsets[:-1], strict=True)])
    corners, faces = used(everything, faces)
    _check_coordinates(path, corners)
    return corners, faces, 0.0 if as_first else max(part.precision for part in parts)


_NO_VERTEX = "its triangles name vertices that do not exist"
_SMALLER = ": decimate it (Blender, MeshLab) or raise target.max_faces"


def used(vertices: Array, faces: Indices) -> tuple[Array, Indices]:
    """Without the vertices no face uses."""
    kept, index = np.unique(faces, return_inverse=True)
    return vertices[kept], index.reshape(-1, 3).astype(np.int64)


def _check_file(path: Path) -> int:
    """The size of a regular file in bytes; a pipe or a device is not even opened, it might never end."""
    try:
        found = path.stat()
    except FileNotFoundError:
        raise InputError("target.path", path, "no such file") from None
    except (OSError, ValueError) as error:  # a loop of links, no permission, a name too long, a null byte
        raise InputError("target.path", path, f"no such file ({getattr(error, 'strerror', None) or error})") from None
    if not stat.S_ISREG(found.st_mode):
        raise InputError("target.path", path, "must be a file")
    if found.st_size == 0:
        raise InputError("target.path", path, "the file is empty")
    return found.st_size


def _check_count(path: Path, number: int, max_faces: int) -> None:
    if number > max_faces:
        raise InputError("target.path", path, f"has {number} triangles, at most {max_faces} are accepted" + _SMALLER)


def _check_coordinates(path: Path, points: Array) -> None:
    if not np.isfinite(points).all():
        raise InputError("target.path", path, "its coordinates must be finite numbers")
    if not np.abs(points).max(initial=0.0) < 1e100:
        raise InputError("target.path", path, "its coordinates are absurdly large (1e100 or more)")


def _bytes(size: int) -> str:
    return f"{size / 2**30:.1f} GB" if size >= 2**30 else f"{size / 2**20:.0f} MB"


def _promised(kind: str, data: bytes) -> tuple[int, int]:
    """How many triangles and how many vertices a file claims to have, without parsing it; 0 where that is not known."""
    if kind == "stl":
        promised = int.from_bytes(data[80:84], "little")
        if len(data) == 84 + 50 * promised:
            return promised, 0
        return max(data.count(b"endfacet"), data.count(b"ENDFACET")), 0
    if kind == "obj":
        return data.count(b"\nf ") + data.count(b"\nf\t"), 0
    if kind == "ply":
        elements = re.findall(rb"^\s*element\s+(\w+)\s+(\d+)", data[:65536], re.MULTILINE)
        faces = [int(number) for name, number in elements if name == b"face"]
        return max(faces, default=0), max((int(number) for _, number in elements), default=0)
    if kind == "off":
        header = re.match(rb"(?:\s|#.*\n)*\w*OFF(?:\s|#.*\n)+(\d+)\s+(\d+)", data[:65536])
        return (int(header[2]), int(header[1])) if header else (0, 0)
    if kind in ("glb", "gltf"):
        start = 20 if kind == "glb" else 0
        end = start + int.from_bytes(data[12:16], "little") if kind == "glb" else len(data)
        document = json.loads(data[start:end])
        counts = [int(accessor["count"]) for accessor in document.get("accessors", [])]
        meshes = [sum(_corners(part, counts) for part in mesh["primitives"]) for mesh in document.get("meshes", [])]
        placed = [meshes[node["mesh"]] for node in document.get("nodes", []) if "mesh" in node]
        # an accessor without a buffer is zeros, as many as it says
        return sum(placed) // 3, max(counts, default=0)
    return 0, 0


def _corners(primitive: dict[str, Any], counts: list[int]) -> int:
    """Corners of triangles in a part of a glTF mesh, from the counts of its accessors."""
    if primitive.get("mode", 4) != 4:
        return 0
    return counts[int(primitive["indices"] if "indices" in primitive else primitive["attributes"]["POSITION"])]


class _Part(NamedTuple):
    """A body of a file."""

    vertices: Array
    """(V, 3)"""
    faces: Indices
    """(F, 3)"""
    place: Array
    """(4, 4), by which it is moved."""

    @property
    def placed(self) -> Array:
        """Its vertices where they stand."""
        return np.asarray(self.vertices @ self.place[:3, :3].T + self.place[:3, 3])

    @property
    def precision(self) -> float:
        """How far a coordinate may be from what it was meant to be, where the body stands."""
        used_ones = self.vertices[np.unique(self.faces)]
        return coordinate_precision(used_ones) * float(np.linalg.norm(self.place[:3, :3], 2))


def _polygons(path: Path, kind: str, data: bytes, max_faces: int) -> list[_Part]:
    """The contents of a file whose faces may be polygons."""
    polygons = READERS[kind](data)
    _check_count(path, polygons.triangle_count, max_faces)
    if not polygons.exist:
        raise InputError("target.path", path, _NO_VERTEX)
    _check_coordinates(path, polygons.vertices[polygons.corners])
    faces = triangulate(polygons)
    return [_Part(polygons.vertices, faces, np.eye(4))] if len(faces) else []


def _parse(path: Path, kind: str, data: bytes, max_faces: int, limit: int) -> list[_Part]:
    """The bodies of a file, as trimesh reads it."""
    import trimesh  # here: half a second that only a mesh file needs

    parts = []
    with _silence():
        options = {"process": False, "skip_materials": True}
        scene = trimesh.load_scene(io.BytesIO(data), kind, resolver=_Neighbours(path, limit), **options)
        number = 0
        for node in scene.graph.nodes_geometry:
            matrix, geometry_name = scene.graph[node]
            geometry = scene.geometry[geometry_name]
            if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
                number += len(geometry.faces)
                _check_count(path, number, max_faces)  # one small body may stand in a million places
                points = np.asarray(geometry.vertices, dtype=np.float64)
                parts.append(_Part(points, np.asarray(geometry.faces, np.int64), np.asarray(matrix, np.float64)))
    return parts


class _Neighbours(dict[str, Any]):
    """The files beside a mesh by name, as trimesh asks for them: regular ones in its folder, none too large."""

    def __init__(self, path: Path, limit: int) -> None:
        super().__init__()
        self._folder, self._limit = path.resolve().parent, limit

    def __missing__(self, name: str) -> bytes:
        file = (self._folder / unquote(name)).resolve()
        if not file.is_relative_to(self._folder):
            raise ValueError(f"{name} is outside its folder")
        if not file.is_file() or file.stat().st_size > self._limit:
            raise ValueError(f"{name} is missing, no file or too large")
        return regular_bytes(file, self._limit)

    def get(self, name: str, default: Any = None) -> Any:
        return self[name]


def _all_kinds() -> tuple[str, ...]:
    import trimesh

    return tuple(sorted(trimesh.exchange.load.mesh_formats() - {"stl_ascii", "xyz"}))


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep trimesh's warnings, log records and prints from the terminal: what matters is said in one line."""
    logger = logging.getLogger("trimesh")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)  # its children inherit it
    try:
        with (
            warnings.catch_warnings(),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)
