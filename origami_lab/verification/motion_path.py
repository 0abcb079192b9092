"""The course of a motion: from state to state of the file, and down to the flat sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from origami_lab.verification.certificate import degrees
from origami_lab.verification.claimed_states import wrapped
from origami_lab.verification.continuation import SMOOTH, SMOOTHER, Motion, StuckError, between
from origami_lab.verification.crossing_search import Gap, Sweep
from origami_lab.verification.linkage import State
from origami_lab.verification.panel_pairs import Neighbourhood
from origami_lab.verification.plane_graph import Array

SAME_STATE = 1e-4
"""Radians: fold angles of one state, found in two ways."""
_BEYOND = 1e-3
"""Radians by which a motion is followed beyond a branch point."""
_HALVINGS = 20


@dataclass
class Course:
    """What is known of a motion beside what its sweep found."""

    low: float
    """Radians: below this driving angle the sheet is as good as flat, see :func:`nearly_flat`."""
    flat: bool
    """Whether the motion was followed down to the nearly flat sheet."""
    high: float
    missed: float
    """Radians: by how much the solver's states differ from the file's."""
    branches: list[float] = field(default_factory=list)
    """Driving angles at which the motion branches and the file changes over to the other branch."""
    flips: list[tuple[float, float]] = field(default_factory=list)
    """Driving angles between which the closure Jacobian is singular, for its determinant changes sign."""
    singular: float = float("inf")
    """The smallest singular value of the closure Jacobian along the motion, in the free creases."""
    singular_at: float = 0.0

    def sweep(self, sweep: Sweep, nodes: Sequence[State]) -> None:
        """Sweep the intervals between neighbouring states, and watch how near to singular they are."""
        before = 0.0
        for k, b in enumerate(nodes):
            if sweep.found.crossing is not None:
                return
            smallest, sign = sweep.motion.conditioning(b)
            if smallest < self.singular:
                self.singular, self.singular_at = smallest, b.driving
            if k:
                if sign * before < 0.0:
                    self.flips.append((nodes[k - 1].driving, b.driving))
                sweep.interval(nodes[k - 1], b)
            before = sign


def follow(sweep: Sweep, states: Sequence[State]) -> Course:
    """Sweep the motion from the flat sheet through all states, which come by increasing driving angle."""
    motion, near = sweep.motion, sweep.near
    course = Course(states[0].driving, False, states[-1].driving, 0.0)
    down = _descend(motion, near, states[0], sweep.most_states // 4)
    course.low, course.flat = down[-1].driving, nearly_flat(near, down[-1])
    if course.flat:
        course.sweep(sweep, down[::-1])
    else:  # at a branch point on the way the motion may have gone where the file's does not
        course.low = states[0].driving
    for a, b in pairwise(states):
        if sweep.found.crossing is not None:
            break
        for smooth in (SMOOTH, SMOOTHER):
            try:
                nodes = motion.walk(a, b.driving, sweep.most_states // 4, smooth)
            except StuckError as stuck:
                course.sweep(sweep, stuck.states)
                sweep.found.gaps.append(Gap(stuck.states[-1].driving, b.driving, _why(stuck)))
                nodes = []
                break
            missed = float(np.abs(wrapped(nodes[-1].rho - b.rho)).max(initial=0.0))
            if missed <= SAME_STATE:
                break
        if not nodes:
            continue
        if missed <= SAME_STATE:
            course.missed = max(course.missed, missed)
            course.sweep(sweep, nodes)
        elif (parts := _two_branches(motion, nodes, b, sweep.most_states // 4)) is not None:
            course.branches.append(parts[0])
            course.sweep(sweep, parts[1])
            course.sweep(sweep, parts[2])
        else:
            why = f"the motion from {degrees(a.driving)} leads to another state than the file's"
            sweep.found.gaps.append(Gap(a.driving, b.driving, why))
    return course


def _why(stuck: StuckError) -> str:
    return f"the solver does not get on (smallest singular value {stuck.singular:.1e})"


def _descend(motion: Motion, near: Neighbourhood, start: State, most: int) -> list[State]:
    """States from the first one down until the sheet is nearly flat, or as far as the solver gets."""
    nodes = [start]
    for _ in range(_HALVINGS):
        if nearly_flat(near, nodes[-1]):
            break
        try:
            nodes += motion.walk(nodes[-1], nodes[-1].driving / 2.0, most)[1:]
        except StuckError:
            break
    return nodes


def nearly_flat(near: Neighbourhood, state: State) -> bool:
    """Whether no panels can cross as long as every crease folds by no more than twice what it does at ``state``.

    In the flat sheet pairs of triangles are parted by lines; no triangle moves, and no cone turns, by more than the
    fold angles on the way from the central panel, or around the vertex, allow.
    """
    linkage, sheet = near.linkage, near.sheet
    bound = 2.0 * np.abs(state.rho)
    flat = linkage.place(0.0, np.zeros(len(bound)), np.zeros(len(bound)), 0.0)
    turned = np.zeros(len(sheet.faces))
    moved = np.zeros((len(sheet.faces), len(sheet.points)))  # of the points of each panel
    for child, parent, e, u, _ in linkage.levels:
        turned[child] = turned[parent] + bound[e]
        for c, p, hinge in zip(child, parent, u, strict=True):
            ring = list(sheet.faces[c])
            arm = np.linalg.norm(sheet.points[ring] - sheet.points[hinge], axis=1)
            moved[c, ring] = moved[p, hinge] + turned[c] * arm
    cones = near.neighbours
    if len(cones):
        around: Array = np.zeros(len(sheet.points))
        np.add.at(around, sheet.edges.ravel(), np.repeat(bound, 2))
        if np.any(near.gap(cones, flat) <= around[cones.first[:, 0]]):
            return False
    corners = linkage.flat[sheet.triangles]
    reach = moved[sheet.owner[:, None], sheet.triangles].max(axis=1)
    pairs = near.close(corners.min(axis=1) - reach[:, None], corners.max(axis=1) + reach[:, None])
    far = [moved[pairs.panels[:, k, None], corners].max(axis=1) for k, corners in ((0, pairs.first), (1, pairs.second))]
    return bool(np.all(near.gap(pairs, flat) > far[0] + far[1]))


def _two_branches(
    motion: Motion, up: list[State], goal: State, most: int
) -> tuple[float, list[State], list[State]] | None:
    """Where the motion from below and the one from ``goal`` downwards meet: a branch point.

    Returns the driving angle and the states on both sides, each followed a little beyond it.
    """
    try:
        down = motion.walk(goal, up[0].driving, most)[::-1]
    except StuckError:
        return None
    e = int(np.argmax(np.abs(up[-1].rho - goal.rho)))

    def both(driving: float) -> tuple[State, State] | None:
        found = [motion.solve(driving, _along(nodes, driving)) for nodes in (up, down)]
        return None if found[0] is None or found[1] is None else (found[0], found[1])

    def apart(pair: tuple[State, State]) -> float:
        return float(pair[0].rho[e] - pair[1].rho[e])

    low, high = up[0].driving, goal.driving
    at_low, at_high = both(low), both(high)
    if at_low is None or at_high is None or apart(at_low) * apart(at_high) >= 0.0:
        return None
    while high - low > 1e-5:
        middle = (low + high) / 2.0
        pair = both(middle)
        if pair is None:  # the solver does not resolve the branch point itself
            break
        low, high = (middle, high) if apart(pair) * apart(at_low) > 0.0 else (low, middle)
    where = (low + high) / 2.0
    ends = [np.abs(_along(up, where) - _along(down, where)).max()]
    if max(ends) > 1e-3:
        return None
    first = [s for s in up if s.driving < where] + _one(motion, up, min(where + _BEYOND, up[-1].driving))
    second = _one(motion, down, max(where - _BEYOND, down[0].driving)) + [s for s in down if s.driving > where]
    return where, first, second


def _one(motion: Motion, nodes: list[State], driving: float) -> list[State]:
    found = motion.solve(driving, _along(nodes, driving))
    return [] if found is None else [found]


def _along(nodes: list[State], driving: float) -> Array:
    """(E,) fold angles on the curve through the nodes."""
    at = min(max(int(np.searchsorted([s.driving for s in nodes], driving)), 1), len(nodes) - 1)
    a, b = nodes[at - 1], nodes[at]
    return between(a, b, (driving - a.driving) / (b.driving - a.driving))


def branch_text(course: Course) -> str:
    """What to say of singular states on the way."""
    where = " and ".join(degrees(angle) for angle in course.branches)
    text = f"; at {where} the motion branches, a fold angle passing through 0" if where else ""
    others = [flip for flip in course.flips if not any(flip[0] <= angle <= flip[1] for angle in course.branches)]
    return text + "".join(f"; singular between {degrees(low)} and {degrees(high)}" for low, high in others[:3])
