"""The flat crease pattern on its board."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from numpy.typing import NDArray

from origami_lab.drawing.scene import MOUNTAIN, VALLEY
from origami_lab.files import replacing
from origami_lab.fold_format.fold_file import FoldFile

_PAPER = "#fdf6e9"
_INK, _QUIET, _GRID = "#15161c", "#5a5e6c", "#e8eaee"
_STYLES: dict[str, tuple[str, Any]] = {  # in the order of drawing
    "F": ("#b3b6bf", "solid"),
    "J": ("#b3b6bf", "solid"),
    "U": ("#8a8d96", "dotted"),
    "V": (VALLEY, (0, (4.2, 1.6))),
    "M": (MOUNTAIN, "solid"),
    "C": ("#1c9c3c", "solid"),
    "B": ("#15161c", "solid"),
}
_WIDTHS = {"F": 0.8, "J": 0.8}
"""Lines that do not fold are thinner than the others."""
_MOST_TICKS = 16
"""Coordinates along a side."""
_WIDTH, _DRIVEN_WIDTH = 2.0, 3.6
_NAMES = {"M": "mountain", "V": "valley", "F": "flat (does not fold)", "U": "unassigned", "C": "cut", "B": "boundary"}
_MODES = {1: ("#12876f", "mode M = +1"), -1: ("#8e3fb0", "mode M = −1"), 0: ("#a2a5ae", "leaf")}
_GLOW = {"M": "#f9c9c4", "V": "#c6d8f8", "F": "#dddee2"}


def draw_pattern(fold: FoldFile, path: str | os.PathLike[str], *, size: int = 900) -> None:
    """A PNG, ``size`` pixels square, of the crease pattern, as :func:`pattern_figure` draws it."""
    with replacing(path) as part:
        pattern_figure(fold, size).savefig(part, format="png", metadata={"Software": None})


def pattern_figure(fold: FoldFile, size: int = 900) -> Figure:
    """The crease pattern, ``size`` pixels square.

    Mountains red and solid, valleys blue and dashed, the boundary black, flat creases thin and grey, driven creases
    thicker on a glow; vertices by rigid body mode.
    """
    figure = Figure(figsize=(9, 9), dpi=size / 9, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.045, 0.105, 0.93, 0.85))
    low, side = _window(fold.vertices)
    thin = float(np.clip(1.25 - len(fold.vertices) / 400, 0.6, 1.15))
    _draw_board(axes, low, side, fold.metadata.get("board"))
    axes.add_collection(
        PolyCollection(
            [fold.vertices[list(panel)] for panel in fold.panels],
            facecolor=_PAPER,
            edgecolor="none",
            zorder=1,
        )
    )
    segments = fold.vertices[fold.edges]
    letters = np.array(fold.assignments)
    driven = np.zeros(len(letters), bool) if fold.driven is None else fold.driven & (letters != "B")
    _draw_creases(axes, segments, letters, driven, thin)
    _draw_vertices(axes, fold, thin)
    heading = fold.title or "crease pattern"
    counts = f"{len(fold.vertices)} vertices   {int(np.sum(letters != 'B'))} creases   {len(fold.panels)} panels"
    figure.text(0.025, 0.970, heading, fontsize=14, fontweight="bold", color=_INK, va="baseline", parse_math=False)
    figure.text(0.975, 0.970, counts, fontsize=11, color=_QUIET, ha="right", va="baseline", parse_math=False)
    figure.legend(
        handles=_legend(fold, letters, driven),
        loc="lower center",
        bbox_to_anchor=(0.5, 0.008),
        ncol=4,
        frameon=False,
        fontsize=11,
        handlelength=2.6,
        columnspacing=2.2,
        labelspacing=0.45,
    )
    return figure


def _window(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Lower left corner and side of the square shown: the sheet and a little of the board around it."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = float(max(high - low))
    side = extent + max(1.0, 0.06 * extent)
    return (low + high - side) / 2, side


def _draw_board(axes: Axes, low: NDArray[np.float64], side: float, board: object) -> None:
    """The board's grid, in a square frame with the coordinates of its lines; it ends where the board ends."""
    high = low + side
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(_MOST_TICKS, steps=[1, 2, 5, 10], integer=True, min_n_ticks=3))
        axis.set_major_formatter(ScalarFormatter(useOffset=False))
    axes.tick_params(length=0, labelsize=10, labelcolor=_QUIET, pad=4)
    for spine in axes.spines.values():
        spine.set(color="#c9ccd4", linewidth=1.0)
    first, last = np.ceil(low), np.floor(high)
    begin, end = low, high
    if isinstance(board, int):
        board = [board, board]  # points along x and along y
    if isinstance(board, list) and len(board) == 2 and all(isinstance(side, int) and side > 0 for side in board):
        edge = (np.array(board) - 1) / 2
        first, last = np.maximum(first, -edge), np.minimum(last, edge)
        begin, end = first, last
    if side > 200:  # a foreign file in millimetres: no grid would be seen
        return
    lines = [[(x, begin[1]), (x, end[1])] for x in np.arange(first[0], last[0] + 1)]
    lines += [[(begin[0], y), (end[0], y)] for y in np.arange(first[1], last[1] + 1)]
    axes.add_collection(LineCollection(lines, colors=_GRID, linewidths=0.8, zorder=0))


def _draw_creases(
    axes: Axes,
    segments: NDArray[np.float64],
    letters: NDArray[np.str_],
    driven: NDArray[np.bool_],
    thin: float,
) -> None:
    """Creases and boundary; the driven ones on a glow of their colour."""
    for letter, glow in _GLOW.items():
        chosen = segments[driven & (letters == letter)]
        axes.add_collection(LineCollection(chosen, colors=glow, linewidths=10.0 * thin, capstyle="round", zorder=2))
    for letter, (colour, style) in _STYLES.items():
        for thick, width in ((False, _WIDTHS.get(letter, _WIDTH)), (True, _DRIVEN_WIDTH)):
            chosen = segments[(driven == thick) & (letters == letter)]
            axes.add_collection(
                LineCollection(chosen, colors=colour, linestyles=[style], linewidths=width * thin, zorder=3)
            )


def _draw_vertices(axes: Axes, fold: FoldFile, thin: float) -> None:
    """Small dots, coloured by rigid body mode."""
    modes = np.zeros(len(fold.vertices), dtype=np.int8) if fold.modes is None else fold.modes
    for mode, (colour, _) in _MODES.items():
        x, y = fold.vertices[modes == mode].T
        area = (15.0 if mode == 0 else 36.0) * thin * thin
        axes.scatter(x, y, s=area, c=colour, edgecolors="white", linewidths=0.7 * thin, zorder=5)


def _legend(fold: FoldFile, letters: NDArray[np.str_], driven: NDArray[np.bool_]) -> list[Line2D]:
    """One entry for each kind of thing that is in the picture."""
    entries = []
    for letter, label in _NAMES.items():
        if letter in letters:
            colour, style = _STYLES[letter]
            width = 1.1 * _WIDTHS.get(letter, _WIDTH)
            entries.append(Line2D([], [], color=colour, linestyle=style, linewidth=width, label=label))
    if driven.any():
        colour = _STYLES[str(letters[driven][0])][0]
        glow = withStroke(linewidth=10.0, foreground=_GLOW.get(str(letters[driven][0]), "#dddddd"))
        entries.append(Line2D([], [], color=colour, linewidth=3.6, label="driven crease", path_effects=[glow]))
    for mode, (colour, label) in _MODES.items():
        if fold.modes is not None and mode in fold.modes:
            size = 5.0 if mode == 0 else 7.0
            entries.append(Line2D([], [], color=colour, linestyle="none", marker="o", markersize=size, label=label))
    return entries
