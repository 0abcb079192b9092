"""The course of a motion: from state to state of the file, and down to the flat sheet."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from origami_lab.verification.certificate import degrees
from origami_lab.verification.claimed_states import wrapped
from origami_lab.verification.continuation import SMOOTH, SMOOTHER, Motion, StuckError, between
from origami_lab.verification.crossing_search import Sweep
from origami_lab.verification.findings import Gap
from origami_lab.verification.linkage import State
from origami_lab.verification.panel_pairs import Neighbourhood
from origami_lab.verification.plane_graph import Array, Indices

SAME_STATE, _EXACTLY = 1e-4, 1e-7
"""Radians: fold angles of one state, found in two ways, if it is nearly singular, and if it is not."""
_LOOSE = 1e-10
"""A smallest singular value that counts as 0 all along an interval."""
_AT_BRANCH = 1e-6
"""Radians of driving angle to which a branch point is enclosed at most."""
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
    loose: list[tuple[float, float]] = field(default_factory=list)
    """Driving angles between which the closure Jacobian is singular all along: a freedom beside the motion."""
    singular: float = float("inf")
    """The smallest singular value of the closure Jacobian along the motion, in the free creases."""
    singular_at: float = 0.0

    def sweep(self, sweep: Sweep, nodes: Sequence[State]) -> None:
        """Sweep the intervals between neighbouring states, and watch how near to singular they are."""
        before, last = 0.0, float("inf")
        for k, b in enumerate(nodes):
            if sweep.found.crossing is not None:
                return
            smallest, sign = sweep.motion.conditioning(b)
            if smallest < self.singular:
                self.singular, self.singular_at = smallest, b.driving
            if k:
                if sign * before < 0.0:
                    self.flips.append((nodes[k - 1].driving, b.driving))
                if max(smallest, last) <= _LOOSE:
                    self.loose.append((nodes[k - 1].driving, b.driving))
                sweep.interval(nodes[k - 1], b)
            before, last = sign, smallest


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
        most = sweep.most_states // 4
        try:
            nodes, missed = _between(motion, a, b, most)
        except StuckError as stuck:
            course.sweep(sweep, stuck.states)
            sweep.found.gaps.append(Gap(stuck.states[-1].driving, b.driving, _why(stuck)))
            continue
        if missed <= _sharpness(motion, b):
            course.missed = max(course.missed, missed)
            course.sweep(sweep, nodes)
        elif (branch := _two_branches(motion, nodes, b, most)) is not None:
            where, first, second = branch
            course.branches.append(where)
            course.sweep(sweep, first)
            if sweep.found.crossing is None:
                sweep.jump(first[-1], second[0], where)
            course.sweep(sweep, second)
        else:
            why = f"the motion from {degrees(a.driving)} leads to another state than the file's"
            sweep.found.gaps.append(Gap(a.driving, b.driving, why))
    return course


def _between(motion: Motion, a: State, b: State, most: int) -> tuple[list[State], float]:
    """States on the way from one state to another, and by how much the last (or first) one misses it, radians.

    Where another branch runs close by, as near ±180°, the walk may come out on that one: then it is tried with smaller
    steps, and backwards.
    """
    nodes: list[State] = []
    missed = float("inf")
    for smooth in (SMOOTH, SMOOTHER):
        nodes = motion.walk(a, b.driving, most, smooth)
        missed = _missed(nodes[-1], b)
        if missed <= _sharpness(motion, b):
            return nodes, missed
    with suppress(StuckError):
        back = motion.walk(b, a.driving, most)[::-1]
        if (turned := _missed(back[0], a)) <= _sharpness(motion, a):
            return back, turned
    return nodes, missed


def _missed(found: State, wanted: State) -> float:
    return float(np.abs(wrapped(found.rho - wanted.rho)).max(initial=0.0))


def _sharpness(motion: Motion, state: State) -> float:
    """How near a state must be come to, radians: the nearer to singular it is the less exactly it is known."""
    smallest = max(motion.conditioning(state)[0], 1e-12)
    return min(max(_EXACTLY, 10.0 * max(state.residual, 1e-15) / smallest), SAME_STATE)


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
    tree, count = linkage.tree, len(sheet.faces)
    turned = tree.summed(bound[tree.creases], count)
    hinge = np.zeros((count, 2))
    hinge[tree.children] = sheet.points[tree.hinges]
    # a point moves as far as its panel's hinge does, and turns about that
    arm = np.linalg.norm(hinge[tree.children] - hinge[tree.parents], axis=1)
    moved = tree.summed(turned[tree.parents] * arm, count)

    def reach(points: Indices, panels: Indices) -> Array:
        """(N,) how far some points (N, 3) of panels may have moved."""
        arms = np.linalg.norm(sheet.points[points] - hinge[panels][:, None], axis=2).max(axis=1)
        return np.asarray(moved[panels] + turned[panels] * arms)

    cones = near.neighbours
    if len(cones):
        turns = np.bincount(sheet.edges.ravel(), weights=np.repeat(bound, 2), minlength=len(sheet.points))
        if np.any(near.gap(cones, flat) <= turns[cones.first[:, 0]]):
            return False
    corners = linkage.flat[sheet.triangles]
    around = reach(sheet.triangles, sheet.owner)[:, None]
    pairs = near.close(corners.min(axis=1) - around, corners.max(axis=1) + around)
    far = reach(pairs.first, pairs.panels[:, 0]) + reach(pairs.second, pairs.panels[:, 1])
    return bool(np.all(near.gap(pairs, flat) > far))


def _two_branches(
    motion: Motion, up: list[State], goal: State, most: int
) -> tuple[float, list[State], list[State]] | None:
    """Where the motion from below and the one from ``goal`` downwards meet: a branch point.

    Returns the driving angle and the states up to just before it and from just behind it. None if the two do not meet,
    or pass each other at a distance.
    """
    try:
        down = motion.walk(goal, up[0].driving, most)[::-1]
    except StuckError:
        return None
    e = int(np.argmax(np.abs(wrapped(up[-1].rho - goal.rho))))

    low, high = (up[0], down[0]), (up[-1], goal)
    # an angle beyond ±180° is that on the other side
    for turns in (0.0, 2.0 * np.pi, -2.0 * np.pi):
        if (low[0].rho[e] - low[1].rho[e] - turns) * (high[0].rho[e] - high[1].rho[e] - turns) < 0.0:
            break
    else:
        return None

    def apart(pair: tuple[State, State]) -> float:
        return float(pair[0].rho[e] - pair[1].rho[e] - turns)

    known = (list(up), list(down))
    while high[0].driving - low[0].driving > _AT_BRANCH:
        middle = (low[0].driving + high[0].driving) / 2.0
        one, other = (_found_between(motion, nodes, middle) for nodes in known)
        # so near the branch point that the solver does not resolve it, or knows its states and speeds but roughly
        if one is None or other is None or max(_sharpness(motion, one), _sharpness(motion, other)) > _EXACTLY:
            break
        if apart((one, other)) * apart(low) > 0.0:
            low = (one, other)
        else:
            high = (one, other)
    width = high[0].driving - low[0].driving
    share = apart(low) / (apart(low) - apart(high))
    rest = (1.0 - share) * wrapped(low[0].rho - low[1].rho) + share * wrapped(high[0].rho - high[1].rho)
    if np.abs(rest).max() > max(_EXACTLY, 10.0 * width * width):
        return None
    where = low[0].driving + share * width
    first = [s for s in up if s.driving < low[0].driving] + [low[0]]
    second = [high[1]] + [s for s in down if s.driving > high[1].driving]
    return where, first, second


def _found_between(motion: Motion, nodes: list[State], driving: float) -> State | None:
    """The state at a driving angle on the curve through the nodes, which it is put among."""
    at = min(max(bisect([s.driving for s in nodes], driving), 1), len(nodes) - 1)
    a, b = nodes[at - 1], nodes[at]
    state = motion.solve(driving, between(a, b, (driving - a.driving) / (b.driving - a.driving)))
    if state is not None:
        nodes.insert(at, state)
    return state


def branch_text(course: Course) -> str:
    """What to say of singular states on the way."""
    where = " and ".join(degrees(angle) for angle in course.branches)
    text = f"; at {where} the motion branches, a fold angle passing through 0" if where else ""
    others = [flip for flip in course.flips if not any(flip[0] <= angle <= flip[1] for angle in course.branches)]
    return text + "".join(f"; singular between {degrees(low)} and {degrees(high)}" for low, high in others[:3])
