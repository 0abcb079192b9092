"""Measures of a part's shape that decide what can be expected: how it bends, and what lies under something else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from origami_lab.parts.flat_region import FlatRegion
from origami_lab.parts.frame import PartFrame, is_flat_faced
from origami_lab.parts.surface import Array, PartSurface

PLUMB_LINES = 1000
MOST_TESTS = 20_000_000
"""Pairs of a line and a triangle, at most."""
BESIDE = 1e-6
"""Of a triangle: what meets it so near to its sides is beside it."""
SHARP = np.radians(40.0)
"""Radians: neighbours that meet at more are an edge, not a bend."""


@dataclass(frozen=True, eq=False)
class Curvature:
    """How much of a surface bends how tightly."""

    radii: Array
    """(n,) radii of curvature across edges of the mesh, ascending, units of the file; infinite where it is flat."""
    shares: Array
    """(n,) the part of the area that bends at least as tightly as the radius of the same place."""

    def share_tighter_than(self, radius: float) -> float:
        """The part of the area that bends more tightly than a radius."""
        count = int(np.searchsorted(self.radii, radius))
        return float(self.shares[count - 1]) if count else 0.0


def curvature(surface: PartSurface, regions: Sequence[FlatRegion]) -> Curvature:
    """The curvature of a surface, from the angles between neighbours in its mesh."""
    pairs, _ = surface.neighbours
    if not len(pairs) or is_flat_faced(surface, regions):
        return Curvature(np.empty(0), np.empty(0))
    normals = surface.area_vectors / np.maximum(surface.areas, 1e-300)[:, None]
    middles = surface.corners.mean(axis=1)
    turn = np.arctan2(
        np.linalg.norm(np.cross(normals[pairs[:, 0]], normals[pairs[:, 1]]), axis=1),
        np.einsum("pk,pk->p", normals[pairs[:, 0]], normals[pairs[:, 1]]),
    )
    apart = np.linalg.norm(middles[pairs[:, 0]] - middles[pairs[:, 1]], axis=1)
    bend = np.where((turn < SHARP) & (apart > 4.0 * surface.precision), turn / np.maximum(apart, 1e-300), 0.0)
    tightest = np.zeros(len(surface.faces))
    for k in range(2):
        np.maximum.at(tightest, pairs[:, k], bend)
    with np.errstate(divide="ignore"):
        radii = 1.0 / tightest
    order = np.argsort(radii, kind="stable")
    return Curvature(radii[order], np.cumsum(surface.areas[order]) / surface.area)


def covered_share(surface: PartSurface, frame: PartFrame) -> float:
    """The part of a surface above which there is more of it, as it lies on the board."""
    count = int(np.clip(MOST_TESTS // len(surface.faces), 20, PLUMB_LINES))
    placed = frame.placed(surface.corners)
    shares = np.cumsum(surface.areas) / surface.area
    picked = np.searchsorted(shares, (np.arange(count) + 0.5) / count)
    weights = np.array([0.41, 0.33, 0.26])  # no place of symmetry, which lies over others' edges
    points = np.einsum("j,pjk->pk", weights, placed[picked])
    covered = 0
    a, b, c = np.moveaxis(placed[:, :, :2], 1, 0)
    twice = _cross(b - a, c - a)
    usable = np.abs(twice) > 1e-12 * surface.size**2
    corner, side, other, twice = a[usable], (b - a)[usable], (c - a)[usable], twice[usable]
    heights = placed[usable][:, :, 2]
    for point in points:
        offset = point[:2] - corner
        u, v = _cross(offset, other) / twice, _cross(side, offset) / twice
        hit = (u > BESIDE) & (v > BESIDE) & (u + v < 1.0 - BESIDE)  # a wall does not lie under what begins at its top
        z = (
            heights[hit, 0]
            + u[hit] * (heights[hit, 1] - heights[hit, 0])
            + v[hit] * (heights[hit, 2] - heights[hit, 0])
        )
        covered += bool((z > point[2] + 1e-3 * surface.size).any())
    return covered / count


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
