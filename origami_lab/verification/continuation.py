"""The folding motion from a solver of its own: Newton continuation on the closure of all loops.

The driven creases turn by ± the driving angle, creases that are flat in every state of the file are held flat, and the
others are found so that every loop closes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.plane_graph import Array

CLOSED = 1e-9
"""Radians: a loop that fails to close by less is closed (what rounding leaves is 1e-14)."""
LARGEST_TURN = 0.12
"""Radians that a crease may turn between two neighbouring states of the walk."""
SMOOTH, SMOOTHER = 1e-3, 1e-5
"""Radians: how well speeds explain a step, and how well where that led elsewhere than the file."""
SMALLEST_STEP = 1e-7
"""Radians of driving angle: a walk that needs smaller steps has reached a dead point."""


class StuckError(Exception):
    """The solver found no state near the last one."""

    def __init__(self, states: list[State], singular: float) -> None:
        super().__init__(states[-1].driving)
        self.states, self.singular = states, singular


@dataclass(frozen=True, eq=False)
class Motion:
    """A linkage whose driven creases are tied to one driving angle."""

    linkage: Linkage
    held: NDArray[np.bool_]
    """(E,) edges that do not fold."""
    drive: Array
    """(E,) ±1 for driven creases, 0 for others."""

    @cached_property
    def free(self) -> NDArray[np.int64]:
        """Numbers of the creases that the solver finds."""
        return np.flatnonzero(self.linkage.sheet.inner & ~self.held & (self.drive == 0.0))

    def solve(self, driving: float, guess: Array) -> State | None:
        """The state at a driving angle near a guess (E,), or None where Newton's method does not get there."""
        free = self.free
        rho = np.where(self.drive != 0.0, self.drive * driving, np.where(self.held, 0.0, guess))
        closure = self.linkage.closure(rho)
        for _ in range(12):
            if not len(free) or not len(closure.error):
                break
            step = closure.solve(free, -closure.error)
            largest = float(np.abs(step).max(initial=0.0))
            if not largest < 0.5:
                return None
            rho[free] += step
            closure = self.linkage.closure(rho)
            if largest < 1e-9:
                break
        residual = float(closure.angle.max(initial=0.0))
        if not residual <= CLOSED:
            return None
        speed = self.drive.copy()
        if len(free) and len(closure.error):
            speed[free] = closure.solve(free, -closure.change(self.drive))
        return self.linkage.place(driving, rho, speed, residual)

    def walk(self, start: State, stop: float, most: int, smooth: float = SMOOTH) -> list[State]:
        """States from ``start`` to the driving angle ``stop``, close enough for a smooth curve through them.

        A step is taken back if the change of a fold angle differs by more than ``smooth`` from what its speeds at both
        ends say: near a branch point Newton's method may come out on another branch, where the speeds are others.
        Raises :class:`StuckError` where no further state is found, or after ``most`` of them.
        """
        states = [start]
        direction = 1.0 if stop > start.driving else -1.0
        step = 0.1
        while (stop - states[-1].driving) * direction > 1e-12:
            here = states[-1]
            step = min(step, 0.1, LARGEST_TURN / float(np.abs(here.speed).max(initial=1e-3)))
            while True:
                if step < SMALLEST_STEP or len(states) > most:
                    raise StuckError(states, self.conditioning(here)[0])
                left = abs(stop - here.driving)
                h = direction * (left if left < 1.01 * step else min(step, left / 2.0 if left < 2.0 * step else step))
                guess = here.rho + h * here.speed
                found = self.solve(stop if abs(h) == left else here.driving + h, guess)
                if found is not None:
                    mean = here.rho + h * (here.speed + found.speed) / 2.0
                    if np.abs(found.rho - mean).max(initial=0.0) <= smooth:
                        break
                step = abs(h) / 2.0
            states.append(found)
            step = 1.5 * abs(h)
        return states

    def conditioning(self, state: State) -> tuple[float, float]:
        """The smallest singular value of the closure Jacobian in the free creases, and the sign of its determinant.

        The sign is 0 where there are more equations than unknowns.
        """
        closure, free = self.linkage.closure(state.rho), self.free
        square = 0 < len(free) == closure.error.size
        sign = float(np.linalg.slogdet(closure.jacobian(free))[0]) if square else 0.0
        return closure.smallest(free), sign


def between(a: State, b: State, t: float) -> Array:
    """(E,) the cubic through two neighbouring states with their speeds, at the fraction ``t``."""
    h = b.driving - a.driving
    return np.asarray(
        a.rho + t * t * (3.0 - 2.0 * t) * (b.rho - a.rho) + h * t * (1.0 - t) * ((1.0 - t) * a.speed - t * b.speed)
    )
