"""The crease pattern as .cp, the lines that ORIPA, Oriedita and CP Editor read."""

from __future__ import annotations

import os

from origami_lab.export.svg import drawn
from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame

PAPER = 400.0
"""Side of ORIPA's sheet, around the origin."""
KINDS = {"B": 1, "C": 1, "M": 2, "V": 3, "F": 4, "J": 4, "U": 4}
"""Border, mountain, valley, auxiliary line."""


def write_cp(fold: FoldFile, frame: FoldFrame, path: str | os.PathLike[str]) -> None:
    """Write ``kind x1 y1 x2 y2``, a line an edge: the flat pattern, as large as ORIPA's sheet, creases of ``frame``.

    Those programs draw y downwards, so y is turned around here: the pattern looks as on the board.
    """
    extent = float((fold.vertices.max(axis=0) - fold.vertices.min(axis=0)).max())
    points, size = drawn(fold.vertices, PAPER / extent if extent > 0.0 else 1.0, 0.0)
    points = points - size / 2
    lines = [
        " ".join([str(KINDS[letter]), *(repr(value) for value in (points[[u, v]] + 0.0).ravel().tolist())])
        for (u, v), letter in zip(fold.edges, frame.assignments, strict=True)
    ]
    write_whole(path, "\n".join([*lines, ""]).encode("ascii"))
