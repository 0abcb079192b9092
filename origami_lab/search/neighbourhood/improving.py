"""Changes of a run's design under a threshold, compiled: one after another, until one is worth a score.

A change is laid and grown a few times. The energy of the annealing is the number of samples that are left uncovered: a
design that leaves more than the present one takes its place with a probability that falls with the difference. A run
without a design grows one from a random start pattern.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import Record, copy_state
from origami_lab.game.move_table import read_moves
from origami_lab.jit import bare, inlined, kernel
from origami_lab.objectives.coverage_gain import Coverage, cover_panels
from origami_lab.search.neighbourhood.changes import (
    TOO_FEW,
    Shift,
    choose_shift,
    first_changed,
    make_shift,
    mark_cuts,
    nearest_move,
    parent_of,
    placements,
)
from origami_lab.search.neighbourhood.draft import Course, Draft
from origami_lab.search.neighbourhood.ground import BEST, REST, WORK, Ground, begin_at, place_at_random
from origami_lab.search.neighbourhood.growth import PAUSED, Effort, grow
from origami_lab.search.neighbourhood.one_run import NONE_YET
from origami_lab.search.neighbourhood.relaying import relay
from origami_lab.search.neighbourhood.threshold import Aim, sheet_strays

# what a run is at: about to change its design, growing it, grown
BETWEEN, GROWING, GROWN = 0, 1, 2

# why it stopped: there is a first design, or a better one; more random numbers are needed; it is time to look up
FOUND_FIRST, FOUND, SHORT, LOOK_UP = 0, 1, 2, 3

PACE = 1024
"""Interactions that are played at most between two looks at the clock, save for the rest of a change."""

CHANGE_DRAWS = 64
"""Random numbers at hand when a change begins, besides one for each move; only many cuts can use more."""


class Habits(NamedTuple):
    """How designs are changed and taken, as :class:`~.method_numbers.MethodNumbers` says.

    The temperature is in samples.
    """

    near: float
    parent: float
    shift: float
    flip: float
    more: float
    noise: float
    regrowths: int
    idle_changes: int
    temperature: float


@inlined
def count(c: Record, interactions: int) -> None:
    """Count interactions, as far as the budget goes: a relay may have been longer."""
    c.interactions = min(c.interactions + interactions, c.budget)


@inlined
def end_change(c: Record) -> None:
    """A change is over; it came to nothing if it cost an interaction at most."""
    c.idle = c.idle + 1 if c.interactions <= c.before + 1 else 0
    c.phase = BETWEEN


@inlined
def choose_move(
    moves: NDArray[np.void],
    points: NDArray[np.float64],
    r: Record,
    habits: Habits,
    draft: Draft,
    c: Record,
    draws: NDArray[np.float64],
    used: int,
) -> tuple[int, int]:
    """The move that is changed: near something uncovered, or any; and the draws used in all.

    ``points`` are the samples of the target, (n, 3).
    """
    placed = placements(moves)
    chosen = placed + int(draws[used] * (c.n_moves - placed))
    used += 1
    if c.n_uncovered == 0:
        return chosen, used
    is_near = draws[used] < habits.near
    used += 1
    if not is_near:
        return chosen, used
    point = points[draft.uncovered[int(draws[used] * c.n_uncovered)]]
    chosen = nearest_move(moves, draft.places, point, r, habits.noise, draws, used + 1)
    used += 1 + c.n_moves
    return (parent_of(moves, chosen) if draws[used] < habits.parent else chosen), used + 1


@kernel
def lay_change(
    ground: Ground,
    aim: Aim,
    habits: Habits,
    points: NDArray[np.float64],
    draft: Draft,
    c: Record,
    draws: NDArray[np.float64],
    used: int,
) -> tuple[bool, int]:
    """Change the run's design and lay it on the state worked on; the draft is as before.

    A move is cut away, or a vertex of it is shifted; nothing is where there is only a start pattern. Returns whether
    the design was laid, and the draws used in all. It was not if a shift came to nothing, or if the draws are
    :data:`~.changes.TOO_FEW`.
    """
    r, moves, table = ground.rules[0], draft.moves[: c.n_moves], draft.points[: c.n_points]
    goes, first = draft.goes[: c.n_moves], c.n_moves
    shift = Shift(-1, -1, 0, 0)
    goes[:] = 0
    if placements(moves) < c.n_moves:
        chosen, used = choose_move(moves, points, r, habits, draft, c, draws, used)
        shifts = draws[used] < habits.shift
        used += 1
        if shifts:
            half = r.half_x, r.half_y
            shift, used = choose_shift(moves, table, c.own, chosen, half, habits.flip, draws, used)
            if shift.move < 0 and shift.vertex < 0:
                return False, used
            first = first_changed(moves, shift)
        else:
            used = mark_cuts(moves, chosen, habits.more, goes, draws, used)
            if used == TOO_FEW:
                return False, used
            first = 0
            while goes[first] == 0:
                first += 1
    begin_at(ground, aim.angle)
    make_shift(moves, table, shift, 1)
    sheet = ground.states, WORK, ground.rules, ground.plain
    count(c, relay(*sheet, aim, moves, table, goes, first, False, ground.room.notes))
    make_shift(moves, table, shift, -1)
    return True, used


@bare
def lay_start(ground: Ground, aim: Aim, c: Record, draws: NDArray[np.float64], used: int) -> tuple[bool, int]:
    """Lay a random start pattern on the state worked on; whether a run may begin with it, and the draws used in all."""
    s, r = ground.states[WORK], ground.rules[0]
    begin_at(ground, aim.angle)
    played = place_at_random(s, r, ground.room.legal, draws, used, c.budget - c.interactions)
    count(c, played)
    if played > 0:
        c.laid = s.n_vertices
    if c.interactions < c.budget and not sheet_strays(s, r, aim, 0, 0):
        return True, used + played
    count(c, int(c.interactions == c.before))  # an attempt is never free
    return False, used + played


@kernel
def keep_best(ground: Ground, aim: Aim, draft: Draft, c: Record) -> None:
    """Make the best growth of a change the design of the run."""
    s = ground.states[BEST]
    c.n_moves = read_moves(ground.states, BEST, ground.rules, ground.origin, draft.moves, draft.points)
    c.n_points, c.n_uncovered, c.own = s.n_vertices, c.best, c.laid
    for v in range(s.n_vertices):
        for j in range(3):
            draft.places[v, j] = s.position[v, aim.angle, j]
    draft.uncovered[: c.best] = draft.best_uncovered[: c.best]


@kernel
def improve(
    ground: Ground,
    aim: Aim,
    effort: Effort,
    habits: Habits,
    coverage: Coverage,
    draft: Draft,
    course: Course,
    stop: float,
    draws: NDArray[np.float64],
    used: int,
) -> tuple[int, int]:
    """Go on with a run until a design is to be scored, or so many interactions are played in all.

    Parameters
    ----------
    draft, course
        The run's design, and where the run is; they are taken further.
    stop
        No change begins with so many interactions or more.
    draws, used
        Random numbers, and how many of them are used up.

    Returns
    -------
    why
        FOUND_FIRST: what is on the state WORK is to be the run's first design. FOUND: what is on BEST leaves nothing
        uncovered, or less than any design that was scored. The caller is to say what such a change has cost, and to
        write the design. SHORT: call again with more draws. LOOK_UP: anything else.
    used
        Draws used in all.
    """
    s, r, c = ground.states[WORK], ground.rules[0], course[0]
    pause = min(stop, np.float64(min(c.interactions + PACE, c.budget)))
    ended = False
    while True:
        if c.phase == BETWEEN:
            if c.interactions >= pause or (ended and c.idle >= habits.idle_changes):
                return LOOK_UP, used
            if draws.shape[0] - used < CHANGE_DRAWS + c.n_moves:
                return SHORT, used
            c.before = c.interactions
            if c.has_design:
                laid, after = lay_change(ground, aim, habits, coverage.points, draft, c, draws, used)
                if after == TOO_FEW:
                    return SHORT, used
            else:
                laid, after = lay_start(ground, aim, c, draws, used)
            used = after
            if not laid:
                end_change(c)
                ended = True
                continue
            c.left = c.rest = cover_panels(s, r, aim.angle, 0, coverage, aim.threshold, coverage.order.shape[0])
            c.failed, c.again, c.best, c.phase = 0, 0, NONE_YET, GROWING
            if c.has_design:
                copy_state(ground.states[REST], s)
        if c.phase == GROWING:
            goal = c.n_uncovered if c.has_design else -1
            sheet = ground.states, WORK, ground.rules, aim, effort, coverage
            why, c.left, c.failed, used, played, looked = grow(
                *sheet, c.left, goal, c.failed, ground.room, draws, used, c.budget - c.interactions
            )
            count(c, played)
            c.looked += looked
            if why == PAUSED and c.interactions < c.budget:
                return SHORT, used
            if not c.has_design:
                c.phase, c.best = BETWEEN, c.left
                if s.n_extensions > 0 or c.left == 0:
                    return FOUND_FIRST, used
                count(c, int(c.interactions == c.before))
                end_change(c)
                ended = True
                continue
            if c.left < c.best:
                c.best = c.left
                draft.best_uncovered[: c.left] = coverage.order[: c.left]
                copy_state(ground.states[BEST], s)
            c.again += 1
            if c.best > 0 and c.interactions < c.budget and c.again < habits.regrowths:
                copy_state(s, ground.states[REST])
                c.left, c.failed = c.rest, 0
                continue
            if c.best == 0 or c.best < c.lowest:
                c.phase = BETWEEN
                return FOUND, used
            c.phase = GROWN
        if used == draws.shape[0]:
            return SHORT, used
        if c.best <= c.n_uncovered - habits.temperature * np.log(max(draws[used], 1e-300)):
            keep_best(ground, aim, draft, c)
        used += 1
        end_change(c)
        ended = True
