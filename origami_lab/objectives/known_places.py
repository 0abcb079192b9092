"""How far places in space stray from the target; what was found out is kept, as searches come back to the same places.

A branch-and-bound search lays the children of a node again whenever it is there, and of many designs only the last
vertices differ. Of the places that BFTS asks for, more than nine of ten were asked for before, to the last bit; of
those of random play and of EVO about half.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.bvh import Bvh, inside
from origami_lab.geometry.wide_tree import WideTree, nearest_row
from origami_lab.jit import bare, inlined

Array = NDArray[np.float64]

SLOTS = 1 << 14
"""Places that are remembered; a new one takes the slot of an old one, so that memory stays what it is."""

X, Y, Z, LOW, HIGH = range(5)
"""Of a place: where it is, and between what its squared distance lies; the same twice where it is known."""


class Surface(NamedTuple):
    """A target as :func:`~.shape_kernels.stray` measures it.

    Attributes
    ----------
    tree
        What distances are measured to: its triangles, or points drawn on them.
    hull
        Its triangles.
    solid
        Vertices inside the closed target do not stray.
    images
        Whether to measure all images of a vertex; not needed where the target has the game's symmetry.
    compactness
        Weight of the penalty on the vertex that is furthest from the board's centre, 0 for none.
    known
        (SLOTS, 5) what was found out about places, see :func:`nothing_known`. It changes no result.
    """

    tree: WideTree
    hull: Bvh
    solid: bool
    images: bool
    compactness: float
    known: Array


def nothing_known() -> Array:
    """Room for what is found out about places."""
    return np.full((SLOTS, HIGH + 1), np.nan)


@inlined
def slot_of(x: float, y: float, z: float) -> int:
    """Where a place is remembered: by all bits of its coordinates, as images of it differ in their signs alone."""
    a, b, c = np.float64(x).view(np.int64), np.float64(y).view(np.int64), np.float64(z).view(np.int64)
    key = ((a ^ (a >> 29)) << 5) ^ b ^ (b >> 31)
    key = (key << 7) ^ c ^ (c >> 27)
    key ^= key >> 32
    key ^= key >> 15
    return int(key & (SLOTS - 1))


@bare
def strayed_squared(
    target: Surface, x: float, y: float, z: float, enough_sq: float, start_sq: float, near: int, far: Array
) -> tuple[float, int]:
    """The squared distance from (x, y, z) to the target, 0 inside a solid one, and what it is nearest to.

    Parameters
    ----------
    enough_sq, start_sq
        As in :func:`~origami_lab.geometry.bvh.nearest_squared`: where the squared distance is not above ``enough_sq``,
        any number that is not either is returned, and nothing above ``start_sq``.
    near, far
        As in :func:`~origami_lab.geometry.wide_tree.nearest_row`.
    """
    known, slot = target.known, slot_of(x, y, z)
    low, high = 0.0, np.inf
    if known[slot, X] == x and known[slot, Y] == y and known[slot, Z] == z:
        low, high = known[slot, LOW], known[slot, HIGH]
        if high <= enough_sq or (low == high and high < start_sq):
            return high, near
        if low >= start_sq:
            return start_sq, near
    else:
        known[slot, X], known[slot, Y], known[slot, Z] = x, y, z
    squared, near = nearest_row(target.tree, x, y, z, enough_sq, start_sq, near, far)
    if squared <= enough_sq:
        high = squared
    elif target.solid and inside(target.hull, x, y, z):
        low = high = squared = 0.0
    elif squared < start_sq:
        low = high = squared
    else:
        low = start_sq
    known[slot, LOW], known[slot, HIGH] = low, high
    return squared, near
