"""The figures of a design on the board, and where it is furthest from its target."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.geometry.bvh import build_bvh, distances, inside
from origami_lab.objectives.objective import report
from origami_lab.objectives.shape import TARGET_SAMPLES, ShapeObjective
from origami_lab.polish.pattern_measures import pattern_figures


@dataclass(frozen=True)
class Furthest:
    """A place and how far it is from the other surface, in board cells."""

    at: tuple[float, float, float]
    board: tuple[float, float] | None
    """Where it is on the flat sheet, if it is a vertex of it."""
    distance: float


@dataclass(frozen=True)
class Measured:
    """The figures of a design."""

    figures: dict[str, float]
    sharpest: float | None
    """Smallest angle at a corner of a panel, degrees."""
    narrowest: float | None
    """Width of the narrowest panel, board cells."""
    sheet: Furthest | None
    target: Furthest | None


def measure_design(game: Game, objective: Any, actions: tuple[int, ...], angle: int) -> Measured:
    """The figures of a design at one driving angle."""
    figures = {name: value for name, value in report(objective, game, actions, angle).items() if math.isfinite(value)}
    made = pattern_figures(game.design(actions, angle))
    sheet, target = furthest(game, objective, actions, angle) if isinstance(objective, ShapeObjective) else (None, None)
    return Measured(figures, _finite(made.smallest_sector), _finite(made.smallest_width), sheet, target)


def furthest(
    game: Game, objective: ShapeObjective, actions: tuple[int, ...], angle: int
) -> tuple[Furthest | None, Furthest | None]:
    """The folded vertex that is furthest from the target, and the place of the target furthest from the sheet.

    Vertices inside a closed target are not far from it. Neither is told where the sheet has no area.
    """
    sheet, target = game.sheet(game.replay(actions)), objective.target
    points = np.ascontiguousarray(sheet.points[angle])
    if not len(sheet.triangles):
        return None, None
    away = distances(target.bvh, points)
    if target.closed:
        away = np.where([inside(target.bvh, *point) for point in points], 0.0, away)
    vertex = int(np.argmax(away))
    samples = target.samples(math.sqrt(2.0 * target.area / TARGET_SAMPLES))
    left = distances(build_bvh(np.ascontiguousarray(points[sheet.triangles])), samples)
    sample = int(np.argmax(left))
    board = (float(sheet.flat[vertex, 0]), float(sheet.flat[vertex, 1]))
    return (
        Furthest(_triple(points[vertex]), board, float(away[vertex])),
        Furthest(_triple(samples[sample]), None, float(left[sample])),
    )


def _triple(point: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(t) for t in point)
    return x, y, z


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
