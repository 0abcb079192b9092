"""Wavefront OBJ files: vertices and polygons, nothing of what dresses them."""

from __future__ import annotations

from origami_lab.targets.mesh_formats.polygons import Polygons
from origami_lab.targets.mesh_formats.text_lines import lines_of, numbers

_FREE_FORM = ("curv", "curv2", "surf")


def read_obj(data: bytes) -> Polygons:
    """Its faces; groups, objects, materials, normals and texture coordinates are passed over.

    Negative numbers of vertices count back from where they stand. A vertex 0, which does not exist, becomes −1.

    Raises
    ------
    ValueError
        If a vertex or a face cannot be read, or if there are free-form surfaces and no faces.
    """
    lines = lines_of(data)
    last = len(lines) - 1  # whole files end with a line end, so that this one is empty
    words: list[str] = []
    rings: list[list[int]] = []
    free_form = ""
    kept = ""
    for number, line in enumerate(lines):
        if line.endswith("\\") and number < last:  # goes on in the next line
            kept += line[:-1] + " "
            continue
        parts = (kept + line).partition("#")[0].split()
        kept = ""
        if not parts:
            continue
        if parts[0] == "v":
            if len(parts) < 4:
                raise ValueError(f"{_cut(number, last)}a vertex needs three coordinates")
            words += parts[1:4]
        elif parts[0] in ("f", "fo"):
            ring = _ring(parts[1:], len(words) // 3, number)
            if len(ring) >= 3:
                rings.append(ring)
            elif number == last:
                raise ValueError(f"{_cut(number, last)}a face needs three vertices")
        elif parts[0] in _FREE_FORM:
            free_form = parts[0]
    if free_form and not rings:
        raise ValueError(f"it holds free-form surfaces ({free_form}), no polygons")
    return Polygons.of(numbers(words).reshape(-1, 3), rings)


def _ring(references: list[str], vertices: int, number: int) -> list[int]:
    """The vertices of a face, counted from 0."""
    ring = []
    for reference in references:
        try:
            vertex = int(reference.partition("/")[0])
        except ValueError:
            raise ValueError(f"line {number + 1}: {reference[:30]!r} names no vertex") from None
        ring.append(vertex - 1 if vertex >= 0 else vertex + vertices if vertex + vertices >= 0 else -1)
    return ring


def _cut(number: int, last: int) -> str:
    return "cut off in its last line: " if number == last else f"line {number + 1}: "
