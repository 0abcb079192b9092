"""One interaction, and whole episodes, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV, near_side, tail
from origami_lab.game.kernels.boundary_sources import boundary_action, lay_boundary_source
from origami_lab.game.kernels.extension import extend
from origami_lab.game.kernels.legal_actions import write_legal_actions
from origami_lab.game.kernels.start_placement import lay_source, place_start
from origami_lab.game.kernels.state import (
    BARE,
    FIRST,
    FULL,
    PLACEMENT,
    RUNNING,
    SECOND,
    SELECTION,
    STUCK,
    TERMINATED,
    THIRD,
    Record,
    States,
    add_crease,
    board_points,
    clear,
    copy_state,
    point_x,
    point_y,
)
from origami_lab.game.kernels.straight_sectors import close_sector, lock_beside
from origami_lab.jit import bare, inlined

Actions = NDArray[np.int32]


@inlined
def has_room(s: Record) -> bool:
    """Whether one more extension fits the state's capacity."""
    return (
        s.n_vertices + 3 <= s.xy.shape[0]
        and s.n_triangles + 6 <= s.images.shape[0]
        and s.n_creases + 4 <= s.driven.shape[0]
        and s.n_actions + 5 <= s.actions.shape[0]
    )


@bare
def leaf_at(s: Record, x: int, y: int) -> int:
    """The representative leaf at a board point, −1 if there is none."""
    w = s.head
    while True:
        if s.xy[w, 0] == x and s.xy[w, 1] == y:
            return int(w)
        code = s.next[w]
        if code & 7 != 0 or code >> 3 == s.head:
            return -1
        w = code >> 3


@bare
def play_action(s: Record, r: Record, action: int) -> None:
    """Play one legal action (legality is the caller's affair) and log it."""
    points = board_points(r)
    s.actions[s.n_actions] = action
    s.n_actions += 1
    if s.phase == SELECTION:
        if action < 2 * points:
            s.mode = 1 if action >= points else -1
            s.selected = leaf_at(s, point_x(r, action % points), point_y(r, action % points))
            s.phase = FIRST
            s.unfinished = 1
        elif action == 3 * points:
            s.status = TERMINATED
        elif action >= boundary_action(r):
            s.mode = 2 * (action - boundary_action(r)) - 1
            s.phase = PLACEMENT
            s.unfinished = 1
        else:
            option = action - 3 * points - 1
            sign = 1 if option & 1 else -1
            if option < 2:
                v = s.head
                other = s.prev[v]
                if s.locked[v] == BARE:
                    s.locked[v], s.first[v] = 0, other
                else:
                    close_sector(s, v, lock_beside(s, r, v, PREV))
                lay_source(s, r, v, 0, sign)
            else:
                v = tail(s)
                other = s.next[v]
                if s.locked[v] == BARE:
                    s.locked[v], s.last[v] = 0, other
                else:
                    close_sector(s, v, lock_beside(s, r, v, NEXT))
                lay_source(s, r, v, 1, sign)
            add_crease(s, 8 * v, other, sign)
            if not has_room(s):
                s.status = FULL
        return
    if s.phase == PLACEMENT:
        if action < 3 * points:
            x, y = point_x(r, action - 2 * points), point_y(r, action - 2 * points)
            if s.n_vertices > 0:
                lay_boundary_source(s, r, leaf_at(s, x, y), s.mode)
                if not has_room(s):
                    s.status = FULL
                return
            if s.unfinished == 0:
                s.first_x, s.first_y = x, y
            s.second_x, s.second_y = x, y
            s.unfinished += 1
            return
        option = action - 3 * points - 5
        place_start(s, r, option // 2, 1 if option & 1 else -1)
        return
    x, y = point_x(r, action - 2 * points), point_y(r, action - 2 * points)
    s.unfinished += 1
    if s.phase == FIRST:
        v = s.selected
        s.first_x, s.first_y = x, y
        s.phase = SECOND
        if s.axis[v] > 0:
            # the other outer child is this one's mirror image
            m = r.matrices[s.axis[v]]
            s.second_x, s.second_y = m[0] * x + m[1] * y, m[2] * x + m[3] * y
            if near_side(s, r, v) != PREV:
                s.first_x, s.first_y, s.second_x, s.second_y = s.second_x, s.second_y, x, y
            s.phase = THIRD
    elif s.phase == SECOND:
        s.second_x, s.second_y = x, y
        s.phase = THIRD
    else:
        extend(s, r, x, y)
        if s.status == RUNNING and not has_room(s):
            s.status = FULL


@bare
def settle(s: Record, r: Record, legal: Actions) -> int:
    """The number of legal actions, written to ``legal``; an episode that has none left ends here."""
    n = write_legal_actions(s, r, legal)
    if n == 0 and s.status == RUNNING:
        s.status = STUCK
    return n


# Entry points from Python take an array of states and an index: a record costs more to pass than its array.


@bare
def clear_state(states: States, i: int) -> None:
    clear(states[i])


@bare
def copy_to_all(targets: States, sources: States) -> None:
    """Make all targets the first source."""
    for i in range(targets.shape[0]):
        copy_state(targets[i], sources[0])


@bare
def copy_to(targets: States, i: int, sources: States, j: int) -> None:
    copy_state(targets[i], sources[j])


@bare
def step(states: States, i: int, rules: States, action: int, legal: Actions) -> int:
    """Play one legal action; returns the number of actions legal afterwards, written to ``legal``."""
    play_action(states[i], rules[0], action)
    return settle(states[i], rules[0], legal)


@bare
def branch(states: States, i: int, j: int, rules: States, action: int, legal: Actions) -> tuple[int, bool]:
    """Make state i the one that a legal action leads to from state j.

    Returns the number of actions legal there (0: the episode has ended), written to ``legal``, and whether the move is
    complete.
    """
    copy_state(states[i], states[j])
    play_action(states[i], rules[0], action)
    n = settle(states[i], rules[0], legal)
    return n, states[i].phase == SELECTION


@bare
def legal_of(states: States, i: int, rules: States, legal: Actions) -> int:
    """The number of legal actions, written to ``legal``."""
    return settle(states[i], rules[0], legal)


@bare
def play_uniform(
    states: States, i: int, rules: States, draws: NDArray[np.float64], start: int, limit: int, legal: Actions
) -> int:
    """Play on with uniformly random actions until the episode ends or ``limit`` actions are played.

    Each action uses one of ``draws``, uniform in [0, 1), from index ``start`` on. Returns the number played.
    """
    s, r = states[i], rules[0]
    played = 0
    while played < limit:
        n = settle(s, r, legal)
        if n == 0:
            break
        play_action(s, r, legal[int(draws[start + played] * n)])
        played += 1
    return played


@bare
def play_greedy(
    states: States,
    i: int,
    rules: States,
    values: NDArray[np.float64],
    slots: NDArray[np.int32],
    limit: int,
    legal: Actions,
) -> int:
    """Play on with the legal action of the highest value until the episode ends or ``limit`` actions are played.

    The value of an action is ``values[slots[0, action]]``, or ``slots[1, action]`` while a leaf is extended in mode +1.
    Of equal values the first legal action wins. Returns the number played.
    """
    s, r = states[i], rules[0]
    played = 0
    while played < limit:
        n = settle(s, r, legal)
        if n == 0:
            break
        row = 1 if s.phase > SELECTION and s.mode > 0 else 0
        best = legal[0]
        for action in legal[1:n]:
            if values[slots[row, action]] > values[slots[row, best]]:
                best = action
        play_action(s, r, best)
        played += 1
    return played


@bare
def replay_unchecked(states: States, i: int, rules: States, actions: Actions) -> int:
    """Play known-legal actions, the start pattern's among them, from an empty board under any rules.

    Returns how many angles stay reachable.
    """
    s, r = states[i], rules[0]
    clear(s)
    for action in actions:
        if s.status != RUNNING:
            break
        play_action(s, r, action)
    return s.reach if s.unfinished == 0 else 0
