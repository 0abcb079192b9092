"""OFF files, Geomview's object file format, as text."""

from __future__ import annotations

import re

from origami_lab.targets.mesh_formats.polygons import Polygons
from origami_lab.targets.mesh_formats.text_lines import lines_of, numbers


def read_off(data: bytes) -> Polygons:
    """Its faces; colours, normals and texture coordinates (COFF, NOFF, STOFF) are passed over.

    Raises
    ------
    ValueError
        If it holds other things than points in space, or less than it promises.
    """
    lines = [line for line in (line.partition("#")[0].strip() for line in lines_of(data)) if line]
    header = re.match(r"((?:ST)?C?N?)(4?)(n?)OFF\b", lines[0]) if lines else None
    if header:
        if header[2] or header[3]:
            raise ValueError(f"{header[0]}: its points are not those of space")
        rest = lines[0][header.end() :].strip()
        if rest.upper().startswith("BINARY"):
            raise ValueError("a binary OFF file: save it as text")
        lines = [rest, *lines[1:]] if rest else lines[1:]
    elif lines and not re.match(r"\d+\s+\d+\s+\d+$", lines[0]):
        raise ValueError("it does not begin with OFF")
    counts = lines[0].split() if lines else []
    if len(counts) < 2 or not all(word.isdigit() for word in counts[:2]):
        raise ValueError("the numbers of vertices and faces are missing")
    vertex_count, face_count = map(int, counts[:2])
    body = [line.split() for line in lines[1 : 1 + vertex_count + face_count]]
    if len(body) < vertex_count + face_count:
        what = f"{vertex_count} vertices and {face_count} faces"
        raise ValueError(f"cut off: it promises {what} and has {len(body)} lines of them")
    short = next((k for k, parts in enumerate(body[:vertex_count]) if len(parts) < 3), None)
    if short is not None:
        raise ValueError(f"vertex {short} has less than three coordinates")
    vertices = numbers(word for parts in body[:vertex_count] for word in parts[:3]).reshape(-1, 3)
    rings = [_ring(parts, number, face_count) for number, parts in enumerate(body[vertex_count:])]
    return Polygons.of(vertices, [ring for ring in rings if len(ring) >= 3])


def _ring(parts: list[str], number: int, count: int) -> list[int]:
    try:
        size, *ring = map(int, parts[: int(parts[0]) + 1])
    except ValueError:
        raise ValueError(f"face {number} is no list of vertices") from None
    if len(ring) < size:
        cut = "cut off in its last line: " if number == count - 1 else ""
        raise ValueError(f"{cut}face {number} promises {size} vertices and has {len(ring)}")
    return ring
