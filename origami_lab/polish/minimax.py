"""Descending the largest distance itself: a linear programme within a trust region, again and again.

The largest distance is a maximum of many smooth ones, most often of as many as there are variables at a best design,
so it has an edge wherever it is good, and steps along single variables get stuck on it. Here every distance d is
taken as linear in the variables, by differences of laid designs, and the programme

    minimise t + q   subject to   d + ∇d·δ ≤ t,   p + ∇p·δ ≤ q,   −Δ ≤ δ ≤ Δ

gives the step δ, p being the compactness penalties of the vertices. A step that is not legal, does not fold or makes
panels cross is asked for again without the variables that do it by themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from origami_lab.jit import kernel
from origami_lab.polish.energy import distances_of
from origami_lab.polish.lay_kernel import equal_steps, lay_design
from origami_lab.polish.tools import Array, Placement, Steps, Tools, copy_place, distances_at, lay, move

FIRST_TRUST, LARGEST_TRUST = 0.1, 0.5
"""Δ at first and at most, in cells."""
DIFFERENCE = 0.01
"""Length of the steps that derivatives are taken by, in cells: at most this, nor more than half of Δ."""
SMALLEST_PARTS = 1 / 16
"""Δ at the end, in parts of a cell: vertices have long stopped moving then, the driving angle has not."""
ENOUGH = 1e-5
"""Cells: a programme that promises less is the end of a descent."""
BAND = 0.5
"""Share of the largest distance from which distances take part."""


@kernel
def slopes(
    tools: Tools,
    place: Placement,
    trial: Placement,
    length: float,
    floor: float,
    base: Array,
    base_p: Array,
    out: Array,
    out_p: Array,
) -> NDArray[np.bool_]:
    """Write the (2N, ...) derivatives of the distances and penalties; returns which of them exist, (2N,).

    Row 2j is variable j along its first direction, 2j + 1 along the second one. They are taken by steps of ``length``
    cells, or the whole parts nearest to it.
    """
    count = tools.variables.members.shape[0]
    known = np.zeros(2 * count, np.bool_)
    steps = np.zeros((count, 2))
    parts = max(1.0, np.rint(length / tools.stick.cell)) * tools.stick.cell
    for j in range(count):
        size = parts if tools.variables.members[j, 0] >= 0 else length
        for c in range(2 if tools.variables.free[j] else 1):
            for sign in (1.0, -1.0):
                copy_place(trial, place)
                steps[j, c] = sign * size
                fits = move(tools, trial, steps) > 0
                steps[j, c] = 0.0
                angles = equal_steps(trial.angle[0])
                if fits and lay_design(
                    tools.states, tools.rules, False, tools.layout, trial.points, tools.notes, angles
                ):
                    distances_of(
                        tools.states, tools.rules, tools.stick, floor, tools.nearest, out[2 * j + c], out_p[2 * j + c]
                    )
                    for i in range(base.shape[0]):
                        out[2 * j + c, i] = (out[2 * j + c, i] - max(base[i], floor)) / (sign * size)
                    for i in range(base_p.shape[0]):
                        out_p[2 * j + c, i] = (out_p[2 * j + c, i] - base_p[i]) / (sign * size)
                    known[2 * j + c] = True
                    break
    return known


@kernel
def promised(values: Array, derivatives: Array, step: Array) -> Array:
    """(R,) what (R,) values become by a (n,) step of (R, n) derivatives; the same bits on every run, unlike BLAS."""
    out = np.empty(values.shape[0])
    for i in range(values.shape[0]):
        total = values[i]
        for j in range(step.shape[0]):
            total += derivatives[i, j] * step[j]
        out[i] = total
    return out


@dataclass(eq=False)
class Minimax:
    """Trust-region descents of one design after another, with the same tools.

    Parameters
    ----------
    tools
        Those of the fine board.
    spend
        Told how many designs are about to be laid; says whether to go on.
    """

    tools: Tools
    spend: Callable[[int], bool]

    def descend(self, place: Placement) -> float:
        """Move a design to where the programme promises no more; returns its distance.

        The design has to be legal, and is at every step.
        """
        tools = self.tools
        rows, vertices = self._rows, self._penalties
        count = len(tools.variables.members)
        base, base_p = np.empty(rows), np.empty(vertices)
        slope, slope_p = np.empty((2 * count, rows)), np.empty((2 * count, vertices))
        trial = Placement(place.points.copy(), place.angle.copy())
        found, found_p = np.empty(rows), np.empty(vertices)
        trust, smallest = FIRST_TRUST, SMALLEST_PARTS * tools.stick.cell
        if not distances_at(tools, place, 0.0, base, base_p):
            return math.inf
        value = float(base.max() + base_p.max(initial=0.0))
        while trust > smallest:
            floor = BAND * float(base.max())
            if not self.spend(2 * count):
                return value
            length = min(DIFFERENCE, 0.5 * trust)
            known = slopes(tools, place, trial, length, floor, base, base_p, slope, slope_p)
            slope[~known], slope_p[~known] = 0.0, 0.0
            free = np.where(known, 1.0, 0.0)
            low, high, whole = -free, free.copy(), True
            moved = False
            while trust > smallest and not moved:
                steps, promise = self._programme(base, slope, base_p, slope_p, trust * low, trust * high)
                if whole and promise < ENOUGH:
                    return value
                fits = False
                if promise >= ENOUGH:
                    if not self.spend(1):
                        return value
                    copy_place(trial, place)
                    fits = move(tools, trial, steps) > 0 and distances_at(tools, trial, floor, found, found_p)
                if fits:
                    gain = value - float(found.max() + found_p.max(initial=0.0))
                    if gain > 0.75 * promise:
                        trust = min(2.0 * trust, LARGEST_TRUST)
                    elif gain < 0.25 * promise:
                        trust *= 0.5
                    if gain > 0.0:
                        copy_place(place, trial)
                        base[:], base_p[:] = found, found_p
                        value -= gain
                        moved = True
                elif whole and self._hold(place, trial, steps, low, high):
                    whole = False
                else:
                    trust *= 0.5
                    low, high, whole = -free, free.copy(), True
            if not moved:
                return value
        return value

    @property
    def _rows(self) -> int:
        parts = self.tools.stick.parts
        points = int(((parts + 1) * (parts + 2) // 2 - 3).sum())
        return len(self.tools.layout.axis) + points + len(self.tools.stick.samples)

    @property
    def _penalties(self) -> int:
        return len(self.tools.layout.axis) if self.tools.stick.target.compactness > 0.0 else 0

    def _hold(self, place: Placement, trial: Placement, steps: Steps, low: Array, high: Array) -> bool:
        """Forbid the variables that spoil the step by themselves to go that way; returns whether there are any."""
        tools, held = self.tools, False
        alone = np.zeros_like(steps)
        for j, c in np.argwhere(steps != 0.0):
            if not self.spend(1):
                return False
            alone[:] = 0.0
            alone[j, c] = steps[j, c]
            copy_place(trial, place)
            if not (move(tools, trial, alone) > 0 and lay(tools, trial, True)):
                (high if steps[j, c] > 0 else low)[2 * j + c] = 0.0
                held = True
        return held

    def _programme(
        self, base: Array, slope: Array, base_p: Array, slope_p: Array, low: Array, high: Array
    ) -> tuple[Steps, float]:
        """The (N, 2) steps that the linear programme gives, in cells, and how much it promises."""
        used = np.flatnonzero(high > low)
        if not len(used):
            return np.zeros((len(low) // 2, 2)), 0.0
        parts = [(base, np.ascontiguousarray(slope[used].T), 0)]
        if len(base_p):
            parts.append((base_p, np.ascontiguousarray(slope_p[used].T), 1))
        # few rows decide: the programme begins with the largest, and gets what its step would make larger
        rows = [np.argsort(value)[-4 * len(used) :] for value, _, _ in parts]
        cost = np.concatenate([np.zeros(len(used)), np.ones(len(parts))])
        bounds = [*zip(low[used], high[used], strict=True), *[(0.0, None)] * len(parts)]
        while True:
            matrix, right = [], []
            for (value, derivative, column), kept in zip(parts, rows, strict=True):
                limits = np.zeros((len(kept), len(parts)))
                limits[:, column] = -1.0
                matrix.append(np.hstack([derivative[kept], limits]))
                right.append(-value[kept])
            solved = linprog(cost, np.vstack(matrix), np.concatenate(right), bounds=bounds, method="highs")
            if solved.status != 0:
                return np.zeros((len(low) // 2, 2)), 0.0
            step, tops = solved.x[: len(used)], solved.x[len(used) :]
            whole = True
            for n, ((value, derivative, _), top) in enumerate(zip(parts, tops, strict=True)):
                left = promised(value, derivative, step) - top
                over = np.argsort(left)[-2 * len(used) :]
                over = np.setdiff1d(over[left[over] > 1e-9], rows[n])
                whole &= not len(over)
                rows[n] = np.concatenate([rows[n], over])
            if whole:
                break
        steps = np.zeros(len(low))
        steps[used] = step
        now = sum(float(value.max()) for value, _, _ in parts)
        return steps.reshape(-1, 2), now - float(solved.fun)
