"""Figures, and their files: the same bytes for the same input, as PNG and SVG."""

from __future__ import annotations

import io
from pathlib import Path

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


def png_bytes(figure: Figure) -> bytes:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def svg_bytes(figure: Figure) -> bytes:
    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "origami-lab", "svg.fonttype": "path"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def save(figure: Figure, stem: Path) -> None:
    """Write ``stem.png`` and ``stem.svg``."""
    stem.with_name(f"{stem.name}.png").write_bytes(png_bytes(figure))
    stem.with_name(f"{stem.name}.svg").write_bytes(svg_bytes(figure))
