"""How far a design's motion goes, between the game's driving angles too, what ends it, and which panels meet there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import replay_unchecked
from origami_lab.game.rules import Rules
from origami_lab.game.start_laying import empty_board
from origami_lab.geometry.triangles import CONTACT_TOLERANCE, triangles_cross

End = Literal["collides", "closes", "whole"]
BESIDE = 0.01
"""Degrees. Exactly where a vertex is folded flat, rounding decides whether it closes: so much beside it does not."""
NONE_MEET = np.empty((0, 3), dtype=np.int64)


@dataclass(frozen=True)
class MotionEnd:
    """The end of a motion."""

    free_to: float
    """Largest driving angle up to which the design folds without collisions, degrees."""
    ends: End
    """``collides`` if panels meet then, ``closes`` if a vertex no longer closes, ``whole`` if nothing ends it before
    the game's own largest angle."""
    meeting: NDArray[np.int64]
    """(n, 3) triangles of the sheet, as rows of its vertices, that pass through others just behind the end."""


def motion_end(game: Game, actions: Sequence[int]) -> MotionEnd:
    """The end of a design's motion, looked at in tenths of a degree and at the game's own driving angles."""
    motion = _Motion(game.rules.for_start_pattern(shortest_motion=True), actions)
    most = math.degrees(float(game.angles[-1]))
    reached = math.degrees(float(game.angles[int(game.replay(actions)["reach"][0]) - 1]))
    tenths, at = np.arange(1, math.floor(10 * most + 1e-6) + 1) / 10, 0
    while True:
        at += motion.free(np.radians(tenths[at : at + motion.most]))
        if at >= len(tenths):
            return MotionEnd(most, "whole", NONE_MEET)
        if motion.free(np.radians(tenths[at : at + 1])):  # the end of what was looked at at once
            continue
        if not all(motion.free(np.radians([tenths[at] + beside])) for beside in (-BESIDE, BESIDE)):
            break
        at += 1
    end, free = float(tenths[at]), float(tenths[at - 1]) if at else 0.0
    free = reached if free < reached < end + 1e-9 else free  # the game has looked there itself
    sheets = [motion.sheet_at(math.radians(end + beyond)) for beyond in (0.0, BESIDE, 10 * BESIDE)]
    closing = [_meeting(sheet) for sheet in sheets if sheet is not None]
    return MotionEnd(free, "collides" if closing else "closes", next(filter(len, closing), NONE_MEET))


def closing_angles(game: Game, actions: Sequence[int], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Those of some driving angles, within what legal actions reach, at which rounding has every vertex close."""
    motion, found, at = _Motion(game.rules.replaced(min_reach=1, collisions=0), actions), list[float](), 0
    while at < len(angles):
        free = motion.free(angles[at : at + motion.most])
        found += angles[at : at + free].tolist()
        at += max(free, 1)
    return np.array(found)


class _Motion:
    """Known-legal actions at any driving angles."""

    def __init__(self, rules: Rules, actions: Sequence[int]) -> None:
        self._record, self._states = rules.record.copy(), empty_board(rules)
        self._log = np.array(actions, dtype=np.int32)
        self.most = len(rules.angles)
        """Driving angles that are looked at at once."""

    def free(self, angles: NDArray[np.float64]) -> int:
        """At how many of some driving angles, from the first on, they fold."""
        self._record["angles"][0] = np.concatenate([angles, np.full(self.most - len(angles), angles[-1])])
        return min(int(replay_unchecked(self._states, 0, self._record, self._log)), len(angles))

    def sheet_at(self, angle: float) -> FoldedSheet | None:
        """The sheet at a driving angle, whatever passes through each other; None where a vertex does not close."""
        kept = int(self._record["collisions"][0])
        self._record["collisions"] = 0
        closes = self.free(np.array([angle]))
        self._record["collisions"] = kept
        return FoldedSheet(self._states.copy(), 0, self._record) if closes else None


def _meeting(sheet: FoldedSheet) -> NDArray[np.int64]:
    """The triangles that pass through others, by the game's own rule: of two with a common side none does."""
    triangles = sheet.triangles
    corners = np.ascontiguousarray(sheet.points[0][triangles])  # (T, 3, 3)
    low, high = corners.min(axis=1), corners.max(axis=1)
    found = set[int]()
    for t, corner in enumerate(corners[:-1]):
        near = ((low[t + 1 :] <= high[t]) & (high[t + 1 :] >= low[t])).all(axis=1)
        near &= np.isin(triangles[t + 1 :], triangles[t]).sum(axis=1) < 2
        for other in np.flatnonzero(near) + t + 1:
            if triangles_cross(corner, corners[other], CONTACT_TOLERANCE):
                found |= {t, int(other)}
    return triangles[sorted(found)].astype(np.int64)
