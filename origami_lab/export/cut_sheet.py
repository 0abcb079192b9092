"""A sheet in millimetres for a laser cutter or a plotter: what to cut, and what to score, dashed."""

from __future__ import annotations

import math
import os
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.export.pdf import pdf_page
from origami_lab.export.svg import drawn
from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.lengths import MARGIN, SHEETS

Line = NDArray[np.float64]

LAYERS = {"cut": "#000000", "mountain": "#ff0000", "valley": "#0000ff", "unassigned": "#ff00ff"}
"""Layer → colour: cutters tell operations apart by either."""
SCORED = {"M": "mountain", "V": "valley", "U": "unassigned"}
DASHES = {"mountain": (6.0, 2.0), "valley": (2.5, 2.5), "unassigned": (2.5, 2.5)}
"""Millimetres scored and left out."""
CLEAR = 1.5
"""Millimetres left out at each end of a crease: scores that meet in a vertex tear it."""
HAIRLINE = 0.1
"""Millimetres; many cutters cut only lines this thin."""


@dataclass(frozen=True)
class CutSheet:
    """Lines on a sheet, millimetres from its upper left corner, y downwards."""

    width: float
    height: float
    cell: float
    """Millimetres a board cell."""
    layers: dict[str, list[Line]]
    """Layer → polylines, (N, 2) each; a closed one ends where it begins. None is empty."""
    title: str


def lay_out(
    fold: FoldFile,
    frame: FoldFrame,
    cell: float | None = None,
    sheet: tuple[float, float] | None = None,
    margin: float = MARGIN,
) -> CutSheet:
    """Put the flat pattern, seen from above, in the middle of a sheet.

    Parameters
    ----------
    cell
        Millimetres a board cell; by default as large as fits the sheet.
    sheet
        Width and height in millimetres, turned if the pattern is larger on it then. By default A4 or, with ``cell``,
        as large as need be.
    margin
        Millimetres that stay free at each side.

    Raises
    ------
    InputError
        If the pattern does not fit.
    """
    extent = fold.vertices.max(axis=0) - fold.vertices.min(axis=0)
    if sheet is None and cell is not None:
        sheet = float(extent[0] * cell + 2 * margin), float(extent[1] * cell + 2 * margin)
    width, height = sheet or SHEETS["A4"]
    rooms = [(w - 2 * margin, h - 2 * margin) for w, h in ((width, height), (height, width))]
    if min(rooms[0]) <= 0.0:
        raise InputError("margin", f"{margin:g}", f"must leave room on a sheet of {width:g} × {height:g} mm")
    most = [min(room / max(side, 1e-9) for room, side in zip(found, extent, strict=True)) for found in rooms]
    if most[1] > most[0] * (1 + 1e-9):
        width, height = height, width
    largest = max(most)
    if cell is None:
        cell = largest
    elif cell > largest * (1 + 1e-9):
        asked = f"{extent[0] * cell:.1f} × {extent[1] * cell:.1f} mm"
        expected = f"must be at most {math.floor(largest * 100) / 100:g}: the pattern would be {asked}, the sheet has "
        room = rooms[int(np.argmax(most))]
        raise InputError("cell", f"{cell:g}", f"{expected}{room[0]:g} × {room[1]:g} mm within its margins")
    points, size = drawn(fold.vertices, cell, 0.0)
    points += (np.array([width, height]) - size) / 2
    layers: dict[str, list[Line]] = {name: [] for name in LAYERS}
    around = [edge for edge, letter in zip(fold.edges.tolist(), frame.assignments, strict=True) if letter in "BC"]
    layers["cut"] = [points[path] for path in chains(around)]
    for edge, letter in zip(fold.edges, frame.assignments, strict=True):
        if letter in SCORED:
            name = SCORED[letter]
            layers[name] += dashes(points[edge[0]], points[edge[1]], *DASHES[name])
    layers = {name: lines for name, lines in layers.items() if lines}
    return CutSheet(width, height, cell, layers, fold.title or "crease pattern")


def dashes(start: Line, end: Line, dash: float, gap: float, clear: float = CLEAR) -> list[Line]:
    """The (2, 2) pieces to be scored: a dash begins and one ends ``clear`` from the ends of the crease.

    All are scaled by the same factor to fill it; a crease that is too short has one, over its middle half.
    """
    length = float(np.linalg.norm(end - start))
    free = length - 2 * clear
    if free < min(dash, length / 2):
        clear, free = length / 4, length / 2
    count = max(1, round((free + gap) / (dash + gap)))
    factor = free / (count * dash + (count - 1) * gap)
    first = clear + factor * (dash + gap) * np.arange(count)
    return [
        start + (end - start) * (np.array([[begin], [begin + factor * dash]]) / max(length, 1e-12)) for begin in first
    ]


def chains(edges: Sequence[Sequence[int]]) -> list[list[int]]:
    """Edges joined into as long paths as they make, so that a blade or a beam goes on without a stop."""
    beside: dict[int, list[int]] = defaultdict(list)
    for u, v in edges:
        beside[u].append(v)
        beside[v].append(u)
    paths = []
    # a path that is not closed is begun at an end, not in its middle
    for start in sorted(beside, key=lambda vertex: len(beside[vertex]) % 2 == 0):
        while beside[start]:
            path = [start]
            while beside[path[-1]]:
                following = beside[path[-1]].pop()
                beside[following].remove(path[-1])
                path.append(following)
            paths.append(path)
    return paths


def write_cut(sheet: CutSheet, path: str | os.PathLike[str]) -> None:
    """Write the sheet as SVG or PDF, by the suffix; both have real millimetres and a layer each for cut and scores."""
    path = Path(path)
    if path.suffix.lower() == ".pdf":
        layers = [(name, _rgb(LAYERS[name]), lines) for name, lines in sheet.layers.items()]
        write_whole(path, pdf_page(sheet.width, sheet.height, layers, HAIRLINE, sheet.title))
    else:
        write_whole(path, _svg(sheet).encode())


def parse_sheet(text: str) -> tuple[float, float]:
    """One of :data:`SHEETS`, or WIDTHxHEIGHT in millimetres. Raises :class:`InputError`."""
    if text.upper() in SHEETS:
        return SHEETS[text.upper()]
    parts = text.lower().removesuffix("mm").replace("×", "x").split("x")
    try:
        width, height = (float(part) for part in parts)
    except ValueError:
        width = height = math.nan
    if not (0.0 < width <= 1e5 and 0.0 < height <= 1e5):
        raise InputError(
            "sheet", text, "must be A0 to A6, letter, legal, tabloid or WIDTHxHEIGHT in millimetres, like 300x200"
        )
    return width, height


def _svg(sheet: CutSheet) -> str:
    """Groups that Inkscape shows as layers."""
    page = f'width="{sheet.width:.10g}mm" height="{sheet.height:.10g}mm" '
    page += f'viewBox="0 0 {sheet.width:.10g} {sheet.height:.10g}"'
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    parts = [f"<svg {spaces} {page}>", f"<title>{escape(sheet.title)}, {sheet.cell:.4g} mm a cell</title>"]
    for name, lines in sheet.layers.items():
        style = f'fill="none" stroke="{LAYERS[name]}" stroke-width="{HAIRLINE}"'
        parts.append(f'<g id="{name}" inkscape:groupmode="layer" inkscape:label="{name}" {style}>')
        for line in lines:
            closed = len(line) > 2 and np.array_equal(line[0], line[-1])
            body = "L".join(f"{x:.6f},{y:.6f}" for x, y in (line[:-1] if closed else line))
            parts.append(f'<path d="M{body}{"Z" if closed else ""}"/>')
        parts.append("</g>")
    return "\n".join([*parts, "</svg>", ""])


def _rgb(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return red, green, blue
