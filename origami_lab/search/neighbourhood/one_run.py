"""What a run of the search holds between two changes of its design."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.move_table import Moves, Points

NONE_YET = 1 << 60
"""A number of uncovered samples that every design improves on."""


@dataclass(frozen=True)
class RunDesign:
    """A design that can be changed and laid again.

    Attributes
    ----------
    moves, points
        Its table (:mod:`origami_lab.game.move_table`).
    places
        (V, 3) its vertices folded to the run's driving angle, in board cells.
    own
        Number of vertices that the start pattern has laid; they are the first ones.
    uncovered
        (U,) the samples of the target that it does not cover; empty where no coverage is asked for.
    """

    moves: Moves
    points: Points
    places: NDArray[np.float64]
    own: int
    uncovered: NDArray[np.int32]


@dataclass
class LocalRun:
    """One of the searches that compete.

    Attributes
    ----------
    angle
        Index of its driving angle; smaller ones are scored, too.
    wide
        Whether it tries more places for each child than others.
    threshold
        The distance it is to reach, in board cells.
    design
        Where it stands; None before its first one.
    value
        Its best return.
    lowest
        Fewest samples that a scored design left uncovered at this threshold.
    last
        Interactions when it was last successful.
    idle
        Changes in a row that came to nothing at all.
    accepted
        Without coverage: the returns of the designs it has stood at lately, the present one last.
    """

    angle: int
    wide: bool = False
    threshold: float = math.inf
    design: RunDesign | None = None
    value: float = -math.inf
    lowest: int = NONE_YET
    last: int = 0
    idle: int = 0
    accepted: deque[float] = field(default_factory=deque)
