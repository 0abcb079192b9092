"""Mesh files written by hand, one part in every format: an L-shaped bar with concave caps."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Points = Sequence[Sequence[float]]
Rings = Sequence[Sequence[int]]

OUTLINE = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)]
VERTICES: Points = [(x, y, z) for z in (0, 2) for x, y in OUTLINE]
FACES: Rings = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *[[k, k + 1, k + 7, k + 6] for k in range(1, 5)],
                [5, 0, 6, 11], [0, 1, 7, 6]]  # fmt: skip
"""The last one has short numbers only: a file that is cut off within it can be told from a whole one."""
CAP = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
TRIANGLES: Rings = [*[t[::-1] for t in CAP], *[tuple(k + 6 for k in t) for t in CAP],
                    *[t for q in FACES[2:] for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]]  # fmt: skip
AREA, VOLUME = 2 * 6 + 14 * 2, 6 * 2
"""Two caps of 6, and 14 around, 2 high."""


def obj(vertices: Points = VERTICES, faces: Rings = FACES) -> str:
    lines = [
        "# a part",
        "mtllib part.mtl",
        "o bar",
        *(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices),
        "vt 0 0",
        "vn 0 0 1",
    ]
    return (
        "\n".join([*lines, "usemtl red", "s off", *("f " + " ".join(f"{k + 1}/1/1" for k in f) for f in faces)]) + "\n"
    )


def relative_obj(vertices: Points = VERTICES, faces: Rings = FACES) -> str:
    """Each face right behind its own vertices, which it counts backwards."""
    lines = []
    for ring in faces:
        lines += [f"v\t{x} {y} {z} 1.0" for x, y, z in (vertices[k] for k in ring)]
        lines.append("f " + " ".join(str(k - len(ring)) for k in range(len(ring))))
    return "\n".join(lines) + "\n"


def off(vertices: Points = VERTICES, faces: Rings = FACES) -> str:
    lines = ["OFF # a part", "", f"{len(vertices)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in vertices)]
    return "\n".join([*lines, *(" ".join(map(str, [len(f), *f])) for f in faces)]) + "\n"


def coloured_off(vertices: Points = VERTICES, faces: Rings = FACES) -> str:
    lines = [f"COFF {len(vertices)} {len(faces)} 0", *(f"{x} {y} {z} 255 0 0 255" for x, y, z in vertices)]
    return "\n".join([*lines, *(" ".join(map(str, [len(f), *f, 3, 0.5, 0.5, 0.5])) for f in faces)]) + "\n"


def stl(vertices: Points = VERTICES, triangles: Rings = TRIANGLES, name: str = "bar") -> str:
    lines = [f"solid {name}"]
    for t in triangles:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += [f"      vertex {x:e} {y:e} {z:e}" for x, y, z in (vertices[k] for k in t)]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, f"endsolid {name}"]) + "\n"


def binary_stl(
    vertices: Points = VERTICES, triangles: Rings = TRIANGLES, header: bytes = b"solid made by a tool"
) -> bytes:
    records = [struct.pack("<12fH", 0, 0, 0, *(c for k in t for c in vertices[k]), 0) for t in triangles]
    return header.ljust(80) + struct.pack("<I", len(records)) + b"".join(records)


def _ply_header(kind: str, vertices: int, faces: int, what: str = "face", extra: bool = False) -> str:
    lines = ["ply", f"format {kind} 1.0", "comment a part", f"element vertex {vertices}", "property float x"]
    lines += ["property double y", "property float z", *(["property uchar red"] if extra else [])]
    lines += [f"element {what} {faces}", *(["property int flags"] if extra else [])]
    lines += [f"property list {'uchar' if what == 'face' else 'int'} int vertex_indices"]
    return "\n".join([*lines, *(["property list uchar float texcoord"] if extra else []), "end_header"]) + "\n"


def ply(vertices: Points = VERTICES, faces: Rings = FACES, what: str = "face") -> str:
    lines = [*(f"{x} {y} {z}" for x, y, z in vertices), *(" ".join(map(str, [len(f), *f])) for f in faces)]
    return _ply_header("ascii", len(vertices), len(faces), what) + "\n".join(lines) + "\n"


def binary_ply(
    order: str, vertices: Points = VERTICES, faces: Rings = FACES, what: str = "face", extra: bool = False
) -> bytes:
    """``order`` is < or >; ``extra`` puts colours, flags and texture coordinates between."""
    kind = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    body = b""
    for x, y, z in vertices:
        body += struct.pack(order + "fdf", x, y, z) + (b"\xff" if extra else b"")
    for f in faces:
        body += struct.pack(order + "i", 7) if extra else b""
        body += struct.pack(f"{order}{'B' if what == 'face' else 'i'}{len(f)}i", len(f), *f)
        body += struct.pack(f"{order}B{2 * len(f)}f", 2 * len(f), *[0.5] * 2 * len(f)) if extra else b""
    return _ply_header(kind, len(vertices), len(faces), what, extra).encode() + body


def y_up(vertices: Points) -> NDArray[np.float32]:
    """As glTF wants them: what is up in the part is y, what is to the back is −z."""
    return np.array([(x, z, -y) for x, y, z in vertices], dtype=np.float32)


def _document(vertices: Points, triangles: Rings, uri: str | None) -> tuple[dict[str, object], bytes]:
    indices = np.array(triangles, dtype=np.uint32).tobytes()
    data = y_up(vertices).tobytes() + indices
    first = 12 * len(vertices)
    if uri is None:
        buffer: dict[str, object] = {"byteLength": len(data)}
    else:
        text = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        buffer = {"byteLength": len(data), "uri": uri or text}
    return {
        "asset": {"version": "2.0"},
        "buffers": [buffer],
        "bufferViews": [
            {"buffer": 0, "byteLength": first},
            {"buffer": 0, "byteOffset": first, "byteLength": len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
    }, data


def gltf(vertices: Points = VERTICES, triangles: Rings = TRIANGLES, uri: str = "", **changes: object) -> str:
    """With its data inside, or at ``uri``."""
    document, _ = _document(vertices, triangles, uri)
    return json.dumps({**document, **changes}, indent=1)


def gltf_data(vertices: Points = VERTICES, triangles: Rings = TRIANGLES) -> bytes:
    return _document(vertices, triangles, None)[1]


def glb(vertices: Points = VERTICES, triangles: Rings = TRIANGLES) -> bytes:
    document, data = _document(vertices, triangles, None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
