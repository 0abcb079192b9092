"""What moves a design about on a fine board: its variables as numbers, a candidate, and what is asked of one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import States
from origami_lab.game.kernels.undo import Notes
from origami_lab.game.move_table import Points
from origami_lab.jit import inlined, kernel
from origami_lab.polish.energy import Yardstick, distances_of, measure
from origami_lab.polish.finer_board import ANGLES, STRICT, Layout
from origami_lab.polish.lay_kernel import equal_steps, lay_design, place_is_free
from origami_lab.polish.variables import Variables

ANGLE_FACTOR = 0.06
"""A step of one cell multiplies the driving angle by e to this power."""
SMALLEST_ANGLE = math.radians(0.1)
DENSE_STEPS = 100
"""Equal steps up to the driving angle at which a dense check lays a design."""

Array = NDArray[np.float64]
Steps = NDArray[np.float64]
"""(N, 2) a step of each variable, in cells; the second number is for vertices that move both ways."""


class Tools(NamedTuple):
    """What the kernels of a descent work with.

    Attributes
    ----------
    states
        One state, for the candidate.
    rules, layout, notes
        Those of the fine board.
    variables
        What may move.
    stick
        What designs are measured with.
    nearest
        (n,) the triangle of the sheet that each sample of the target was nearest to the last time; it changes no
        result.
    largest_angle
        That of the game, radians.
    """

    states: States
    rules: States
    layout: Layout
    notes: Notes
    variables: Variables
    stick: Yardstick
    nearest: NDArray[np.int64]
    largest_angle: float


class Placement(NamedTuple):
    """Where a design is: its vertices and its driving angle.

    Attributes
    ----------
    points
        (V, 2) int32, parts of a cell.
    angle
        (1,) radians.
    """

    points: Points
    angle: Array


@inlined
def copy_place(target: Placement, source: Placement) -> None:
    for v in range(source.points.shape[0]):
        target.points[v, 0], target.points[v, 1] = source.points[v, 0], source.points[v, 1]
    target.angle[0] = source.angle[0]


@kernel
def move(tools: Tools, place: Placement, steps: Steps) -> int:
    """Move a design, its vertices by whole parts of a cell.

    Returns 1, 0 if nothing moved, −1 if a vertex may not lie there or the driving angle leaves its limits.
    """
    variables, r, moved = tools.variables, tools.rules[STRICT], 0
    for j in range(variables.members.shape[0]):
        if steps[j, 0] == 0.0 and steps[j, 1] == 0.0:
            continue
        if variables.members[j, 0] < 0:
            place.angle[0] *= np.exp(ANGLE_FACTOR * steps[j, 0])
            moved = 1
            continue
        du = int(np.rint(steps[j, 0] / tools.stick.cell))
        dv = int(np.rint(steps[j, 1] / tools.stick.cell)) if variables.free[j] else du
        if du == 0 and dv == 0:
            continue
        moved = 1
        for member in range(variables.members.shape[1]):
            v = variables.members[j, member]
            if v >= 0:
                place.points[v, 0] += variables.directions[j, member, 0] * du
                place.points[v, 1] += variables.directions[j, member, 1] * dv
    if not SMALLEST_ANGLE <= place.angle[0] <= tools.largest_angle:
        return -1
    for v in range(place.points.shape[0]):
        if not place_is_free(r, place.points[v, 0], place.points[v, 1], tools.layout.axis[v]):
            return -1
    return moved


def lay(tools: Tools, place: Placement, strict: bool) -> bool:
    """Lay a design; returns whether it is legal and folds, and, if ``strict``, without collisions."""
    steps = equal_steps(float(place.angle[0]))
    return bool(lay_design(tools.states, tools.rules, strict, tools.layout, place.points, tools.notes, steps))


def distances_at(tools: Tools, place: Placement, floor: float, out: Array, penalties: Array) -> bool:
    """Lay a design and write its distances, see :func:`~origami_lab.polish.energy.distances_of`.

    Returns whether it is legal and folds without collisions; if not, nothing is written.
    """
    if not lay(tools, place, True):
        return False
    distances_of(tools.states, tools.rules, tools.stick, floor, tools.nearest, out, penalties)
    return True


def checked_distance(tools: Tools, place: Placement) -> tuple[bool, float]:
    """Whether a design folds without collisions, checked densely over its motion, and its largest distance."""
    if not lay(tools, place, True):
        return False, math.inf
    distance, _ = measure(tools.states, tools.rules, tools.stick, 0.0, 0.0, math.inf, tools.nearest)
    fine = place.angle[0] * np.arange(1, DENSE_STEPS + 1) / DENSE_STEPS
    for start in range(0, DENSE_STEPS, ANGLES):
        steps = fine[start : start + ANGLES]
        if not lay_design(tools.states, tools.rules, True, tools.layout, place.points, tools.notes, steps):
            return False, float(distance)
    return True, float(distance)
