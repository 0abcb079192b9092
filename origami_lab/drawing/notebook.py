"""A design that shows itself in a notebook: the viewer, in a frame of its own, without a network."""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from pathlib import Path

from origami_lab.drawing.scene import TargetSurface, read_target, target_of
from origami_lab.drawing.viewer import viewer_page
from origami_lab.fold_format.fold_file import FoldFile
from origami_lab.fold_format.motion_frames import fold_path, read_motion
from origami_lab.fold_format.writer import as_fold_file
from origami_lab.game.crease_pattern import CreasePattern

HEIGHT = 480
"""Pixels."""


@dataclass(frozen=True, eq=False)
class NotebookView:
    """A design as notebooks show it."""

    fold: FoldFile
    target: TargetSurface | None = None
    height: int = HEIGHT

    def _repr_html_(self) -> str:
        """The viewer in a frame that can run its script and nothing else: no access to the notebook."""
        page = escape(viewer_page(self.fold, self.target))
        style = f"width:100%;height:{self.height}px;border:1px solid #dcdfe5;border-radius:6px"
        return f'<iframe sandbox="allow-scripts" title="rigid origami" style="{style}" srcdoc="{page}"></iframe>'


def show(
    source: CreasePattern | FoldFile | str | os.PathLike[str],
    target: TargetSurface | str | os.PathLike[str] | None = None,
    height: int = HEIGHT,
) -> NotebookView:
    """A view of a design for the end of a notebook's cell: flat and folded, and to be folded.

    Parameters
    ----------
    source
        A design, a FOLD file, or its path, or the folder of a trial, whose motion and target are shown, too.
    target
        A mesh to show beside the sheet.
    height
        Of the frame, in pixels.

    Raises
    ------
    InputError
        If a file cannot be read.
    """
    if isinstance(target, str | os.PathLike):
        target = read_target(target)
    if isinstance(source, CreasePattern):
        return NotebookView(as_fold_file(source), target, height)
    if isinstance(source, FoldFile):
        return NotebookView(source, target, height)
    path: Path = fold_path(source)
    return NotebookView(read_motion(path), target_of(path) if target is None else target, height)
