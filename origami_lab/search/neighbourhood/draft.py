"""The design of a run as compiled code holds it, and where a run is between two looks from Python."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import States
from origami_lab.game.move_table import MOVE, Flags, Moves, Points
from origami_lab.search.neighbourhood.one_run import RunDesign

COURSE = np.dtype(
    (
        np.record,
        np.dtype(
            [
                # what is under way: one of BETWEEN, GROWING, GROWN (improving.py)
                ("phase", np.int64),
                # interactions played in all, those there may be, those before the change that is under way
                *((name, np.int64) for name in ("interactions", "budget", "before")),
                ("looked", np.int64),  # places whose closed form was evaluated, since Python asked last
                ("idle", np.int64),  # changes in a row that came to nothing at all
                ("lowest", np.int64),  # fewest samples that a scored design left uncovered
                ("laid", np.int64),  # vertices of the start pattern that was placed last
                # of the run's design: whether it has one; its rows; vertices that the start pattern has laid
                *((name, np.int64) for name in ("has_design", "n_moves", "n_points", "n_uncovered", "own")),
                # of the growth under way: samples uncovered before it and now, moves that failed in a row, its number
                *((name, np.int64) for name in ("rest", "left", "failed", "again")),
                ("best", np.int64),  # fewest uncovered samples of the growths of this change
            ],
            align=True,
        ),
    )
)
"""Layout of what changes from call to call."""

Course = NDArray[np.void]
"""(1,) array of :data:`COURSE`."""


class Draft(NamedTuple):
    """The design of a run, in arrays that have room for any; :data:`COURSE` says how many rows are its.

    Attributes
    ----------
    moves, points, places, uncovered
        As those of :class:`~.one_run.RunDesign`.
    best_uncovered
        The same as ``uncovered`` for the best growth of a change.
    goes
        Written to while the design is laid again: for each move whether it is cut away.
    """

    moves: Moves
    points: Points
    places: NDArray[np.float64]
    uncovered: NDArray[np.int32]
    best_uncovered: NDArray[np.int32]
    goes: Flags


def new_draft(states: States, samples: int) -> Draft:
    """Room for any design on states like these, with so many samples to be covered."""
    moves, vertices = states["actions"].shape[1], states["xy"].shape[1]
    return Draft(
        np.zeros(moves, dtype=MOVE),
        np.zeros((vertices, 2), dtype=np.int32),
        np.zeros((vertices, 3)),
        np.zeros(samples, dtype=np.int32),
        np.zeros(samples, dtype=np.int32),
        np.zeros(moves, dtype=np.int8),
    )


def write_design(design: RunDesign | None, draft: Draft, course: Course) -> None:
    """Make it the design of the run."""
    course["has_design"] = design is not None
    if design is None:
        return
    pairs = (design.moves, draft.moves), (design.points, draft.points), (design.places, draft.places)
    for given, room in (*pairs, (design.uncovered, draft.uncovered)):
        room[: len(given)] = given
    course["n_moves"], course["n_points"] = len(design.moves), len(design.points)
    course["n_uncovered"], course["own"] = len(design.uncovered), design.own


def read_design(draft: Draft, course: Course) -> RunDesign:
    """The design of the run."""
    moves, points, uncovered, own = (int(course[name][0]) for name in ("n_moves", "n_points", "n_uncovered", "own"))
    return RunDesign(
        moves=draft.moves[:moves].copy(),
        points=draft.points[:points].copy(),
        places=draft.places[:points].copy(),
        own=own,
        uncovered=draft.uncovered[:uncovered].copy(),
    )
