"""The crease pattern as SVG, in the colours that Origami Simulator folds."""

from __future__ import annotations

import os
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame

CELL, APART, MARGIN = 40.0, 10.0, 20.0
"""SVG units: of a cell, and between vertices; Origami Simulator merges those within 3 of each other."""
STROKES = {
    "M": "#ff0000",
    "V": "#0000ff",
    "B": "#000000",
    "C": "#00ff00",
    "F": "#ffff00",
    "J": "#ffff00",
    "U": "#ff00ff",
}
"""Exactly these mean something to Origami Simulator."""


def write_svg(fold: FoldFile, frame: FoldFrame, path: str | os.PathLike[str], *, cell: float | None = None) -> None:
    """Write the flat pattern with the creases of ``frame``; the opacity of a crease is |fold angle| / 180°.

    The picture shows the sheet from above, y upwards as on the board; a cell is 40 units, more where vertices would be
    too near to each other. Lines are children of the root and nothing else is drawn, because Origami Simulator reads
    all shapes there and none in groups. With ``cell``, millimetres a board cell, the drawing has that size on paper.
    """
    write_whole(path, svg_text(fold, frame, cell).encode())


def svg_text(fold: FoldFile, frame: FoldFrame, cell: float | None = None) -> str:
    """The text of the file that :func:`write_svg` writes."""
    scale = max(CELL, APART / _nearest(fold.vertices))
    points, size = drawn(fold.vertices, scale, MARGIN)
    lines = []
    for (u, v), letter, angle in zip(fold.edges, frame.assignments, frame.fold_angles, strict=True):
        ends = " ".join(
            f'{name}="{value:.10g}"' for name, value in zip(("x1", "y1", "x2", "y2"), points[[u, v]].flat, strict=True)
        )
        opacity = f' opacity="{min(1.0, abs(angle) / np.pi):.12g}"' if letter in "MV" else ""
        lines.append(f'<line {ends} stroke="{STROKES[letter]}"{opacity} stroke-width="2" stroke-linecap="round"/>')
    width, height = (f"{number:.10g}" for number in size)
    on_paper = [width, height] if cell is None else [f"{number / scale * cell:.10g}mm" for number in size]
    sides = f'width="{on_paper[0]}" height="{on_paper[1]}" viewBox="0 0 {width} {height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {sides}>'
    said = "" if cell is None else f", {cell:.4g} mm a cell"
    title = f"<title>{escape(fold.title or 'crease pattern')}{said}</title>"
    return "\n".join([head, title, *lines, "</svg>", ""])


def _nearest(vertices: NDArray[np.float64]) -> float:
    """The smallest distance of two vertices that are not the same point; infinite where there are none."""
    different = np.unique(vertices, axis=0)
    if len(different) < 2:
        return np.inf
    distances = np.asarray(cKDTree(different).query(different, k=2)[0])
    return float(distances[:, 1].min())


def drawn(
    vertices: NDArray[np.float64], scale: float, margin: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(V, 2) places on a page whose y runs down, and its (2,) width and height; y runs up on the board."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    places = np.column_stack([vertices[:, 0] - low[0], high[1] - vertices[:, 1]]) * scale + margin
    return places, (high - low) * scale + 2 * margin
