"""Patterns for the tests of the verification, from closed forms."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.writer import to_fold
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs
from tests.known_designs import game_moves as known

Array = NDArray[np.float64]


def known_design(name: str) -> CreasePattern:
    """The known pyramid or cube, from the game."""
    game, moves = getattr(known, name)()
    return game.design(game.finished_actions(game.replay_moves(moves)))


def known_chair(*angles: float) -> CreasePattern:
    """The known chair without regard to collisions at driving angles in degrees; none: ten up to 1.57 rad."""
    game, moves = known.chair(collisions=False, largest=1.57)
    actions = game.finished_actions(game.replay_moves(moves))
    return game.motion(actions, np.radians(angles), {}) if angles else game.design(actions)


def strip(
    widths: Sequence[float], signs: Sequence[int], angles: Sequence[float], tab: tuple[float, float] | None = None
) -> CreasePattern:
    """Panels side by side along x, y in [0, 1], the creases between them folding by ± the driving angle.

    With ``tab`` (start, gap) the last panel has a tab, y in [1 + gap, 2], that reaches back to x = start, and the
    first panel reaches up to y = 2.
    """
    x = np.concatenate([[0.0], np.cumsum(widths)])
    vertices = [(float(at), y) for at in x for y in (0.0, 1.0)]
    panels = [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(len(widths))]
    owner = [0, *range(len(widths))]  # of each column of vertices
    columns = [owner[i // 2] for i in range(len(vertices))]
    if tab is not None:
        start, gap = tab
        n = len(vertices)
        vertices += [
            (0.0, 2.0),
            (float(x[1]), 2.0),
            (start, 1.0 + gap),
            (start, 2.0),
            (float(x[-1]), 2.0),
            (float(x[-2]), 1.0 + gap),
        ]
        last = len(widths) - 1
        columns += [0, 0, last, last, last, last]
        panels[0] = (0, 2, 3, n + 1, n, 1)
        a, b, c, d = panels[last]
        panels[last] = (a, b, c, n + 4, n + 3, n + 2, n + 5, d)
    flat = np.array(vertices)

    def fold(rho: float) -> Array:
        turn, shift = np.eye(3), np.zeros(3)
        out = np.zeros((len(flat), 3))
        for i in range(len(widths)):
            if i:
                before = turn @ [x[i], 0.0, 0.0] + shift
                turn = turn @ designs.rotation([0, -1, 0], signs[i - 1] * rho)
                shift = before - turn @ [x[i], 0.0, 0.0]
            mine = [v for v, column in enumerate(columns) if column == i]
            out[mine] = np.column_stack([flat[mine], np.zeros(len(mine))]) @ turn.T + shift
        return out

    creases = [(2 * i, 2 * i + 1) for i in range(1, len(widths))]
    return designs.design(
        vertices, panels, fold, best=len(angles) - 1, driven=creases, driving_angles=np.radians(angles)
    )


def miura_sheet(rows: int, columns: int, gamma: float, driving: float) -> dict[str, Any]:
    """A Miura-ori of parallelograms with the acute angle γ, folded by its closed form, as a file of fold angles only.

    Zigzag lines run along x and fold by ±ζ, straight ones along y by ± the driving angle ρ, where
    tan(ρ/2) = cos γ·tan(ζ/2) (angles in degrees).
    """
    slant = 1.0 / math.tan(math.radians(gamma))
    coords = [[j, i + slant * (j % 2)] for i in range(rows + 1) for j in range(columns + 1)]
    at = [[i * (columns + 1) + j for j in range(columns + 1)] for i in range(rows + 1)]
    zigzag = 2 * math.degrees(math.atan(math.tan(math.radians(driving) / 2) / math.cos(math.radians(gamma))))
    edges, letters, angles = [], [], []
    for i in range(rows + 1):
        for j in range(columns + 1):
            if j < columns:  # along a zigzag: all of one line fold the same way
                inner = 0 < i < rows
                edges.append([at[i][j], at[i][j + 1]])
                angles.append(zigzag * (-1) ** i if inner else 0.0)
                letters.append("B" if not inner else "V" if i % 2 == 0 else "M")
            if i < rows:  # along a straight line: the ways alternate
                inner, up = 0 < j < columns, (i + j) % 2 == 1
                edges.append([at[i][j], at[i + 1][j]])
                angles.append(driving * (1 if up else -1) if inner else 0.0)
                letters.append("B" if not inner else "V" if up else "M")
    faces = [[at[i][j], at[i][j + 1], at[i + 1][j + 1], at[i + 1][j]] for i in range(rows) for j in range(columns)]
    return {
        "vertices_coords": coords,
        "edges_vertices": edges,
        "edges_assignment": letters,
        "edges_foldAngle": angles,
        "faces_vertices": faces,
    }


def write(path: Path, fold: dict[str, Any]) -> Path:
    """The FOLD object as a file."""
    path.write_text(json.dumps(fold), encoding="utf-8")
    return path


def changed(design: CreasePattern, change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    """The design as a FOLD object with a change made to it."""
    fold = copy.deepcopy(to_fold(design))
    change(fold)
    return fold


def foreign(design: CreasePattern) -> dict[str, Any]:
    """The design as other programs would write it: without our keys."""
    fold = {key: value for key, value in to_fold(design).items() if "origami_lab" not in key}
    fold["file_creator"] = "another"
    for frame in fold["file_frames"]:
        del frame["origami_lab:driving_angle"]
    return fold
