"""From a fine board back to board cells: the laid state, and the finished design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.freeze_design import finished_design
from origami_lab.game.kernels.state import States
from origami_lab.polish.finer_board import ANGLES, FineBoard
from origami_lab.polish.lay_kernel import lay_design

STATES = 20
"""Folded states of a polished design, at equal steps up to its driving angle."""


def laid_in_cells(board: FineBoard, angle: float) -> States:
    """One state with a design laid at ten equal steps up to a driving angle in radians, positions in board cells.

    Raises
    ------
    ValueError
        If it is not legal or does not fold.
    """
    states = _laid(board, angle * np.arange(1, ANGLES + 1) / ANGLES)
    states["position"][0][: int(states["n_vertices"][0])] /= board.finer
    return states


def folded_design(board: FineBoard, angle: float, metadata: Mapping[str, object]) -> CreasePattern:
    """The finished design with its motion up to a driving angle in radians, in board cells.

    Raises
    ------
    ValueError
        If it is not legal or does not fold.
    """
    angles = angle * np.arange(1, STATES + 1) / STATES
    parts = []
    for start in range(0, STATES, ANGLES):
        states = _laid(board, angles[start : start + ANGLES])
        sheet = FoldedSheet(states, 0, board.rules)
        parts.append(sheet.points)
    folded = np.concatenate(parts)
    design = finished_design(sheet, folded, angles, STATES - 1, (), metadata)
    return replace(design, vertices=design.vertices / board.finer, folded=design.folded / board.finer)


def _laid(board: FineBoard, angles: np.ndarray[tuple[int], np.dtype[np.float64]]) -> States:
    states = board.new_states()
    if not lay_design(states, board.rules.copy(), False, board.layout, board.points, board.new_notes(), angles):
        raise ValueError("the design is not legal on the fine board, or does not fold")
    return states
