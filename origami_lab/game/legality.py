"""Why a leaf cannot be extended, or a child not lie at a place: one reason of a closed list, in a sentence.

The masks of legal actions and these answers are one computation: an action is legal exactly where there is no reason.
What only the motion tells comes after: a legal extension may collide or not close at one of the driving angles.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels import reasons as why
from origami_lab.game.kernels.legal_actions import leaf_reason, reason_at
from origami_lab.game.kernels.play import leaf_at
from origami_lab.game.kernels.reached_angles import reach_of_places
from origami_lab.game.kernels.state import FIRST, SECOND, THIRD, States
from origami_lab.game.moves import Point


class Reason(IntEnum):
    """A rule that refuses something; :attr:`says` is its sentence."""

    ON_THE_LEAF = why.ON_THE_LEAF
    OFF_THE_BOARD = why.OFF_THE_BOARD
    IN_ANOTHER_IMAGE = why.IN_ANOTHER_IMAGE
    OUT_OF_ORDER = why.OUT_OF_ORDER
    TOO_LONG = why.TOO_LONG
    TOO_SHORT = why.TOO_SHORT
    OVER_THE_SHEET = why.OVER_THE_SHEET
    HALF_TURN_OR_MORE = why.HALF_TURN_OR_MORE
    STRAIGHT_AND_STIFF = why.STRAIGHT_AND_STIFF
    TOO_SHARP = why.TOO_SHARP
    NO_ROOM_BESIDE = why.NO_ROOM_BESIDE
    MERGES_WITH_IMAGE = why.MERGES_WITH_IMAGE
    ON_A_MIRROR = why.ON_A_MIRROR
    OFF_THE_MIRROR = why.OFF_THE_MIRROR
    ALONG_THE_BOUNDARY = why.ALONG_THE_BOUNDARY
    TOO_NARROW = why.TOO_NARROW
    CROSSES = why.CROSSES
    COVERS_A_CORNER = why.COVERS_A_CORNER
    TRIANGLE_INEQUALITY = why.TRIANGLE_INEQUALITY
    OPENS_THE_OTHER_WAY = why.OPENS_THE_OTHER_WAY
    NOT_BETWEEN = why.NOT_BETWEEN
    AT_THE_EDGE = why.AT_THE_EDGE
    ON_TWO_MIRRORS = why.ON_TWO_MIRRORS
    CLOSED_SECTOR = why.CLOSED_SECTOR
    WITHOUT_CREASE = why.WITHOUT_CREASE
    STRAIGHT_SECTOR = why.STRAIGHT_SECTOR
    NO_SIDE_OPEN = why.NO_SIDE_OPEN
    COLLIDES = why.COLLIDES
    DOES_NOT_CLOSE = why.DOES_NOT_CLOSE
    NO_LEAF = why.NO_LEAF

    @property
    def says(self) -> str:
        """The reason as a short sentence, without its full stop."""
        return _SAYS[self]


_SAYS = {
    Reason.ON_THE_LEAF: "this is the leaf itself",
    Reason.OFF_THE_BOARD: "outside the board",
    Reason.IN_ANOTHER_IMAGE: "beyond the mirror axis: place its image on the leaf's own side",
    Reason.OUT_OF_ORDER: "creases come one after the other round the leaf: this lies before the one placed last",
    Reason.TOO_LONG: "longer than max_crease_length",
    Reason.TOO_SHORT: "shorter than min_crease_length",
    Reason.OVER_THE_SHEET: "new creases leave on the outside of the sheet",
    Reason.HALF_TURN_OR_MORE: "a sector of 180° or more, in which nothing could fold",
    Reason.STRAIGHT_AND_STIFF: "a sector of exactly 180°, and this vertex does not fold along one straight line",
    Reason.TOO_SHARP: "a sharper corner than min_sector_angle",
    Reason.NO_ROOM_BESIDE: "leaves no room for the other creases",
    Reason.MERGES_WITH_IMAGE: "would merge with the leaf's own mirror image",
    Reason.ON_A_MIRROR: "on a mirror axis, where it would meet its own image",
    Reason.OFF_THE_MIRROR: "the middle crease of a leaf on a mirror axis lies on that axis",
    Reason.ALONG_THE_BOUNDARY: "along the boundary, beyond its next vertex",
    Reason.TOO_NARROW: "makes a panel narrower than min_panel_width",
    Reason.CROSSES: "crosses or touches the sheet's boundary",
    Reason.COVERS_A_CORNER: "its panel would lie over another part of the sheet",
    Reason.TRIANGLE_INEQUALITY: "the three sectors break the triangle inequality: the vertex could not fold",
    Reason.OPENS_THE_OTHER_WAY: "in this mode the motion would not begin at the flat sheet: take the other mode",
    Reason.NOT_BETWEEN: "the middle crease lies between the outer two, less than 180° from each",
    Reason.AT_THE_EDGE: "on the edge of the board",
    Reason.ON_TWO_MIRRORS: "on two mirror axes at once",
    Reason.CLOSED_SECTOR: "it has a sector of 180° or more, in which nothing could fold",
    Reason.WITHOUT_CREASE: "no crease leads to it yet",
    Reason.STRAIGHT_SECTOR: "it has a sector of exactly 180°, and does not fold along one straight line",
    Reason.NO_SIDE_OPEN: "180° or more lie between its creases and the boundary",
    Reason.COLLIDES: "panels collide",
    Reason.DOES_NOT_CLOSE: "the vertex no longer closes (triangle inequality)",
    Reason.NO_LEAF: "there is no leaf here",
}


def why_not_leaf(game: Game, states: States, leaf: Point, i: int = 0) -> Reason | None:
    """Why the leaf at a playable point cannot be extended; None if it can, in a state between two moves."""
    v = int(leaf_at(states[i], *leaf)) if int(states["n_vertices"][i]) else -1
    return Reason.NO_LEAF if v < 0 else _named(leaf_reason(states[i], game.rules.record[0], v))


def why_not_place(game: Game, states: States, place: Point, i: int = 0) -> Reason | None:
    """Why the child that is placed now may not lie at a point; None if that is a legal action.

    Raises
    ------
    ValueError
        If no child is being placed.
    """
    if int(states["phase"][i]) not in (FIRST, SECOND, THIRD):
        raise ValueError("no child is being placed: first a leaf is selected")
    return _named(reason_at(states[i], game.rules.record[0], *place))


def reaches(game: Game, states: States, actions: NDArray[np.int32], i: int = 0) -> NDArray[np.int32]:
    """How many driving angles, from flat up, the motion reaches after each of the legal places of a middle child.

    Those below ``game.first_angle + 1`` are refused: the sheet would not fold.
    """
    out = np.empty(len(actions), dtype=np.int32)
    record = game.rules.replaced(min_reach=0).record
    reach_of_places(states, i, game.new_states(1), record, np.ascontiguousarray(actions), out)
    return out


def why_no_further(game: Game, states: States, action: int, i: int = 0) -> tuple[Reason | None, int]:
    """What ends the motion after a legal place of a middle child, and how many driving angles it reaches.

    The reason is None if it reaches as many as before.
    """
    actions, free = np.array([action], dtype=np.int32), np.empty(1, dtype=np.int32)
    reached = int(reaches(game, states, actions, i)[0])
    if reached == int(states["reach"][i]):
        return None, reached
    record = game.rules.replaced(min_reach=0, collisions=0).record
    reach_of_places(states, i, game.new_states(1), record, actions, free)
    return Reason.COLLIDES if int(free[0]) > reached else Reason.DOES_NOT_CLOSE, reached


def _named(reason: int) -> Reason | None:
    return Reason(reason) if reason != why.FITS else None
