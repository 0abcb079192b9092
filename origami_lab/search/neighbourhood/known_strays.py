"""What was tried and found to stray, so that nothing is paid for twice.

Where a child comes to lie, and the panel that it completes, depend on the leaf as it is folded, on the children chosen
before and on its own board point, never on the rest of the sheet. The same leaves come back whenever a design is laid
and grown again, and in run after run. So a place is known by these alone, and what strays under one threshold does so
under every lower one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV
from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.legal_actions import placing_side
from origami_lab.game.kernels.state import THIRD, Record
from origami_lab.jit import bare, inlined

SLOTS = 1 << 18
"""Places that are remembered; a new one takes the slot of an old one, so that memory stays what it is."""

FINENESS = 2.0**42
"""Parts of a board cell that places in space are told apart by."""


class KnownStrays(NamedTuple):
    """Places that were found to stray.

    Attributes
    ----------
    keys
        (SLOTS,) int64, which place is in a slot.
    thresholds
        (SLOTS,) the highest threshold that it is known to stray beyond.
    """

    keys: NDArray[np.int64]
    thresholds: NDArray[np.float64]


def nothing_known() -> KnownStrays:
    return KnownStrays(np.zeros(SLOTS, dtype=np.int64), np.full(SLOTS, -np.inf))


@inlined
def mixed(key: np.int64, number: np.int64) -> np.int64:
    """A key with one more number in it: a step of a xorshift generator, which no sum overflows."""
    key = key ^ number
    key = key ^ (key << 13)
    key = key ^ (key >> 7)
    return key ^ (key << 17)


@inlined
def mixed_place(key: np.int64, p: NDArray[np.float64], row: int) -> np.int64:
    for j in range(3):
        key = mixed(key, np.int64(p[row, j] * FINENESS))
    return key


@bare
def list_key(s: Record, r: Record, k: int) -> np.int64:
    """The key of all that decides where the child that is placed now comes to lie, save for its board point."""
    v = s.selected
    key = mixed(np.int64(k + 1), np.int64(s.phase == THIRD))
    key = mixed(mixed(key, np.int64(s.xy[v, 0])), np.int64(s.xy[v, 1]))
    p = s.triangle
    place_corner(s, r, 8 * v, k, p, 0)
    key = mixed_place(key, p, 0)
    side = placing_side(s, r)
    if s.phase == THIRD or side == PREV:
        place_corner(s, r, s.prev[v], k, p, 1)
        key = mixed_place(key, p, 1)
        for j in range(6):
            key = mixed(key, np.int64(s.frame_prev[v, k, j] * FINENESS))
    if s.phase == THIRD or side == NEXT:
        place_corner(s, r, s.next[v], k, p, 2)
        key = mixed_place(key, p, 2)
        for j in range(6):
            key = mixed(key, np.int64(s.frame_next[v, k, j] * FINENESS))
    if s.phase == THIRD:
        key = mixed(key, np.int64(s.mode))
        for coordinate in (s.first_x, s.first_y, s.second_x, s.second_y):
            key = mixed(key, np.int64(coordinate))
    return key


@inlined
def is_known(known: KnownStrays, key: np.int64, threshold: float) -> bool:
    """Whether a place strays beyond the threshold for all that is known."""
    slot = key & (SLOTS - 1)
    return bool(known.keys[slot] == key and threshold <= known.thresholds[slot])


@inlined
def learn(known: KnownStrays, key: np.int64, threshold: float) -> None:
    """Remember that a place strays beyond the threshold."""
    slot = key & (SLOTS - 1)
    if known.keys[slot] != key:
        known.keys[slot], known.thresholds[slot] = key, threshold
    else:
        known.thresholds[slot] = max(known.thresholds[slot], threshold)
