"""The crease pattern as DXF R12, lines on layers, for CAD programs, cutters and ORIPA."""

from __future__ import annotations

import os

from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame

LAYERS = {
    "B": "CutLine",
    "C": "CutLine",
    "M": "MountainLine",
    "V": "ValleyLine",
    "F": "FlatLine",
    "J": "FlatLine",
    "U": "UnassignedLine",
}
"""Edge → layer; the first three names are ORIPA's."""
PALETTES = {
    "simulator": {"CutLine": 7, "MountainLine": 1, "ValleyLine": 5, "FlatLine": 8, "UnassignedLine": 6},
    "oripa": {"CutLine": 250, "MountainLine": 5, "ValleyLine": 1, "FlatLine": 8, "UnassignedLine": 6},
}
"""Layer → AutoCAD colour (1 red, 5 blue, 6 magenta, 7 black or white). ORIPA's mountains are blue."""


def write_dxf(
    fold: FoldFile, frame: FoldFrame, path: str | os.PathLike[str], *, scale: float = 1.0, palette: str = "simulator"
) -> None:
    """Write the flat pattern with the creases of ``frame``, ``scale`` units a cell, colours of :data:`PALETTES`."""
    colours = PALETTES[palette]
    tags: list[tuple[int, object]] = [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (0, "ENDSEC")]
    tags += [(0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, len(colours))]
    for name, colour in colours.items():
        tags += [(0, "LAYER"), (2, name), (70, 0), (62, colour), (6, "CONTINUOUS")]
    tags += [(0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]
    for (u, v), letter in zip(fold.edges, frame.assignments, strict=True):
        layer = LAYERS[letter]
        (x1, y1), (x2, y2) = ((fold.vertices[w] * scale).tolist() for w in (u, v))
        tags += [(0, "LINE"), (8, layer), (62, colours[layer])]
        tags += [(10, x1), (20, y1), (30, 0.0), (11, x2), (21, y2), (31, 0.0)]
    tags += [(0, "ENDSEC"), (0, "EOF")]
    write_whole(path, "".join(f"{code:>3}\n{value}\n" for code, value in tags).encode("ascii"))
