"""A part on its board before anything is folded: from the side, from above, and to turn in a browser."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from PIL import Image

from origami_lab.drawing.figures import INK, QUIET, new_figure
from origami_lab.drawing.folded_picture import Studio, sheet_of, write_caption
from origami_lab.drawing.scene import TargetSurface
from origami_lab.drawing.viewer import viewer_page
from origami_lab.fold_format.fold_file import FoldFile

if TYPE_CHECKING:
    from origami_lab.parts.analysis import PartAnalysis

Array = NDArray[np.float64]
SIZE = 720
_BOARD, _PART, _WALL, _START, _DRIVEN = "#e4e6eb", "#c7e9db", "#58be96", "#f4a858", "#d62828"


def start_sheet(part: PartAnalysis) -> FoldFile:
    """The start panel, flat on the board, as a sheet by itself: what the search begins with."""
    corners, driven = start_outline(part)
    count = len(corners)
    edges = np.array([[k, (k + 1) % count] for k in range(count)], dtype=np.int32)
    return FoldFile(
        vertices=corners,
        edges=edges,
        assignments=("B",) * count,
        fold_angles=np.zeros(count),
        panels=(tuple(range(count)),),
        modes=None,
        driven=driven,
        frames=(),
        title=f"{part.path.stem} on its board",
    )


def start_outline(part: PartAnalysis) -> tuple[Array, NDArray[np.bool_]]:
    """The start panel's corners (n, 2), counter-clockwise, and which of its sides are driven creases (n,).

    Of a single crease there is half a cell on the side that stays; a square whose size is chosen later has one of 2.
    """
    start = part.setup.start
    if "corners" in start:
        return np.array(start["corners"], dtype=np.float64), np.array(start["signs"]) != 0
    if "ends" in start:
        first, second = np.array(start["ends"], dtype=np.float64)
        along = (second - first) / np.linalg.norm(second - first)
        upper = 0.5 * np.array([-along[1], along[0]])
        if start["stays"] == "upper":
            return np.stack([first, second, second + upper, first + upper]), np.array([True, False, False, False])
        return np.stack([first - upper, second - upper, second, first]), np.array([False, False, True, False])
    return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), np.ones(4, dtype=bool)


def part_picture(part: PartAnalysis) -> Image.Image:
    """The part with its start panel from the side, and its board from above."""
    target = part.target()
    surface = TargetSurface(np.array(target.vertices), np.array(target.faces))
    sheet = start_sheet(part)
    half = 0.5 * (np.array(part.setup.board) - 1)
    board = np.array([[x, y, 0.0] for x in (-half[0], half[0]) for y in (-half[1], half[1])])
    studio = Studio(board, surface, SIZE)
    left = studio.picture(sheet_of(sheet), sheet.flat.coords)
    cells = " × ".join(f"{length * part.setup.scale:.3g}" for length in part.extent)
    write_caption(left, part.path.name, f"{cells} cells of {part.cell:.3g} mm", True)
    right = _from_above(part)
    image = Image.new("RGB", (left.width + right.width, max(left.height, right.height)), "white")
    image.paste(left, (0, 0))
    image.paste(right, (left.width, 0))
    return image


def _from_above(part: PartAnalysis) -> Image.Image:
    """The board with the part seen from above, its walls unfolded, and the start panel."""
    figure = new_figure(SIZE / 160, SIZE / 160)
    axes = figure.add_subplot()
    half = 0.5 * (np.array(part.setup.board) - 1)
    lines = [[(x, -half[1]), (x, half[1])] for x in np.arange(-half[0], half[0] + 1)]
    lines += [[(-half[0], y), (half[0], y)] for y in np.arange(-half[1], half[1] + 1)]
    axes.add_collection(LineCollection(lines, colors=_BOARD, linewidths=0.6, zorder=0))
    target = part.target()
    axes.add_collection(
        PolyCollection(list(target.triangles[:, :, :2]), facecolor=_PART, edgecolor=_PART, linewidth=0.3, zorder=1)
    )
    if part.layout is not None:
        walls = [part.setup.scale * outline + part.layout.shift for outline in part.layout.unfolding.outlines]
        axes.add_collection(PolyCollection(walls, facecolor="none", edgecolor=_WALL, linestyle="--", zorder=2))
    corners, driven = start_outline(part)
    axes.add_collection(PolyCollection([corners], facecolor=_START, edgecolor=INK, alpha=0.75, linewidth=0.8, zorder=3))
    sides = [[corners[k], corners[(k + 1) % len(corners)]] for k in np.nonzero(driven)[0]]
    axes.add_collection(LineCollection(sides, colors=_DRIVEN, linewidths=2.4, zorder=4))
    axes.set(xlim=(-half[0] - 0.5, half[0] + 0.5), ylim=(-half[1] - 0.5, half[1] + 0.5), aspect="equal")
    axes.spines[:].set_visible(False)  # the board's own edge is its outermost lines
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(length=0, labelsize=6, labelcolor=QUIET)
    axes.set_title(
        "from above, in cells: board, walls unfolded (dashed), start panel, driven creases (red)",
        fontsize=6,
        color=QUIET,
    )
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return Image.open(stream).convert("RGB")


def png_bytes(image: Image.Image) -> bytes:
    stream = io.BytesIO()
    image.save(stream, format="PNG")
    return stream.getvalue()


def part_page(
    part: PartAnalysis, picture: bytes, facts: Sequence[tuple[str, str]], warnings: Sequence[str], command: str
) -> str:
    """One page, which loads nothing from elsewhere: what was found, the picture, the part to turn, and the command."""
    from origami_lab.pages import page_text

    target = part.target()
    values: dict[str, Any] = {
        "kind": "check",
        "name": part.path.name,
        "picture": base64.b64encode(picture).decode("ascii"),
        "facts": facts,
        "warnings": warnings,
        "command": command,
        "viewer": viewer_page(start_sheet(part), TargetSurface(np.array(target.vertices), np.array(target.faces))),
    }
    style = Path(__file__).with_name("part_check.css")
    return page_text("origami_lab.drawing", "part_check.html.jinja", values, styles=[style])
