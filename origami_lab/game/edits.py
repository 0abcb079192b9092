"""Changes of a design that was played: vertices cut off or moved, and the rest laid again as far as it is legal.

What a change costs follows from the rules alone: a move goes if its leaf loses one of the creases into it, if it is no
longer legal, or if it does not fold as far as the game asks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import step
from origami_lab.game.kernels.state import SELECTION, States
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_table import ACTIONS, EXTEND, Moves, Points, lay_rest, table_of
from origami_lab.game.moves import Point


def start_vertices(game: Game, actions: Sequence[int]) -> int:
    """How many representative vertices the start pattern of a design has; they come first in its state."""
    states, legal = game.new_states(1), np.empty(game.rules.max_legal, dtype=np.int32)
    for action in actions[len(game.start_actions) :]:
        if int(states["phase"][0]) == SELECTION:
            break
        step(states, 0, game.rules.record, int(action), legal)
    return int(states["n_vertices"][0])


def without_vertices(game: Game, actions: Sequence[int], vertices: Iterable[Point]) -> tuple[int, ...]:
    """The actions that are left when vertices lose their extensions, and so all that grew from them.

    A vertex that was never extended takes the extension with it that placed it. Any image of a vertex will do.

    Raises
    ------
    InputError
        If one is no vertex of the design, or the start pattern has placed it and nothing extends it.
    """
    table, points = _table(game, actions)
    goes = np.zeros(len(table), dtype=np.int8)
    own = start_vertices(game, actions)
    for point in vertices:
        v = _vertex_at(game, points, point)
        extended = (table["kind"] == EXTEND) & (table["leaf"] == v)
        if not extended.any():
            if v < own:
                raise InputError("vertex", list(point), "belongs to the start pattern, and nothing grows from it yet")
            children = np.stack([table[name] for name in ("first", "second", "middle")], axis=1)
            extended = (table["kind"] == EXTEND) & (children == v).any(axis=1)
        goes[extended] = 1
    return _laid_again(game, table, points, goes)


def with_vertex_moved(game: Game, actions: Sequence[int], vertex: Point, to: Point) -> tuple[int, ...]:
    """The actions of the design with one vertex, and its images, elsewhere on the board, as far as it still folds.

    Raises
    ------
    InputError
        If there is no such vertex, the start pattern has placed it, or the place is not on the board.
    """
    table, points = _table(game, actions)
    v, half = _vertex_at(game, points, vertex), game.rules.half
    if v < start_vertices(game, actions):
        raise InputError("vertex", list(vertex), "belongs to the start pattern: only what grew from it can be moved")
    matrices = game.symmetry.matrices
    image = next(m for m in matrices if (m @ np.array(vertex) == points[v]).all())
    x, y = (int(t) for t in image @ np.array(to))
    if abs(x) > half[0] or abs(y) > half[1]:
        raise InputError("place", list(to), "must be on the board")
    points = points.copy()
    points[v] = x, y
    return _laid_again(game, table, points, np.zeros(len(table), dtype=np.int8))


def _table(game: Game, actions: Sequence[int]) -> tuple[Moves, Points]:
    states: States = game.replay(actions)
    return table_of(states, game.rules.record, game.new_states(1))


def _vertex_at(game: Game, points: Points, point: Point) -> int:
    """The representative whose image lies at a board point."""
    images = game.symmetry.matrices @ np.array(point, dtype=np.int64)
    found = np.flatnonzero((points[:, None, :] == images[None, :, :]).all(axis=2).any(axis=1))
    if not len(found):
        raise InputError("vertex", list(point), "there is no vertex of the design here")
    return int(found[0])


def _laid_again(game: Game, table: Moves, points: Points, goes: NDArray[np.int8]) -> tuple[int, ...]:
    states, kept = game.new_states(1), np.zeros(len(table), dtype=np.int8)
    notes = np.empty(ACTIONS, dtype=note_dtype(len(game.angles)))
    lay_rest(states, 0, game.rules.record, table, points, goes, notes, kept)
    return game.finished_actions(states)
