"""Taking an action back: what it will overwrite is noted before it is played.

A game only adds vertices, panels and creases, and a placed vertex never moves. So an action overwrites a handful of
numbers and, when it completes a move, the rows of a leaf and of its two neighbours on the boundary. A depth-first
search keeps one state and a stack of notes where it would otherwise copy the state at every depth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import tail
from origami_lab.game.kernels.play import Actions, leaf_at, play_action, settle
from origami_lab.game.kernels.state import (
    PLACEMENT,
    SCALARS,
    SELECTION,
    THIRD,
    Record,
    States,
    board_points,
    copy_scalars,
    point_x,
    point_y,
)
from origami_lab.jit import bare, inlined

Notes = NDArray[np.void]
"""Array of notes: element d holds what the action played at depth d overwrote."""

ROWS = 3
"""Rows of vertices that one action may overwrite."""


def note_dtype(angles: int = 10) -> np.dtype[np.void]:
    """Layout of a note for states at ``angles`` driving angles."""
    fields: list[tuple[str, type[np.generic]] | tuple[str, type[np.generic], tuple[int, ...]]] = [
        *((name, np.int32) for name in SCALARS),
        ("n_rows", np.int32),
        ("rows", np.int32, (ROWS,)),
        *((name, np.int32, (ROWS,)) for name in ("prev", "next", "first", "last")),
        ("modes", np.int8, (ROWS,)),
        ("locked", np.int8, (ROWS,)),
        ("frame_prev", np.float64, (ROWS, angles, 6)),
        ("frame_next", np.float64, (ROWS, angles, 6)),
    ]
    return np.dtype((np.record, np.dtype(fields, align=True)))


@inlined
def copy_row(target: Record, i: int, source: Record, v: int, reach: int) -> None:
    """Copy what an action may overwrite of one row, between a state and a note."""
    target.prev[i], target.next[i] = source.prev[v], source.next[v]
    target.first[i], target.last[i] = source.first[v], source.last[v]
    target.modes[i], target.locked[i] = source.modes[v], source.locked[v]
    for k in range(reach):
        for j in range(6):
            target.frame_prev[i, k, j] = source.frame_prev[v, k, j]
            target.frame_next[i, k, j] = source.frame_next[v, k, j]


@bare
def write_note(s: Record, r: Record, action: int, note: Record) -> None:
    """Note what playing a legal action will overwrite."""
    copy_scalars(note, s)
    note.n_rows = 0
    if s.phase == THIRD:
        v = s.selected
        note.rows[0], note.rows[1], note.rows[2] = v, s.prev[v] >> 3, s.next[v] >> 3
        note.n_rows = 3
    elif s.phase == PLACEMENT and s.n_vertices > 0:
        points = board_points(r)
        v = leaf_at(s, point_x(r, action - 2 * points), point_y(r, action - 2 * points))
        note.rows[0], note.rows[1] = v, s.next[v] >> 3
        note.n_rows = 2
    elif s.phase == SELECTION and action > 3 * board_points(r):
        # a source is laid beside the first leaf or the last one
        note.rows[0], note.rows[1] = s.head, tail(s)
        note.n_rows = 2
    for i in range(note.n_rows):
        copy_row(note, i, s, note.rows[i], note.reach)


@bare
def restore(s: Record, note: Record) -> None:
    """Bring a state back to where the note was written."""
    copy_scalars(s, note)
    for i in range(note.n_rows):
        copy_row(s, note.rows[i], note, i, note.reach)


@bare
def play_noted(s: Record, r: Record, action: int, note: Record, legal: Actions) -> int:
    """Play one legal action so that :func:`restore` takes it back; returns how many are legal afterwards."""
    write_note(s, r, action, note)
    play_action(s, r, action)
    return settle(s, r, legal)


@bare
def step_noted(
    states: States, i: int, rules: States, action: int, notes: Notes, depth: int, legal: Actions
) -> tuple[int, bool]:
    """:func:`play_noted` for state i, noted at ``depth``; also returns whether the move is complete."""
    n = play_noted(states[i], rules[0], action, notes[depth], legal)
    return n, states[i].phase == SELECTION


@bare
def step_back(states: States, i: int, notes: Notes, depth: int) -> None:
    """Take back the action of state i that was noted at ``depth``."""
    restore(states[i], notes[depth])
