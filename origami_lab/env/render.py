"""A state as a picture: its crease pattern, and the sheet folded over the target."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from origami_lab.search.problem import Positions, Problem
from origami_lab.targets.target import Target

SIDE = 450
"""Pixels."""


def picture(problem: Problem, positions: Positions, i: int) -> NDArray[np.uint8]:
    """(SIDE, 2·SIDE, 3) the sheet of position i, flat and at the best driving angle; white before there is one."""
    from PIL import Image

    from origami_lab.drawing import TargetSurface, draw_folded, draw_pattern
    from origami_lab.fold_format.writer import read_fold, write_fold

    game, states = problem.game, positions.states
    if int(states["n_triangles"][i]) == 0:
        return np.full((SIDE, 2 * SIDE, 3), 255, dtype=np.uint8)
    score = problem.evaluator.score(states, positions.memos, i)
    best = score.angle if score.angle >= 0 else None
    design = game.design(game.finished_actions(states, i), best, {"board": game.board_fact})
    target = getattr(problem.objective, "target", None)
    surface = TargetSurface(target.vertices, target.faces) if isinstance(target, Target) else None
    # pictures are made of files and become files
    with tempfile.TemporaryDirectory(prefix="origami-lab-") as folder:
        place = Path(folder)
        write_fold(place / "state.fold", design)
        fold = read_fold(place / "state.fold")
        draw_pattern(fold, place / "pattern.png", size=SIDE)
        draw_folded(fold, place / "folded.png", surface, size=SIDE)
        halves = []
        for name in ("pattern.png", "folded.png"):
            with Image.open(place / name) as image:
                halves.append(np.asarray(image.convert("RGB")))
    return np.concatenate(halves, axis=1)
