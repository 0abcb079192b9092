"""A design as a table of moves over numbered vertices, and how its moves are laid again after a change.

Moves name vertices, and where vertices lie is a table of its own. So a vertex is shifted by changing one row: every
move that extends it, has it as a child or merges into it goes with it. Vertices have the numbers of the state that the
table was read from; the start pattern's come first. A table says nothing about foldability or legality: a move that
has become impossible is found out when it is laid, one place at a time, without listing all that would be legal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV, tail
from origami_lab.game.kernels.boundary_sources import boundary_action, segment_is_free, source_fits
from origami_lab.game.kernels.corner_choice import pick_is_legal
from origami_lab.game.kernels.legal_actions import is_selectable, location_is_legal
from origami_lab.game.kernels.play import leaf_at, play_action
from origami_lab.game.kernels.state import (
    NOT_FOLDABLE,
    ON_BOUNDARY,
    PLACEMENT,
    RUNNING,
    SELECTION,
    Record,
    States,
    board_points,
    point_index,
)
from origami_lab.game.kernels.undo import Notes, restore, write_note
from origami_lab.jit import bare, inlined, kernel

PLACE, EXTEND, SOURCE = 0, 1, 2
NEXT_LEAF = 2
"""The option of a source on the boundary inside the domain."""

MOVE = np.dtype(
    (
        np.record,
        np.dtype(
            [
                ("kind", np.int32),  # PLACE, EXTEND or SOURCE
                ("leaf", np.int32),  # the vertex that is extended or gets a source; −1 for a placement
                ("sign", np.int32),  # the rigid body mode, or the sign of the driving angle
                # children in the order they are placed, or the corners by which a placement is chosen; −1: none
                ("first", np.int32),
                ("second", np.int32),  # −1, too, for a leaf on an axis: its other outer child is an image
                ("middle", np.int32),
                # a placement's option, or a source's end: 0 start, 1 end, 2 from the leaf to the next one, "first"
                ("option", np.int32),
            ],
            align=True,
        ),
    )
)
"""Layout of a row of a table of moves."""

Moves = NDArray[np.void]
"""(M,) array of :data:`MOVE`."""
Points = NDArray[np.int32]
"""(V, 2) board points of the vertices that the moves name."""
Flags = NDArray[np.int8]

ACTIONS = 4
"""Most actions of a move."""


@kernel
def read_moves(states: States, i: int, rules: States, origin: States, moves: Moves, points: Points) -> int:
    """Write the table of the moves that led from the start pattern in ``origin`` to state i; returns their number.

    An extension that is not complete and the end of the episode are left out. ``points`` gets a row for each
    representative vertex of the state.
    """
    s, r, begin = states[i], rules[0], origin[0]
    n = board_points(r)
    vertex_at = np.full(n, -1, np.int32)
    for v in range(s.n_vertices):
        points[v, 0], points[v, 1] = s.xy[v, 0], s.xy[v, 1]
        vertex_at[point_index(r, s.xy[v, 0], s.xy[v, 1])] = v
    count, crease = 0, begin.n_creases
    a, end = begin.n_actions, s.n_actions - s.unfinished
    while a < end and s.actions[a] != 3 * n:
        move, action = moves[count], s.actions[a]
        move.leaf = move.first = move.second = move.middle = -1
        move.option = 0
        count += 1
        if a < r.picks and begin.phase == PLACEMENT:
            move.first = vertex_at[action - 2 * n]
            if r.picks > 1:
                move.second = vertex_at[s.actions[a + 1] - 2 * n]
            a += r.picks
            action = s.actions[a]
        if action < 2 * n:
            move.kind = EXTEND
            move.leaf, move.sign = vertex_at[action % n], 1 if action >= n else -1
            move.first = vertex_at[s.actions[a + 1] - 2 * n]
            if s.axis[move.leaf] > 0:
                move.middle = vertex_at[s.actions[a + 2] - 2 * n]
                a, crease = a + 3, crease + 2
            else:
                move.second = vertex_at[s.actions[a + 2] - 2 * n]
                move.middle = vertex_at[s.actions[a + 3] - 2 * n]
                a, crease = a + 4, crease + 3
        elif action >= boundary_action(r):
            move.kind, move.option = SOURCE, NEXT_LEAF
            move.leaf, move.sign = s.creases[crease, 0] >> 3, s.driven[crease]
            move.first = s.creases[crease, 1] >> 3
            a, crease = a + 2, crease + 1
        elif action < 3 * n + 5:
            move.kind = SOURCE
            move.leaf, move.sign = s.creases[crease, 0] >> 3, s.driven[crease]
            move.option = (action - 3 * n - 1) // 2
            a, crease = a + 1, crease + 1
        else:
            option = action - 3 * n - 5
            move.kind = PLACE
            move.sign, move.option = 1 if option & 1 else -1, option // 2
            a, crease = a + 1, crease + r.n_driven
    return count


def table_of(states: States, rules: States, origin: States, i: int = 0) -> tuple[Moves, Points]:
    """The table of the moves that led from the start pattern in ``origin`` to state i, and its vertices' points."""
    moves = np.zeros(int(states["n_actions"][i]), dtype=MOVE)
    points = np.zeros((int(states["n_vertices"][i]), 2), dtype=np.int32)
    count = read_moves(states, i, rules, origin, moves, points)
    return moves[:count], points


@inlined
def play_noted_only(s: Record, r: Record, action: int, note: Record) -> None:
    """Play one legal action so that it can be taken back, without looking for what is legal afterwards."""
    write_note(s, r, action, note)
    play_action(s, r, action)


@bare
def source_is_legal(s: Record, r: Record, v: int, end: int) -> bool:
    """Whether a driven crease may be laid between leaf v and its mirror image across that end of the domain.

    Or between v and the next leaf.
    """
    if end == NEXT_LEAF:
        return r.sources == ON_BOUNDARY and segment_is_free(s, r, v)
    if not r.sources or r.order == 1:
        return False
    if end == 0:
        return v == s.head and source_fits(s, r, v, PREV)
    return v == tail(s) and source_fits(s, r, v, NEXT)


@bare
def lay_move(s: Record, r: Record, move: Record, points: Points, notes: Notes) -> tuple[bool, int]:
    """Lay a move of a table; returns whether that could be done, and the number of actions that were played.

    The state is as before if an action is not legal or the move does not fold as far as the rules ask
    (``min_reach``). Otherwise :func:`take_back` with the number of actions undoes it; ``notes`` has room for
    :data:`ACTIONS`.
    """
    if s.status != RUNNING:
        return False, 0
    n = board_points(r)
    bit = 1 if move.sign > 0 else 0
    if move.kind == PLACE:
        if s.phase != PLACEMENT or move.option < 0 or move.option >= r.n_placements:
            return False, 0
        picked = 0
        while picked < r.picks:
            v = move.first if picked == 0 else move.second
            x, y = points[v, 0], points[v, 1]
            if not pick_is_legal(s, r, x, y):
                take_back(s, notes, picked)
                return False, picked
            play_noted_only(s, r, 2 * n + point_index(r, x, y), notes[picked])
            picked += 1
        play_noted_only(s, r, 3 * n + 5 + 2 * move.option + bit, notes[picked])
        return True, picked + 1
    if s.phase != SELECTION:
        return False, 0
    x, y = points[move.leaf, 0], points[move.leaf, 1]
    v = leaf_at(s, x, y)
    if v < 0:
        return False, 0
    if move.kind == SOURCE:
        if not source_is_legal(s, r, v, move.option):
            return False, 0
        if move.option == NEXT_LEAF:
            w = s.next[v] >> 3
            if s.xy[w, 0] != points[move.first, 0] or s.xy[w, 1] != points[move.first, 1]:
                return False, 0
            play_noted_only(s, r, boundary_action(r) + bit, notes[0])
            play_noted_only(s, r, 2 * n + point_index(r, x, y), notes[1])
            return True, 2
        play_noted_only(s, r, 3 * n + 1 + 2 * move.option + bit, notes[0])
        return True, 1
    if not is_selectable(s, r, v) or (s.axis[v] > 0) != (move.second < 0):
        return False, 0
    play_noted_only(s, r, bit * n + point_index(r, x, y), notes[0])
    played = 1
    for child in (move.first, move.second, move.middle):
        if child < 0:
            continue
        x, y = points[child, 0], points[child, 1]
        if not location_is_legal(s, r, x, y):
            take_back(s, notes, played)
            return False, played
        play_noted_only(s, r, 2 * n + point_index(r, x, y), notes[played])
        played += 1
    if s.status == NOT_FOLDABLE:
        take_back(s, notes, played)
        return False, played
    return True, played


@bare
def replay_move(s: Record, r: Record, move: Record, points: Points) -> None:
    """Lay a move that is known to be legal and to fold."""
    n = board_points(r)
    bit = 1 if move.sign > 0 else 0
    if move.kind == PLACE:
        for v in (move.first, move.second):
            if v >= 0:
                play_action(s, r, 2 * n + point_index(r, points[v, 0], points[v, 1]))
        play_action(s, r, 3 * n + 5 + 2 * move.option + bit)
    elif move.kind == SOURCE and move.option == NEXT_LEAF:
        play_action(s, r, boundary_action(r) + bit)
        play_action(s, r, 2 * n + point_index(r, points[move.leaf, 0], points[move.leaf, 1]))
    elif move.kind == SOURCE:
        play_action(s, r, 3 * n + 1 + 2 * move.option + bit)
    else:
        play_action(s, r, bit * n + point_index(r, points[move.leaf, 0], points[move.leaf, 1]))
        for child in (move.first, move.second, move.middle):
            if child >= 0:
                play_action(s, r, 2 * n + point_index(r, points[child, 0], points[child, 1]))


@bare
def take_back(s: Record, notes: Notes, count: int) -> None:
    """Undo the last ``count`` actions, noted from ``notes[0]`` on."""
    for j in range(count - 1, -1, -1):
        restore(s, notes[j])


@inlined
def loosen(loose: Flags, move: Record) -> None:
    """Mark the vertices that lose a crease when a move goes: what grows from them goes, too."""
    if move.kind == SOURCE:
        loose[move.leaf] = 1
        if move.first >= 0:
            loose[move.first] = 1
    elif move.kind == EXTEND:
        loose[move.first] = loose[move.middle] = 1
        if move.second >= 0:
            loose[move.second] = 1


@inlined
def hangs_loose(loose: Flags, move: Record) -> bool:
    """Whether a move is about a vertex that has lost a crease."""
    if move.kind == SOURCE and move.first >= 0 and loose[move.first] != 0:
        return True
    return move.kind != PLACE and loose[move.leaf] != 0


@kernel
def lay_rest(
    states: States, i: int, rules: States, moves: Moves, points: Points, goes: Flags, notes: Notes, kept: Flags
) -> int:
    """Lay the moves that are left when some go, after what is on the board of state i; returns their number.

    A move goes, too, if its leaf loses one of the creases into it, if it is no longer legal, or if it does not fold as
    far as the rules ask. So all that stays folds as it did.

    Parameters
    ----------
    goes
        (M,) not 0 for the moves that go in any case.
    kept
        (M,) set to 1 for the moves that are laid, 0 for the others.
    """
    s, r = states[i], rules[0]
    loose = np.zeros(points.shape[0], np.int8)
    count = 0
    for m in range(moves.shape[0]):
        kept[m] = 0
        if goes[m] == 0 and not hangs_loose(loose, moves[m]):
            laid, _ = lay_move(s, r, moves[m], points, notes)
            if laid:
                kept[m] = 1
                count += 1
                continue
        loosen(loose, moves[m])
    return count
