"""One page that shows a design, flat and folded, in a browser and without a network."""

from __future__ import annotations

import base64
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from origami_lab.drawing.scene import TargetSurface
from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.panel_triangles import triangulate

_PAGE = Path(__file__).with_name("viewer_page")
LARGEST_TARGET = 50_000
"""Triangles; 300 kB of the page hold about 10,000."""


def write_viewer(
    fold: FoldFile, path: str | os.PathLike[str], target: TargetSurface | None = None, frame: FoldFrame | None = None
) -> None:
    """Write the page: the pattern, the sheet in space at every driving angle that the file has, the target.

    It begins with ``frame``, the best state by default; ``#angle=DEGREES`` after its address says otherwise. A target
    of more than :data:`LARGEST_TARGET` triangles is left out.
    """
    write_whole(path, viewer_page(fold, target, frame).encode())


def viewer_page(
    fold: FoldFile, target: TargetSurface | None = None, frame: FoldFrame | None = None, script: str | None = None
) -> str:
    """The page as text, see :func:`write_viewer`.

    Parameters
    ----------
    script
        Where the page finds :func:`viewer_script`, for many pages in one folder; None to have it in the page.
    """
    from markupsafe import Markup

    from origami_lab.pages import PATTERN, page_text, script_json

    values = {
        "kind": "design",
        "title": fold.title or "rigid origami",
        "facts": _facts(fold),
        "design": Markup(script_json(viewer_data(fold, target, frame or fold.best))),
        "licence": Markup(_read("LICENSE-three.txt").replace("--", "- -")),
        "source": script,
        "code": Markup(viewer_script()) if script is None else "",
    }
    return page_text("origami_lab.drawing", "viewer_page/page.html.jinja", values, styles=[PATTERN, _PAGE / "page.css"])


def viewer_script() -> str:
    """The common part of all pages: 600 kB, most of it three.js."""
    return _read("viewer.js")


def viewer_data(fold: FoldFile, target: TargetSurface | None, shown: FoldFrame) -> dict[str, Any]:
    """The data that the page's script reads; the script's source names each field."""
    states = [fold.flat, *fold.motion]
    known = all(frame.driving_angle is not None for frame in states)
    # without driving angles the states are counted
    places = [abs(math.degrees(frame.driving_angle or 0.0)) if known else k for k, frame in enumerate(states)]
    at = next((place for place, frame in zip(places, states, strict=True) if frame is shown), 0.0)
    triangles, owners = triangulate(fold.vertices, fold.panels)
    return {
        "vertices": _rounded(fold.vertices),
        "modes": None if fold.modes is None else fold.modes.tolist(),
        "edges": fold.edges.tolist(),
        "letters": list(fold.assignments),
        "driven": None if fold.driven is None else fold.driven.tolist(),
        "panels": [list(panel) for panel in fold.panels],
        "sides": _sides(fold),
        "triangles": triangles.tolist(),
        "owners": owners.tolist(),
        "states": [
            {
                "at": round(place, 6),
                "coords": _rounded(frame.coords.ravel()),
                "folds": np.round(np.degrees(frame.fold_angles), 3).tolist(),
            }
            for place, frame in zip(places, states, strict=True)
        ],
        "unit": "°" if known else "",
        "best": round(at, 6),
        "upright": fold.upright.tolist(),
        "target": packed_surface(target) if target is not None and len(target.faces) <= LARGEST_TARGET else None,
    }


def _rounded(numbers: Any) -> Any:
    """To 10⁻⁵ cells, far below what a screen shows."""
    return (np.round(numbers, 5) + 0.0).tolist()


def _sides(fold: FoldFile) -> list[list[int]]:
    """The edges around each panel."""
    number = {frozenset(edge): e for e, edge in enumerate(fold.edges.tolist())}
    return [
        [number[side] for side in map(frozenset, zip(panel, _turned(panel), strict=True)) if side in number]
        for panel in fold.panels
    ]


def _turned(panel: Sequence[int]) -> tuple[int, ...]:
    return (*panel[1:], panel[0])


def packed_surface(target: TargetSurface) -> dict[str, str]:
    """The target as base64 of little-endian numbers; vertices that a file repeats for each triangle only once."""
    vertices, which = np.unique(target.vertices.astype("<f4"), axis=0, return_inverse=True)
    faces = which.reshape(-1)[target.faces].astype("<u4")
    return {
        "vertices": base64.b64encode(vertices.tobytes()).decode(),
        "faces": base64.b64encode(faces.tobytes()).decode(),
    }


def _facts(fold: FoldFile) -> list[tuple[str, str]]:
    """The heading of the page."""
    value = fold.metadata.get("return")
    facts = []
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9:
        facts.append(("return", f"{value:z.4f}".replace("-", "−")))
        if fold.cell is not None and fold.metadata.get("return_in") == "cells":
            facts.append(("distance", f"{abs(value) * fold.cell:.3g} mm"))
    if fold.frames and fold.best.driving_angle is not None:
        facts.append(("best driving angle", f"{abs(math.degrees(fold.best.driving_angle)):.1f}°"))
    creases = sum(letter not in "BC" for letter in fold.assignments)
    if fold.cell is not None:
        wide, high = np.ptp(fold.vertices, axis=0) * fold.cell
        facts += [("board cell", f"{fold.cell:.4g} mm"), ("sheet", f"{wide:.4g} × {high:.4g} mm")]
    counts = (("panels", len(fold.panels)), ("creases", creases), ("vertices", len(fold.vertices)))
    return [*facts, *((name, str(count)) for name, count in counts)]


def _read(name: str) -> str:
    return (_PAGE / name).read_text(encoding="utf-8")
