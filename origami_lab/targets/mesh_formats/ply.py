"""PLY files, text or binary in either order of bytes, with polygons or strips of triangles."""

from __future__ import annotations

import re
import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.targets.mesh_formats.polygons import Array, Indices, Polygons
from origami_lab.targets.mesh_formats.text_lines import numbers, text_of

_CODES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "float32": "f", "double": "d", "float64": "d",
}  # fmt: skip
"""By name of a type, its letter in :mod:`struct` and numpy alike."""
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_INDICES = ("vertex_indices", "vertex_index", "vertex_indexes")


class _Property(NamedTuple):
    name: str
    code: str
    count_code: str
    """Of the number that a list begins with; empty for what is no list."""


class _Element(NamedTuple):
    name: str
    number: int
    properties: list[_Property]

    @property
    def least_bytes(self) -> int:
        """Fewest bytes that one element takes."""
        return sum(struct.calcsize("<" + (p.count_code or p.code)) for p in self.properties)


class _Lists(NamedTuple):
    """A property that is a list in each element."""

    values: Array
    sizes: Indices


_Table = dict[str, "Array | _Lists"]
"""The values of an element's properties by their names."""


def read_ply(data: bytes) -> Polygons:
    """Its faces and the triangles of its strips; everything else is passed over.

    Raises
    ------
    ValueError
        If the header cannot be read, or if less follows than it promises.
    """
    if data.startswith(b"\xef\xbb\xbf"):
        data = data[3:]
    order, elements, start = _header(data)
    tables = _from_text(elements, data[start:]) if order == "" else _from_binary(elements, data, start, order)
    vertices = tables.get("vertex", {})
    axes = [vertices.get(axis) for axis in "xyz"]
    sizes, corners = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    if faces := tables.get("face"):
        values, lengths = _indices(faces, "faces")
        corners.append(values)
        sizes.append(lengths)
    if strips := tables.get("tristrips"):
        values, lengths = _indices(strips, "strips")
        triangles = _unstripped(values, lengths)
        corners.append(triangles.reshape(-1))
        sizes.append(np.full(len(triangles), 3))
    if not sum(map(len, sizes)) and "range_grid" in tables:
        raise ValueError("it is a range grid, as scanners write it, not a mesh")
    if any(not isinstance(axis, np.ndarray) for axis in axes):
        raise ValueError("its vertices have no x, y and z")
    points = np.column_stack([np.asarray(axis, dtype=np.float64) for axis in axes])
    return Polygons(points, np.concatenate(corners), np.concatenate(sizes))


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """The order of bytes (empty for text), the elements, and where they begin."""
    if not re.match(rb"ply\s", data):
        raise ValueError("it does not begin with ply")
    only_returns = data[3:4] == b"\r" and data[4:5] != b"\n"  # a byte 10 behind them is a value
    end = re.search(rb"[\r\n]\s*end_header[ \t]*(?:%s|$)" % (rb"\r" if only_returns else rb"\r?\n"), data)
    if end is None:
        raise ValueError("cut off: its header has no end_header")
    order, elements = None, list[_Element]()
    for line in re.split(r"[\r\n]+", text_of(data[: end.start()])):
        match line.split():
            case ["format", kind, *_]:
                order = _ORDERS.get(kind)
            case ["element", name, count, *_] if count.isdigit():
                elements.append(_Element(name, int(count), []))
            case ["property", "list", count_type, kind, name, *_] if elements:
                elements[-1].properties.append(_Property(name, _code(kind), _code(count_type)))
            case ["property", kind, name, *_] if elements:
                elements[-1].properties.append(_Property(name, _code(kind), ""))
    if order is None:
        raise ValueError("its header names no format that is known")
    return order, elements, end.end()


def _code(name: str) -> str:
    if name not in _CODES:
        raise ValueError(f"its header names a type that is not known, {name[:30]!r}")
    return _CODES[name]


def _cut_off(element: _Element) -> ValueError:
    return ValueError(f"cut off: it promises {element.number} of {element.name!r} and does not have them all")


def _from_text(elements: list[_Element], data: bytes) -> dict[str, _Table]:
    words = text_of(data).split()
    tables: dict[str, _Table] = {}
    at = 0
    for element in elements:
        properties = element.properties
        if element.number * len(properties) > len(words) - at:
            raise _cut_off(element)
        if not any(p.count_code for p in properties):
            end = at + element.number * len(properties)
            values = numbers(words[at:end]).reshape(element.number, len(properties))
            tables[element.name] = {p.name: values[:, k] for k, p in enumerate(properties)}
            at = end
            continue
        columns: list[tuple[list[str], list[int]]] = [([], []) for _ in properties]
        for _ in range(element.number):
            for prop, (found, sizes) in zip(properties, columns, strict=True):
                if at >= len(words):
                    raise _cut_off(element)
                size = 1
                if prop.count_code:
                    size = int(numbers(words[at : at + 1])[0])
                    at += 1
                if not 0 <= size <= len(words) - at:
                    raise _cut_off(element)
                found += words[at : at + size]
                sizes.append(size)
                at += size
        tables[element.name] = {
            p.name: _Lists(numbers(found), np.array(sizes, dtype=np.int64)) if p.count_code else numbers(found)
            for p, (found, sizes) in zip(properties, columns, strict=True)
        }
    return tables


def _from_binary(elements: list[_Element], data: bytes, at: int, order: str) -> dict[str, _Table]:
    tables: dict[str, _Table] = {}
    for element in elements:
        if element.number * element.least_bytes > len(data) - at:
            raise _cut_off(element)
        sizes = _first_sizes(element, data, at, order)
        fields = [_fields(p, size, order) for p, size in zip(element.properties, sizes, strict=True)]
        row = np.dtype([field for group in fields for field in group])
        if at + element.number * row.itemsize <= len(data):
            rows = np.frombuffer(data, row, element.number, at)
            lists = [p for p in element.properties if p.count_code]
            if all((rows["count of " + p.name] == rows["count of " + p.name][:1]).all() for p in lists):
                tables[element.name] = {p.name: _column(p, rows) for p in element.properties}
                at += rows.nbytes
                continue
        tables[element.name], at = _row_by_row(element, data, at, order)
    return tables


def _fields(prop: _Property, size: int, order: str) -> list[tuple[str, str] | tuple[str, str, tuple[int]]]:
    """How a row holds a property whose list has this size."""
    if not prop.count_code:
        return [(prop.name, order + prop.code)]
    return [("count of " + prop.name, order + prop.count_code), (prop.name, order + prop.code, (size,))]


def _first_sizes(element: _Element, data: bytes, at: int, order: str) -> list[int]:
    """How long the lists of the first row are, if there is one: mostly, all others' are, too."""
    sizes = []
    for prop in element.properties:
        size = 1
        if prop.count_code:
            size, at = _number(prop.count_code, data, at, order, element) if element.number else (0, at)
            if not 0 <= size <= len(data):
                raise _cut_off(element)
        at += size * struct.calcsize(order + prop.code)
        sizes.append(size)
    return sizes


def _number(code: str, data: bytes, at: int, order: str, element: _Element) -> tuple[int, int]:
    """A whole number and where it ends."""
    end = at + struct.calcsize(order + code)
    if end > len(data):
        raise _cut_off(element)
    return int(struct.unpack_from(order + code, data, at)[0]), end


def _column(prop: _Property, rows: NDArray[np.void]) -> Array | _Lists:
    values = rows[prop.name].astype(np.float64)
    if not prop.count_code:
        return values
    return _Lists(values.reshape(-1), np.full(len(rows), values.shape[1]))


def _row_by_row(element: _Element, data: bytes, at: int, order: str) -> tuple[_Table, int]:
    """The values of an element whose lists differ in length, and where they end."""
    columns: list[tuple[list[float], list[int]]] = [([], []) for _ in element.properties]
    for _ in range(element.number):
        for prop, (found, sizes) in zip(element.properties, columns, strict=True):
            size = 1
            if prop.count_code:
                size, at = _number(prop.count_code, data, at, order, element)
            end = at + size * struct.calcsize(order + prop.code)
            if size < 0 or end > len(data):
                raise _cut_off(element)
            found += struct.unpack_from(f"{order}{size}{prop.code}", data, at)
            sizes.append(size)
            at = end
    table: _Table = {
        p.name: _Lists(np.array(found, dtype=np.float64), np.array(sizes, dtype=np.int64))
        if p.count_code
        else np.array(found, dtype=np.float64)
        for p, (found, sizes) in zip(element.properties, columns, strict=True)
    }
    return table, at


def _indices(table: _Table, what: str) -> tuple[Indices, Indices]:
    """The list that names vertices: all of them, and how many each element has."""
    found = next((table[name] for name in _INDICES if name in table), None)
    if not isinstance(found, _Lists):
        raise ValueError(f"its {what} do not say which vertices they have ({_INDICES[0]})")
    with np.errstate(invalid="ignore"):
        return found.values.astype(np.int64), found.sizes


def _unstripped(values: Indices, sizes: Indices) -> Indices:
    """(T, 3) triangles of strips; −1 ends one and begins another, every other triangle is turned over."""
    triangles = [np.zeros((0, 3), dtype=np.int64)]
    for row in np.split(values, np.cumsum(sizes)[:-1]):
        for part in np.split(row, np.nonzero(row < 0)[0]):
            strip = part[part >= 0]
            if len(strip) < 3:
                continue
            cut = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
            cut[1::2] = cut[1::2, [1, 0, 2]]
            # strips repeat a vertex to turn a corner
            triangles.append(cut[(cut[:, 0] != cut[:, 1]) & (cut[:, 1] != cut[:, 2]) & (cut[:, 2] != cut[:, 0])])
    return np.concatenate(triangles)
