"""A board whose cells are divided: a design of the game, laid again where its vertices can move in small steps.

Coordinates stay whole numbers, in parts of a cell, so that every planar test stays exact. The rules are the game's:
the board's edge and the maximum crease length are scaled with the coordinates, the driving angles become ten equal
steps up to the one angle that the design is used at, and all ten must be reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import ON_BOUNDARY, PANEL, States, rules_dtype, state_dtype
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_table import ACTIONS, EXTEND, MOVE, PLACE, Moves, Points, read_moves
from origami_lab.game.moves import Lay, Move
from origami_lab.game.rules import NO_LIMITS
from origami_lab.game.start_laying import empty_board

ANGLES = 10
"""Driving angles at which a design is laid, the last of them the one that it is used at."""
LARGEST_FINER = 1024
"""Most parts of a cell."""
MOST_PARTS = 13_000
"""Parts from the centre to the edge of a board: the numbers of all actions stay below 2³¹."""

# which of the four rules a move is laid under
LOOSE, EXEMPT, STRICT, EXEMPT_STRICT = 0, 1, 2, 3


class Layout(NamedTuple):
    """The moves of a design, as kernels lay them on a fine board.

    Attributes
    ----------
    moves
        (M,) rows of :data:`~origami_lab.game.move_table.MOVE`, the placement first.
    counts
        (M,) int64: representative vertices once the move is laid.
    axis
        (V,) int64: the mirror that fixes each representative vertex, 0 if none.
    corners
        Vertices of the start pattern: the first ones.
    exempt
        Moves from the first on that are exempt from the maximum crease length: those of a start pattern from a file.
    """

    moves: Moves
    counts: NDArray[np.int64]
    axis: NDArray[np.int64]
    corners: int
    exempt: int


@dataclass(frozen=True, eq=False)
class FineBoard:
    """A design of a game on a board with ``finer`` parts a cell.

    Attributes
    ----------
    game
        The game that it was made in.
    finer
        Parts of a cell.
    layout
        Its moves.
    points
        (V, 2) int32: its representative vertices in parts of a cell, as the game had them.
    rules
        (4,) rules on this board, without and with collisions, each for the game and for exempt moves:
        :data:`LOOSE`, :data:`EXEMPT`, :data:`STRICT`, :data:`EXEMPT_STRICT`. Their driving angles are the caller's.
    """

    game: Game
    finer: int
    layout: Layout
    points: Points
    rules: States

    def new_states(self, count: int = 1) -> States:
        """States to lay on; rows are written before they are read."""
        return np.empty(count, dtype=state_dtype(self.game.rules.capacity, ANGLES))

    def new_notes(self) -> NDArray[np.void]:
        """What the kernels need to lay one move."""
        return np.zeros(ACTIONS, dtype=note_dtype(ANGLES))

    def renumbered(self, kept: NDArray[np.int8], states: States) -> FineBoard | None:
        """The board with the moves that are left of its design, which a state was laid with; None if none extends.

        Parameters
        ----------
        kept
            (M,) not 0 for the moves that are left.
        """
        s = states[0]
        count = int(s["n_vertices"])
        number = {(int(x), int(y)): v for v, (x, y) in enumerate(s["xy"][:count])}
        # vertices that no move is left of get no number, and are not asked for
        new = np.array([number.get((int(x), int(y)), -1) for x, y in self.points] + [-1], dtype=np.int32)
        moves = self.layout.moves[kept != 0].copy()
        for name in ("leaf", "first", "second", "middle"):
            moves[name] = new[moves[name]]
        if not (moves["kind"] == EXTEND).any():
            return None
        layout = Layout(
            moves=moves,
            counts=_counts(moves, self.layout.corners),
            axis=s["axis"][:count].astype(np.int64),
            corners=self.layout.corners,
            exempt=int(np.count_nonzero(kept[: self.layout.exempt])),
        )
        return replace(self, layout=layout, points=s["xy"][:count].copy())


def fine_board(game: Game, actions: Sequence[int], finer: int) -> FineBoard:
    """The design that legal actions make, on a board with ``finer`` parts a cell.

    Raises
    ------
    InputError
        If the board would be too fine for whole numbers, or the design has no extension to move.
    """
    if isinstance(finer, bool) or not isinstance(finer, int) or not 1 <= finer <= LARGEST_FINER:
        raise InputError("finer", finer, f"must be a whole number from 1 to {LARGEST_FINER}: the parts of a cell")
    finer = min(finer, MOST_PARTS // max(game.rules.half))
    states = game.replay(actions)
    if int(states["n_extensions"][0]) == 0:
        raise InputError("design", "the start pattern alone", "must have an extension: there is nothing to move")
    room = int(states["n_actions"][0]) + 1
    moves, points = np.zeros(room, dtype=MOVE), np.zeros((int(states["n_vertices"][0]), 2), dtype=np.int32)
    count = int(read_moves(states, 0, game.rules.record, empty_board(game.rules), moves, points))
    moves = moves[:count].copy()
    assert moves["kind"][0] == PLACE
    moves["option"][0] = 0  # a fine board's start pattern is where its corners are
    corners = game.corners
    layout = Layout(
        moves=moves,
        counts=_counts(moves, corners),
        axis=states["axis"][0][: len(points)].astype(np.int64),
        corners=corners,
        exempt=len(game.start_moves),
    )
    return FineBoard(game, finer, layout, points * np.int32(finer), _fine_rules(game, finer, game.moves(actions)[0]))


def _counts(moves: Moves, corners: int) -> NDArray[np.int64]:
    """(M,) vertices once each move is laid: a child of a number that is not there yet is added."""
    counts, known = np.zeros(len(moves), dtype=np.int64), corners
    for m, move in enumerate(moves):
        if move["kind"] == EXTEND:
            known += sum(int(move[name]) >= known for name in ("first", "second", "middle"))
        counts[m] = known
    return counts


def _fine_rules(game: Game, finer: int, placement: Move) -> States:
    rules = np.zeros(4, dtype=rules_dtype(ANGLES))
    own = game.rules.record[0]
    scaled = (
        "min_length_sq",
        "min_width_sq",
        "half_x",
        "half_y",
        "max_length_sq",
        "first_placement",
        "n_placements",
        "angles",
        "min_reach",
    )
    for name in rules.dtype.names or ():
        if name not in scaled:
            rules[name] = own[name]
    rules["half_x"], rules["half_y"] = (half * finer for half in game.rules.half)
    if isinstance(placement, Lay):  # whatever it was chosen from, here it is given
        count = len(placement.corners)
        rules["start"], rules["picks"], rules["n_corners"] = PANEL, 0, count
        rules["n_driven"] = np.count_nonzero(placement.signs)
        rules["corners"][:, :count] = np.array(placement.corners) * finer
        rules["sides"][:, :count] = placement.signs
    rules["min_reach"] = ANGLES
    rules["max_length_sq"] = (float(own["max_length_sq"]) - 1e-9) * finer**2 + 1e-9
    for name in ("min_length_sq", "min_width_sq"):
        rules[name] = float(own[name]) * finer**2
    exempt = [EXEMPT, EXEMPT_STRICT]
    rules["sources"][exempt] = ON_BOUNDARY
    for name, value in NO_LIMITS.items():
        rules[name][exempt] = value
    rules["straight_sectors"][exempt] = 1
    rules["collisions"][[LOOSE, EXEMPT]] = 0
    return rules
