"""Growth under a threshold, towards what is not covered yet.

A random uncovered sample of the target calls; a leaf near it answers and is extended by the first triple of places that
folds to the run's driving angle, stays within the threshold and covers something new. Growth ends when all is covered
or several leaves in a row could not be extended.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary_sources import boundary_action, count_free_segments, free_segment
from origami_lab.game.kernels.legal_actions import is_selectable
from origami_lab.game.kernels.outer_panel import outer_panel_collides
from origami_lab.game.kernels.play import play_action
from origami_lab.game.kernels.state import (
    NOT_FOLDABLE,
    RUNNING,
    SELECTION,
    THIRD,
    Record,
    States,
    board_points,
    point_index,
    point_x,
    point_y,
)
from origami_lab.game.kernels.undo import play_noted, restore
from origami_lab.game.move_table import source_is_legal
from origami_lab.jit import bare, inlined, kernel
from origami_lab.objectives.coverage_gain import Coverage, cover_panels
from origami_lab.search.neighbourhood.ground import DEPTHS, Room
from origami_lab.search.neighbourhood.known_strays import is_known, learn, list_key, mixed
from origami_lab.search.neighbourhood.threshold import Aim, child_strays, seam_strays

# why growth stopped
GROWN, PAUSED = 0, 1


class Effort(NamedTuple):
    """How hard growth tries.

    Attributes
    ----------
    places
        Places tried at most for each child in turn.
    actions
        Actions at most for one move.
    failures, failures_at_goal
        Moves that may fail in a row, and how many once no more samples are uncovered than the goal asks.
    idle
        Probability that a move need not cover anything new.
    source
        Probability that a driven crease is laid where one can be.
    noise
        Board cells, at most, that are added at random to a leaf's distance from the sample that calls.
    look
        Whether places that stray, and panels that collide, are passed over: they are no tries, and no interactions.
    """

    places: int
    actions: int
    failures: int
    failures_at_goal: int
    idle: float
    source: float
    noise: float
    look: bool


@bare
def child_fails(s: Record, r: Record, aim: Aim, action: int) -> bool:
    """Whether an outer child that does not stray has a panel that collides on the way to the run's angle."""
    if s.phase == THIRD:
        return False
    index = action - 2 * board_points(r)
    return bool(outer_panel_collides(s, r, aim.angle + 1, point_x(r, index), point_y(r, index)))


@kernel
def try_move(
    s: Record,
    r: Record,
    aim: Aim,
    effort: Effort,
    select: int,
    gain: int,
    coverage: Coverage,
    uncovered: int,
    room: Room,
    draws: NDArray[np.float64],
    used: int,
    limit: int,
) -> tuple[bool, int, int, int, int]:
    """Try to extend a leaf: places for its children in random order, depth first, until a whole move succeeds.

    Parameters
    ----------
    select
        The action that selects the leaf and its mode.
    gain
        Samples that the move must cover that were not.
    limit
        Actions at most.

    Returns
    -------
    success
        Whether the move is on the board; else the state is as before.
    uncovered
        Samples that are uncovered now.
    used, played, looked
        Draws used in all; actions played or tried; places whose closed form was evaluated.
    """
    t_before = s.n_triangles
    # of the open list at each depth: its places, those tried, those drawn, what decides where they lie
    counts, tried, drawn = np.empty(DEPTHS, np.int64), np.empty(DEPTHS, np.int64), np.empty(DEPTHS, np.int64)
    keys = np.empty(DEPTHS, np.int64)
    played, looked = 1, 0
    n = play_noted(s, r, select, room.notes[0], room.legal)
    depth = 0
    room.lists[0, :n] = room.legal[:n]
    counts[0], drawn[0], tried[0], keys[0] = n, 0, 0, list_key(s, r, aim.angle)
    while True:
        if played >= limit or drawn[depth] >= counts[depth] or tried[depth] >= effort.places:
            # nothing more to be tried here: the action that led here goes back
            restore(s, room.notes[depth])
            depth -= 1
            if depth < 0:
                return False, uncovered, used, played, looked
            continue
        at = drawn[depth]
        j = at + int(draws[used] * (counts[depth] - at))
        used += 1
        action = room.lists[depth, j]
        room.lists[depth, j], room.lists[depth, at] = room.lists[depth, at], action
        drawn[depth] = at + 1
        key = mixed(keys[depth], np.int64(action))
        if is_known(room.known, key, aim.threshold):
            continue
        looked += 1
        strays = child_strays(s, r, aim, action)
        if strays:
            learn(room.known, key, aim.threshold)
        if strays or child_fails(s, r, aim, action):
            if not effort.look:
                # as if it had been played and taken back
                tried[depth] += 1
                played += 1
            continue
        tried[depth] += 1
        played += 1
        n = play_noted(s, r, action, room.notes[depth + 1], room.legal)
        if s.phase == SELECTION:
            if s.status != NOT_FOLDABLE and not (aim.spacing > 0.0 and seam_strays(s, r, aim, t_before)):
                after = cover_panels(s, r, aim.angle, t_before, coverage, aim.threshold, uncovered)
                if uncovered - after >= gain:
                    return True, after, used, played, looked
            restore(s, room.notes[depth + 1])
            continue
        depth += 1
        room.lists[depth, :n] = room.legal[:n]
        counts[depth], drawn[depth], tried[depth], keys[depth] = n, 0, 0, list_key(s, r, aim.angle)


@bare
def squared_to_images(s: Record, r: Record, v: int, k: int, point: NDArray[np.float64]) -> float:
    """Squared distance from a point to the nearest image of a vertex at driving angle k."""
    x, y, z = s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]
    nearest = np.inf
    for g in range(r.order):
        dx = r.matrices[g, 0] * x + r.matrices[g, 1] * y - point[0]
        dy = r.matrices[g, 2] * x + r.matrices[g, 3] * y - point[1]
        nearest = min(nearest, dx * dx + dy * dy)
    return float(nearest + (z - point[2]) ** 2)


@inlined
def leaf_near(
    s: Record, r: Record, k: int, point: NDArray[np.float64], noise: float, draws: NDArray[np.float64], used: int
) -> tuple[int, int]:
    """The selectable leaf that is nearest to a point in space, each distance with noise; −1 if there is none.

    Also returns the number of draws used in all.
    """
    nearest, chosen = np.inf, -1
    w = s.head
    while True:
        if is_selectable(s, r, w):
            distance = np.sqrt(squared_to_images(s, r, w, k, point)) + noise * draws[used]
            used += 1
            if distance < nearest:
                nearest, chosen = distance, int(w)
        code = s.next[w]
        if code & 7 != 0 or code >> 3 == s.head:
            return chosen, used
        w = code >> 3


@inlined
def play_source(s: Record, r: Record, draw: float, most: int) -> int:
    """Lay a random driven crease with ``most`` actions at most; returns how many were played."""
    n = board_points(r)
    start, end = False, False
    if r.sources and r.order > 1:
        w = s.head
        while s.next[w] & 7 == 0 and s.next[w] >> 3 != s.head:
            w = s.next[w] >> 3
        start, end = source_is_legal(s, r, s.head, 0), source_is_legal(s, r, w, 1)
    on_axes = 2 * int(start) + 2 * int(end)
    count = on_axes + 2 * count_free_segments(s, r)
    chosen = int(draw * count)
    if count == 0 or (chosen >= on_axes and most < 2):
        return 0
    if chosen < on_axes:
        play_action(s, r, 3 * n + 1 + chosen + (0 if start else 2))
        return 1
    v = free_segment(s, r, (chosen - on_axes) // 2)
    play_action(s, r, boundary_action(r) + (chosen - on_axes) % 2)
    play_action(s, r, 2 * n + point_index(r, s.xy[v, 0], s.xy[v, 1]))
    return 2


@bare
def grow(
    states: States,
    i: int,
    rules: States,
    aim: Aim,
    effort: Effort,
    coverage: Coverage,
    uncovered: int,
    goal: int,
    failed: int,
    room: Room,
    draws: NDArray[np.float64],
    used: int,
    limit: int,
) -> tuple[int, int, int, int, int, int]:
    """Grow state i until all is covered, ``effort.failures`` moves in a row have failed, or ``limit`` is reached.

    Parameters
    ----------
    uncovered
        The number of samples that are uncovered; ``coverage`` holds which.
    goal
        With this many of them or fewer ``effort.failures_at_goal`` are enough to stop.
    failed
        Moves that have failed in a row already.
    draws, used
        Random numbers, and how many of them are used up.
    limit
        Interactions that may be played.

    Returns
    -------
    why
        GROWN, or PAUSED: call again with more draws.
    uncovered, failed, used, played, looked
        As they are now; interactions played; places whose closed form was evaluated.
    """
    s, r = states[i], rules[0]
    n = board_points(r)
    played = looked = 0
    while True:
        if uncovered == 0 or played >= limit or s.status != RUNNING:
            return GROWN, uncovered, failed, used, played, looked
        if failed >= (effort.failures if uncovered > goal else effort.failures_at_goal):
            return GROWN, uncovered, failed, used, played, looked
        if draws.shape[0] - used < draws_of_a_move(s, effort, room):
            return PAUSED, uncovered, failed, used, played, looked
        sample = coverage.order[int(draws[used] * uncovered)]
        lays_source, which, upward, idles = draws[used + 1], draws[used + 2], draws[used + 3], draws[used + 4]
        used += 5
        v, used = leaf_near(s, r, aim.angle, coverage.points[sample], effort.noise, draws, used)
        if v < 0 or lays_source < effort.source:
            actions = play_source(s, r, which, limit - played)
            if actions > 0:
                played += actions
                continue
            if v < 0:
                return GROWN, uncovered, failed, used, played, looked
        select = point_index(r, s.xy[v, 0], s.xy[v, 1]) + (n if upward < 0.5 else 0)
        gain = 0 if idles < effort.idle else 1
        most = min(effort.actions, limit - played)
        success, uncovered, used, actions, places = try_move(
            s, r, aim, effort, select, gain, coverage, uncovered, room, draws, used, most
        )
        played += actions
        looked += places
        failed = 0 if success else failed + 1


@inlined
def draws_of_a_move(s: Record, effort: Effort, room: Room) -> int:
    """Random numbers that one move needs at most: places that are passed over use one each, too."""
    return int(8 + s.n_vertices + (effort.actions + 1) * room.lists.shape[1])
