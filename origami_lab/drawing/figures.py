"""Figures, and their files: the same bytes for the same input, as PNG and SVG."""

from __future__ import annotations

import io

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

INK, QUIET, HIGHLIGHT = "#15161c", "#5a5e6c", "#1d5fd1"
_DPI = 160


def new_figure(width: float, height: float) -> Figure:
    """An empty white figure, in inches, that belongs to nothing global."""
    figure = Figure(figsize=(width, height), dpi=_DPI, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def png_and_svg(figure: Figure) -> tuple[bytes, bytes]:
    """The contents of the two files; nothing in them tells when or by what they were written."""
    png, svg = io.BytesIO(), io.BytesIO()
    figure.savefig(png, format="png", metadata={"Software": None})
    figure.set_layout_engine("none")  # what was laid out for the first one holds for the second
    for image in (image for axes in figure.axes for image in axes.images):
        image.set_interpolation("none")  # an SVG keeps pictures as they are
    with matplotlib.rc_context({"svg.hashsalt": "origami-lab", "svg.fonttype": "path"}):
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    return png.getvalue(), svg.getvalue()
