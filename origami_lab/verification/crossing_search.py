"""No panel crosses another: every pair is excluded over every interval of the motion, or named.

An interval between two states of the motion is halved, for the pairs that are left, until a plane parts them all over
it (:meth:`IntervalPlanes.parted`), two panels are seen to cross, or it is ``FLOOR`` wide.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from origami_lab.verification.continuation import Motion, between
from origami_lab.verification.findings import Findings, Gap, Meeting
from origami_lab.verification.interval_planes import SAFETY, IntervalPlanes
from origami_lab.verification.linkage import State
from origami_lab.verification.panel_pairs import Neighbourhood, Pairs
from origami_lab.verification.plane_graph import Array, Indices
from origami_lab.verification.triangle_separation import TOUCH, overlap_in_plane

FLOOR = 2e-6
"""Radians of driving angle: the width of an interval that is not halved again."""
_EXACT = 1e-6
"""Radians to which the angle of a crossing is found."""
_OVER = np.pi + 1e-6
"""Radians: a crease that folds further has passed ±180°, beyond rounding."""
UNSMOOTH = 0.02
"""Radians: what a cubic misses between two states of a smooth motion is far less."""
MOST_LOOKS = 1_000_000
"""Pairs of triangles over intervals that are looked at; real designs stay below a fiftieth of it."""
_SHALLOW = 1e-5
"""Of the sheet's size: deeper crossings are no matter of how exact a state is."""
_MOVING = 0.01
"""Radians: over shorter intervals panels that are close to each other are tried to part with a plane that moves."""
_COARSE = 0.01
"""Radians: over shorter intervals panels that are within a file's rounding of each other are not looked at again."""


class Sweep:
    """A walk along the motion, interval by interval.

    ``thickness`` and ``margin`` are lengths: what panels without a common vertex must keep apart, and how near to each
    other they must not come because the file rounds; ``angle_margin`` is the same for fold angles, in radians.
    """

    def __init__(
        self,
        motion: Motion,
        near: Neighbourhood,
        thickness: float,
        most_states: int,
        margin: float = 0.0,
        angle_margin: float = 0.0,
    ) -> None:
        self.motion, self.near, self.thickness, self.most_states = motion, near, thickness, most_states
        self.margin, self.angle_margin = margin, angle_margin
        self.look = max(near.sheet.size / 10.0, 1.01 * thickness, 1.01 * margin)
        self.found = Findings()
        self.planes = IntervalPlanes(near)

    def state(self, driving: float, guess: Array) -> State | None:
        """A state of the motion, counted."""
        self.found.states += 1
        state = self.motion.solve(driving, guess)
        if state is not None:
            self.found.residual = max(self.found.residual, state.residual)
        return state

    def middle(self, a: State, b: State) -> State | None:
        """The state in the middle of an interval, on the branch of its ends.

        Where a crease comes close to ±180° another branch runs beside it, its mirror image behind 180°, and Newton's
        method may come out on that one.
        """
        expected = between(a, b, 0.5)
        m = self.state((a.driving + b.driving) / 2.0, expected)
        if m is None or not (over := np.abs(m.rho) > np.pi).any():
            return m
        other = self.state(m.driving, np.where(over, np.copysign(2.0 * np.pi, m.rho) - m.rho, m.rho))
        if other is None:
            return m
        return min((m, other), key=lambda state: float(np.abs(state.rho - expected).max(initial=0.0)))

    def interval(self, a: State, b: State, pairs: tuple[Pairs, Pairs] | None = None) -> None:
        """Exclude crossings between two states (a.driving < b.driving); ``pairs`` None: all."""
        found = self.found
        if found.crossing is not None:
            return
        if found.states > self.most_states or found.looks > MOST_LOOKS:
            self.give_up(a, b, "it takes too many states")
            return
        found.intervals += 1
        m = self.middle(a, b)
        width = b.driving - a.driving
        if m is None or np.abs(m.rho - between(a, b, 0.5)).max(initial=0.0) > UNSMOOTH:
            if m is None or width <= FLOOR:
                self.give_up(a, b, "the solver finds no smooth motion there")
                return
            self.interval(a, m, pairs)
            self.interval(m, b, pairs)
            return
        over = next((s for s in (m, b) if (np.abs(s.rho) > _OVER + self.angle_margin).any()), None)
        if over is not None:
            self.past_flat(a, over, b, pairs)
            return
        bulge = np.maximum(np.abs(a.rho + width / 3.0 * a.speed), np.abs(b.rho - width / 3.0 * b.speed))
        if (bulge > _OVER + self.angle_margin).any() and width > FLOOR:  # a fold angle may pass ±180° and come back
            self.interval(a, m, pairs)
            self.interval(m, b, pairs)
            return
        if self.angle_margin and found.unsure is None and (bulge > np.pi - self.angle_margin).any():
            e = int(np.argmax(bulge))
            found.unsure = Meeting(_sorted(self.near.sheet.beside[e]), b.driving, "fold nearly flat")
        if pairs is None:
            pairs = (self.near.neighbours, self.close_pairs(a, m, b))
        plain, hinged = self.unresolved(pairs[0], a, m, b), self.unresolved(pairs[1], a, m, b)
        left = (plain[0], hinged[0])
        slides = [slide for slide in (plain[1], hinged[1]) if slide is not None]
        if slides:
            before, meeting = min(slides, key=lambda slide: slide[1].angle)
            self.earliest(a, before, pairs, meeting)
            return
        if not any(len(some) for some in left):
            return
        for before, state in ((a, a), (a, m), (m, b)):
            if self.cross(left, a, before, state):
                return
        if self.margin and width <= _COARSE:
            left = (self.clear(left[0], m), self.clear(left[1], m))
        if width <= FLOOR:
            self.at_the_floor(left, a, b)
            return
        if any(len(some) for some in left):
            self.interval(a, m, left)
            self.interval(m, b, left)

    def earliest(self, a: State, before: State, pairs: tuple[Pairs, Pairs] | None, meeting: Meeting) -> None:
        """Panels meet next to ``before``: keep that, unless others do between ``a`` and there."""
        if before.driving > a.driving:
            self.interval(a, before, pairs)
        self.found.crossing = self.found.crossing or meeting

    def jump(self, a: State, b: State, where: float) -> None:
        """Exclude crossings between two states beside a branch point at which the motion changes its branch.

        The solver does not resolve the branch point itself; both states are carried on to it with their speeds.
        """
        place = self.motion.linkage.place
        for state in (a, b):
            ends = [
                place(at, state.rho + (at - state.driving) * state.speed, state.speed, state.residual)
                for at in ((state.driving + where) / 2.0, where)
            ]
            first, last = (state, ends[1]) if state is a else (ends[1], state)
            if last.driving <= first.driving:
                continue
            self.found.intervals += 1
            for some in (self.near.neighbours, self.close_pairs(first, ends[0], last)):
                left, slide = self.unresolved(some, first, ends[0], last)
                if len(left) or slide is not None:
                    p, q = _panels(left, 0) if len(left) else slide[1].panels if slide is not None else (0, 0)
                    self.give_up(a, b, f"panels {p} and {q} touch or nearly touch where the motion branches")
                    return

    def close_pairs(self, a: State, m: State, b: State) -> Pairs:
        """Pairs without a common vertex that come near each other somewhere in the interval."""
        h = b.driving - a.driving
        x0, x1, v0, v1 = *(self.near.corners(s) for s in (a, b)), *(self.near.velocities(s) for s in (a, b))
        missed = np.abs((x0 + x1) / 2.0 + h / 8.0 * (v0 - v1) - self.near.corners(m)).max(axis=(1, 2))
        controls = np.concatenate([x0, x0 + h / 3.0 * v0, x1 - h / 3.0 * v1, x1], axis=1)
        around = (2.0 * SAFETY * missed + TOUCH * self.near.sheet.size + self.look / 2.0)[:, None]
        return self.near.close(controls.min(axis=1) - around, controls.max(axis=1) + around)

    def measure(self, pairs: Pairs, apart: Array, states: tuple[State, State, State]) -> None:
        """Keep the least distance of panels without a common vertex, and where it is first less than the thickness."""
        at, k = (int(i) for i in np.unravel_index(np.argmin(apart), apart.shape))
        distance, panels = float(apart[at, k]), _panels(pairs, at)
        if distance < self.found.clearance:
            self.found.clearance = distance
            self.found.closest = Meeting(panels, states[k].driving, "closest")
            self.look = min(self.look, max(distance, 1.01 * self.thickness, 1e-3 * self.near.sheet.size))
            self.look = max(self.look, 1.01 * self.margin)
        if distance < self.thickness and self.found.thin is None:
            _, state = self.narrow(states[0], states[k], lambda s: self.near.gap(pairs, s).min() < self.thickness)
            nearest = int(np.argmin(self.near.gap(pairs, state)))
            self.found.thin = Meeting(_panels(pairs, nearest), state.driving, f"{distance:.6g} apart")

    def unresolved(self, pairs: Pairs, a: State, m: State, b: State) -> tuple[Pairs, tuple[State, Meeting] | None]:
        """The pairs that no plane parts over the interval; those that touch all along are noted.

        Panels that slide into each other in one plane come second: the last state before, and where.
        """
        if not len(pairs):
            return pairs, None
        self.found.looks += len(pairs)
        gap, apart = self.planes.parted(pairs, a, m, b, self.enough(pairs))
        if not pairs.hinged:
            self.measure(pairs, apart, (a, m, b))
        closest = apart.min(axis=1)
        margin = self.margins(pairs)
        if self.margin and self.found.unsure is None and (closest <= margin).any():
            at = int(np.argmin(closest - margin))
            self.found.unsure = Meeting(_panels(pairs, at), m.driving, "come close to each other")
        # once panels are too close for the thickness, or for the file's rounding, only crossings are left to find
        thickness = 0.0 if pairs.hinged or self.found.thin else self.thickness
        wanted = np.maximum(thickness, np.zeros(len(pairs)) if self.found.unsure else margin)
        resolved = gap > wanted
        touch = self.near.touch(pairs)
        within = np.full(len(pairs), TOUCH) if pairs.hinged else touch
        # they touch, and are not only near each other: of those halving will tell
        touching = ~resolved & (closest <= within)
        if (rest := ~resolved & ~touching).any():  # seen from the other panel a plane may stand still
            resolved[rest] = self.planes.parted(pairs.take(rest).turned(), a, m, b, wanted[rest])[0] > wanted[rest]
        moving = ~resolved & (wanted == 0.0) & (touching | (b.driving - a.driving <= _MOVING))
        if moving.any():  # a plane that moves along with both
            slides = self.planes.sliding(pairs.take(moving), a, m, b) >= -touch[moving]
            slides |= touching[moving] & (gap[moving] >= -within[moving])
            touching[moving] &= slides
            resolved[moving] |= slides & ~touching[moving]
        touching &= wanted == 0.0
        slid = [self.contact(pairs.take(np.array([at])), a, b) for at in np.flatnonzero(touching)]
        first = min((slide for slide in slid if slide is not None), key=lambda slide: slide[1].angle, default=None)
        return pairs.take(~resolved & ~touching), first

    def enough(self, pairs: Pairs) -> Array:
        """(N,) a gap beyond which a pair is parted, and no matter of contact, thickness, clearance or rounding."""
        margin = self.margins(pairs)
        return margin if pairs.hinged else np.maximum(margin, max(self.thickness, self.found.clearance))

    def margins(self, pairs: Pairs) -> Array:
        """(N,) the margin as gaps are measured: lengths, or for pairs that share a vertex for unit sides."""
        if pairs.hinged and self.margin:
            return np.asarray(self.margin / self.near.shortest(pairs))
        return np.full(len(pairs), self.margin)

    def clear(self, pairs: Pairs, m: State) -> Pairs:
        """The pairs that are further apart than the file's rounding; of others nothing more can be said."""
        return pairs.take(self.near.gap(pairs, m) > self.margins(pairs)) if len(pairs) else pairs

    def contact(self, pair: Pairs, a: State, b: State) -> tuple[State, Meeting] | None:
        """Note that two panels touch; sliding into each other in one plane is more than that."""
        panels, tolerance = _panels(pair, 0), 10.0 * float(self.near.touch(pair)[0])
        p = self.near.first(pair)

        def overlaps(state: State) -> bool:
            return bool(overlap_in_plane(p, self.near.second(pair, state)[0], tolerance)[0])

        level = np.abs(self.near.second(pair, a)[0][..., 2]).max() <= tolerance
        if level and overlaps(b) and not overlaps(a):
            before, after = self.narrow(a, b, overlaps)
            return before, Meeting(panels, after.driving, "slide into each other in one plane")
        first, last = self.found.contacts.get(panels, (a.driving, b.driving))
        self.found.contacts[panels] = (min(first, a.driving), max(last, b.driving))
        return None

    def narrow(self, before: State, after: State, holds: Callable[[State], bool]) -> tuple[State, State]:
        """Two states next to each other of which only the second one has a property, as the last of those given has."""
        while after.driving - before.driving > _EXACT:
            m = self.middle(before, after)
            if m is None:
                break
            before, after = (before, m) if holds(m) else (m, after)
        return before, after

    def depth(self, pairs: tuple[Pairs, ...], state: State) -> tuple[float, tuple[int, int]]:
        """By how much the panels that do so most reach into each other beyond a contact, and which they are."""
        beyond = [
            self.near.depth(some, state) - np.maximum(self.near.touch(some), self.margin) for some in pairs if len(some)
        ]
        some = [pair for pair in pairs if len(pair)]
        return max((float(d.max()), _panels(p, int(d.argmax()))) for d, p in zip(beyond, some, strict=True))

    def cross(self, pairs: tuple[Pairs, Pairs], a: State, before: State, state: State) -> bool:
        """Whether some panels cross at ``state``; then the angle at which the first of them begin to is found."""
        deep = self.depth(pairs, state)[0]
        if deep <= 0.0 or (deep < _SHALLOW * self.near.sheet.size and deep <= self.uncertainty(state)):
            return False
        last, first = self.narrow(before, state, lambda m: self.depth(pairs, m)[0] > 0.0)
        self.earliest(a, last, pairs, Meeting(self.depth(pairs, first)[1], first.driving, "cross"))
        return True

    def uncertainty(self, state: State) -> float:
        """How far panels may be from where they are at a state that is nearly singular, a length."""
        smallest = max(self.motion.conditioning(state)[0], 1e-12)
        return 10.0 * self.near.sheet.size * max(state.residual, 1e-15) / smallest

    def past_flat(self, a: State, over: State, b: State, pairs: tuple[Pairs, Pairs] | None) -> None:
        """A crease that folds beyond ±180° takes its panels through each other, unless the solver has changed branches.

        On one branch it goes on folding the same way.
        """
        limit = _OVER + self.angle_margin
        before, after = self.narrow(a, over, lambda m: bool((np.abs(m.rho) > limit).any()))
        e = int(np.argmax(np.abs(after.rho)))
        panels = _sorted(self.near.sheet.beside[e])
        if before.speed[e] * after.rho[e] > 0.0 and after.speed[e] * after.rho[e] > 0.0:
            meeting = Meeting(panels, after.driving, "pass through each other at their crease")
            self.earliest(a, before, pairs, meeting)
            return
        if before.driving > a.driving:
            self.interval(a, before, pairs)
        self.give_up(before, b, f"the crease between panels {panels[0]} and {panels[1]} comes to ±180°")

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
                through = overlap_in_plane(p, q, 1e-5 * float(self.near.diameters[list(panels)].min()))[0]
                if sides[0] * sides[1] < 0.0 and through:
                    self.found.crossing = Meeting(panels, b.driving, "pass through each other")
                    return
                self.give_up(a, b, f"panels {panels[0]} and {panels[1]} touch or nearly touch")

    def side(self, pair: Pairs, state: State) -> float:
        """On which side of the first triangle the second one lies, 0 if on both."""
        height = self.near.second(pair, state)[0][0, :, 2]
        low, high, touch = height.min(), height.max(), float(self.near.touch(pair)[0])
        return 0.0 if low < -touch and high > touch else float(np.sign(low + high))

    def give_up(self, a: State, b: State, why: str) -> None:
        """Note an interval that is not certified, joined to the last one if that says the same."""
        last = self.found.gaps[-1] if self.found.gaps else None
        if last is not None and last.why == why and abs(last.high - a.driving) < 1e-3:
            self.found.gaps[-1] = Gap(last.low, b.driving, why)
        else:
            self.found.gaps.append(Gap(a.driving, b.driving, why))


def _panels(pairs: Pairs, at: int) -> tuple[int, int]:
    return _sorted(pairs.panels[at])


def _sorted(panels: Indices) -> tuple[int, int]:
    p, q = (int(panel) for panel in panels)
    return min(p, q), max(p, q)
