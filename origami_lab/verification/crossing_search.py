"""No panel crosses another: every pair is excluded over every interval of the motion, or named.

An interval between two states of the motion is halved, for the pairs that are left, until a plane parts them all over
it (:meth:`Neighbourhood.parted`), two panels are seen to cross, or it is ``FLOOR`` wide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from origami_lab.verification.continuation import Motion, between
from origami_lab.verification.linkage import State
from origami_lab.verification.panel_pairs import SAFETY, Neighbourhood, Pairs
from origami_lab.verification.plane_graph import Array
from origami_lab.verification.triangle_separation import TOUCH, overlap_in_plane

FLOOR = 2e-6
"""Radians of driving angle: the width of an interval that is not halved again."""
_EXACT = 1e-6
"""Radians to which the angle of a crossing is found."""
_OVER = np.pi + 1e-6
"""Radians: a crease that folds further has passed ±180°, beyond rounding."""
UNSMOOTH = 0.02
"""Radians: what a cubic misses between two states of a smooth motion is far less."""


@dataclass(frozen=True)
class Meeting:
    """Two panels and the driving angle (radians) at which something is the matter with them."""

    panels: tuple[int, int]
    angle: float
    how: str


@dataclass(frozen=True)
class Gap:
    """An interval of driving angles (radians) that could not be certified."""

    low: float
    high: float
    why: str


@dataclass
class Findings:
    """What a sweep found."""

    crossing: Meeting | None = None
    gaps: list[Gap] = field(default_factory=list)
    contacts: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    """Panels that touch over an interval, first and last driving angle at which they do."""
    clearance: float = float("inf")
    closest: Meeting | None = None
    intervals: int = 0
    states: int = 0
    residual: float = 0.0
    thin: Meeting | None = None
    """Panels that are closer than the thickness."""


class Sweep:
    """A walk along the motion, interval by interval."""

    def __init__(self, motion: Motion, near: Neighbourhood, thickness: float, most_states: int) -> None:
        self.motion, self.near, self.thickness, self.most_states = motion, near, thickness, most_states
        self.touch = TOUCH * near.sheet.size
        self.look = max(near.sheet.size / 10.0, 1.01 * thickness)
        self.found = Findings()

    def state(self, driving: float, guess: Array) -> State | None:
        """A state of the motion, counted."""
        self.found.states += 1
        state = self.motion.solve(driving, guess)
        if state is not None:
            self.found.residual = max(self.found.residual, state.residual)
        return state

    def interval(self, a: State, b: State, pairs: tuple[Pairs, Pairs] | None = None) -> None:
        """Exclude crossings between two states (a.driving < b.driving); ``pairs`` None: all."""
        found = self.found
        if found.crossing is not None or found.states > self.most_states:
            if found.crossing is None:
                self.give_up(a, b, "it takes too many states")
            return
        found.intervals += 1
        m = self.state((a.driving + b.driving) / 2.0, between(a, b, 0.5))
        width = b.driving - a.driving
        if m is None or np.abs(m.rho - between(a, b, 0.5)).max(initial=0.0) > UNSMOOTH:
            if m is None or width <= FLOOR:
                self.give_up(a, b, "the solver finds no smooth motion there")
                return
            self.interval(a, m, pairs)
            self.interval(m, b, pairs)
            return
        over = next((s for s in (m, b) if (np.abs(s.rho) > _OVER).any()), None)
        if over is not None:
            before, meeting = self.past_flat(a, over)
            if before.driving > a.driving:
                self.interval(a, before, pairs)
            found.crossing = found.crossing or meeting
            return
        bulge = np.maximum(np.abs(a.rho + width / 3.0 * a.speed), np.abs(b.rho - width / 3.0 * b.speed))
        if (bulge > _OVER).any() and width > FLOOR:  # a fold angle may pass ±180° and come back
            self.interval(a, m, pairs)
            self.interval(m, b, pairs)
            return
        if pairs is None:
            pairs = (self.near.neighbours, self.close_pairs(a, m, b))
        left = tuple(self.unresolved(some, a, m, b) for some in pairs)
        if not any(len(some) for some in left) or found.crossing is not None:
            return
        for before, state in ((a, a), (a, m), (m, b)):
            if self.depth(left, state)[0] > self.touch:
                self.cross(left, before, state)
                return
        if width <= FLOOR:
            self.at_the_floor(left, a, b)
            return
        self.interval(a, m, (left[0], left[1]))
        self.interval(m, b, (left[0], left[1]))

    def close_pairs(self, a: State, m: State, b: State) -> Pairs:
        """Pairs without a common vertex that come near each other somewhere in the interval."""
        h = b.driving - a.driving
        x0, x1, v0, v1 = *(self.near.corners(s) for s in (a, b)), *(self.near.velocities(s) for s in (a, b))
        missed = np.abs((x0 + x1) / 2.0 + h / 8.0 * (v0 - v1) - self.near.corners(m)).max(axis=(1, 2))
        controls = np.concatenate([x0, x0 + h / 3.0 * v0, x1 - h / 3.0 * v1, x1], axis=1)
        around = (2.0 * SAFETY * missed + self.touch + self.look / 2.0)[:, None]
        return self.near.close(controls.min(axis=1) - around, controls.max(axis=1) + around)

    def measure(self, pairs: Pairs, apart: Array, states: tuple[State, ...]) -> None:
        """Keep the least distance of panels without a common vertex."""
        at, k = (int(i) for i in np.unravel_index(np.argmin(apart), apart.shape))
        distance, panels = float(apart[at, k]), _panels(pairs, at)
        if distance < self.found.clearance:
            self.found.clearance = distance
            self.found.closest = Meeting(panels, states[k].driving, "closest")
            self.look = min(self.look, max(distance, 1.01 * self.thickness, 1e-3 * self.near.sheet.size))
        if distance < self.thickness and self.found.thin is None:
            self.found.thin = Meeting(panels, states[k].driving, f"{distance:.6g} apart")

    def unresolved(self, pairs: Pairs, a: State, m: State, b: State) -> Pairs:
        """The pairs that no plane parts over the interval; those that touch all along are noted."""
        if not len(pairs):
            return pairs
        gap, apart = self.near.parted(pairs, a, m, b)
        if not pairs.hinged:
            self.measure(pairs, apart, (a, m, b))
        # once panels are too close for the thickness, only crossings are left to find
        wanted = 0.0 if pairs.hinged or self.found.thin else self.thickness
        resolved = gap > wanted
        touch = TOUCH if pairs.hinged else self.touch
        # they touch, and are not only near each other: of those halving will tell
        touching = ~resolved & (apart.min(axis=1) <= touch)
        if touching.any():
            slides = self.near.sliding(pairs.take(touching), a, m, b) >= -self.touch
            touching[touching] = slides | (gap[touching] >= -touch)
        touching &= wanted == 0.0
        for at in np.flatnonzero(touching):
            self.contact(pairs.take(np.array([at])), a, b)
        return pairs.take(~resolved & ~touching)

    def contact(self, pair: Pairs, a: State, b: State) -> None:
        """Note that two panels touch; sliding into each other in one plane is more than that."""
        panels, tolerance = _panels(pair, 0), 10.0 * self.touch
        p = self.near.first(pair)

        def overlaps(state: State) -> bool:
            return bool(overlap_in_plane(p, self.near.second(pair, state)[0], tolerance)[0])

        level = np.abs(self.near.second(pair, a)[0][..., 2]).max() <= tolerance
        if level and overlaps(b) and not overlaps(a):
            where = self.narrow(a, b, overlaps)[1].driving
            self.found.crossing = Meeting(panels, where, "slide into each other in one plane")
            return
        first, last = self.found.contacts.get(panels, (a.driving, b.driving))
        self.found.contacts[panels] = (min(first, a.driving), max(last, b.driving))

    def narrow(self, before: State, after: State, holds: Callable[[State], bool]) -> tuple[State, State]:
        """Two states next to each other of which only the second one has a property, as the last of those given has."""
        while after.driving - before.driving > _EXACT:
            m = self.state((before.driving + after.driving) / 2.0, between(before, after, 0.5))
            if m is None:
                break
            before, after = (before, m) if holds(m) else (m, after)
        return before, after

    def depth(self, pairs: tuple[Pairs, ...], state: State) -> tuple[float, tuple[int, int]]:
        """How far the panels that reach into each other most do so, and which they are."""
        depths = [self.near.depth(some, state) for some in pairs]
        return max((float(d.max()), _panels(p, int(d.argmax()))) for d, p in zip(depths, pairs, strict=True) if len(d))

    def cross(self, pairs: tuple[Pairs, ...], before: State, after: State) -> None:
        """Some panels cross at ``after``: find the angle at which the first of them begin to."""
        _, state = self.narrow(before, after, lambda m: self.depth(pairs, m)[0] > self.touch)
        self.found.crossing = Meeting(self.depth(pairs, state)[1], state.driving, "cross")

    def past_flat(self, a: State, b: State) -> tuple[State, Meeting]:
        """A crease that folds beyond ±180° takes its panels through each other: the last state before, and where."""
        a, b = self.narrow(a, b, lambda m: bool((np.abs(m.rho) > _OVER).any()))
        panels = self.near.sheet.beside[int(np.argmax(np.abs(b.rho)))]
        how = "pass through each other at their crease"
        return a, Meeting((int(panels.min()), int(panels.max())), b.driving, how)

    def at_the_floor(self, left: tuple[Pairs, ...], a: State, b: State) -> None:
        """Pairs that are still open in a tiny interval: through each other, or not certified."""
        for some in left:
            for at in range(len(some)):
                pair = some.take(np.array([at]))
                sides = [self.side(pair, s) for s in (a, b)]
                panels = _panels(pair, 0)
                if self.thickness > 0.0 and not some.hinged and self.found.thin is None:
                    self.give_up(a, b, f"panels {panels[0]} and {panels[1]} are about as far apart as they must be")
                    continue
                p, q = self.near.first(pair), self.near.second(pair, b)[0]
                if sides[0] * sides[1] < 0.0 and overlap_in_plane(p, q, 1e-5 * self.near.sheet.size)[0]:
                    self.found.crossing = Meeting(panels, b.driving, "pass through each other")
                    return
                self.give_up(a, b, f"panels {panels[0]} and {panels[1]} touch or nearly touch")

    def side(self, pair: Pairs, state: State) -> float:
        """On which side of the first triangle the second one lies, 0 if on both."""
        height = self.near.second(pair, state)[0][0, :, 2]
        low, high = height.min(), height.max()
        return 0.0 if low < -self.touch and high > self.touch else float(np.sign(low + high))

    def give_up(self, a: State, b: State, why: str) -> None:
        """Note an interval that is not certified, joined to the last one if that says the same."""
        last = self.found.gaps[-1] if self.found.gaps else None
        if last is not None and last.why == why and abs(last.high - a.driving) < 1e-3:
            self.found.gaps[-1] = Gap(last.low, b.driving, why)
        else:
            self.found.gaps.append(Gap(a.driving, b.driving, why))


def _panels(pairs: Pairs, at: int) -> tuple[int, int]:
    p, q = (int(panel) for panel in pairs.panels[at])
    return min(p, q), max(p, q)
