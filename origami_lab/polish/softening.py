"""Descending the energy of a design, one variable at a time: a rough way to somewhere better, past every edge.

A (1+1) evolution strategy with a step size for each variable: a variable is drawn, moved by a normal number of its
step size, and the design is laid again. Most candidates are told by their energy alone, so panels are tested against
each other only where the energy falls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import kernel
from origami_lab.polish.energy import measure
from origami_lab.polish.lay_kernel import equal_steps, lay_design
from origami_lab.polish.tools import Placement, Tools, copy_place, move

FIRST_SIZE, LARGEST_SIZE, SMALLEST_PARTS = 0.3, 2.0, 0.6
"""Standard deviation of a step: at first and at most, in cells, and at least, in parts of a cell."""
GROWTH, DECAY = 1.5, 0.93
"""What a step size is multiplied by after a success and after a failure."""

Array = NDArray[np.float64]


@kernel
def soften(
    tools: Tools, current: Placement, trial: Placement, sizes: Array, draws: Array, scale: float, sharpness: float
) -> int:
    """Take a step for each row of draws; returns how many lowered the energy.

    Parameters
    ----------
    current, trial
        The design that is moved, legal and free of collisions, and room for a candidate.
    sizes
        (N,) standard deviation of each variable's steps, in cells.
    draws
        (n, 3) a uniform number and two normal ones for each step.
    scale, sharpness
        Of the energy, see :mod:`origami_lab.polish.energy`.
    """
    accepted, energy = 0, np.inf
    count = tools.variables.members.shape[0]
    steps = np.zeros((count, 2))
    least = SMALLEST_PARTS * tools.stick.cell
    states, rules, layout, notes = tools.states, tools.rules, tools.layout, tools.notes
    for row in range(-1, draws.shape[0]):  # the first design is the one to begin with
        j, moved = -1, 1
        copy_place(trial, current)
        if row >= 0:
            j = min(int(draws[row, 0] * count), count - 1)
            steps[j, 0], steps[j, 1] = sizes[j] * draws[row, 1], sizes[j] * draws[row, 2]
            moved = move(tools, trial, steps)
            steps[j, 0], steps[j, 1] = 0.0, 0.0
        if moved == 0:
            continue
        found = np.inf
        angles = equal_steps(trial.angle[0])
        if moved > 0 and lay_design(states, rules, False, layout, trial.points, notes, angles):
            _, found = measure(states, rules, tools.stick, scale, sharpness, energy, tools.nearest)
        if found <= energy and found < np.inf:
            if row < 0:
                energy = found
                continue
            if lay_design(states, rules, True, layout, trial.points, notes, angles):
                accepted += 1
                energy = found
                copy_place(current, trial)
                sizes[j] = min(sizes[j] * GROWTH, LARGEST_SIZE)
                continue
        if row >= 0:
            sizes[j] = max(sizes[j] * DECAY, least)
    return accepted
