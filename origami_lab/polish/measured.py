"""The returns of a design on a fine board, by the rulers that designs of the game are measured with."""

from __future__ import annotations

import numpy as np

from origami_lab.game.kernels.state import States
from origami_lab.objectives.shape import ShapeEvaluator, ShapeObjective
from origami_lab.polish.finer_board import ANGLES, FineBoard
from origami_lab.polish.laid_design import laid_in_cells


def own_return(board: FineBoard, angle: float, objective: ShapeObjective, evaluator: ShapeEvaluator) -> float:
    """The return of a design at a driving angle in radians, as its objective has it, compactness included."""
    return return_at(laid_in_cells(board, angle), ANGLES - 1, objective, evaluator)


def return_at(states: States, k: int, objective: ShapeObjective, evaluator: ShapeEvaluator) -> float:
    """The return of the first position, laid in cells, at driving angle k."""
    distance = evaluator.measure(states, 0, k, objective.distance)
    positions = states["position"][0][: int(states["n_vertices"][0]), k]
    return -distance - objective.compactness * float(np.linalg.norm(positions, axis=1).max())


def all_returns(
    board: FineBoard, angle: float, objective: ShapeObjective, evaluator: ShapeEvaluator
) -> dict[str, float]:
    """``return`` as the objective has it, and the other figures that are reported of a design."""
    figures = evaluator.figures(laid_in_cells(board, angle), 0, ANGLES - 1)
    return {"return": own_return(board, angle, objective, evaluator), **figures}
