"""Parts with rounded edges: what is flat in them goes on to where it would meet, as creases are sharp.

Sheet metal is bent about a radius, and castings have fillets. A sheet of paper has neither: for the layout on the board
a rounding between flat panels is drawn in to the line, or at a corner to the point, that the panels' planes have in
common. What the folded sheet is measured against stays the part as it is.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from origami_lab.geometry.graph import connected_pieces
from origami_lab.parts.flat_region import FlatRegion, flat_regions, flat_tolerance, planes_of
from origami_lab.parts.frame import is_flat_faced
from origami_lab.parts.surface import Array, Indices, PartSurface, surface_of

Mask = NDArray[np.bool_]

PANEL_SHARES = (0.04, 0.08)
"""Of the area: a flat region at least as large is a panel; what is smaller may be part of a rounding. The second where
that leaves roundings, which are of few, wide facets then."""
MOST_MOVED = 0.1
"""Of the part's size: a rounding that reaches further is a curved part."""
PARALLEL = 1e-2
"""Sine of the angle between planes below which they have no line in common."""


@dataclass(frozen=True, eq=False)
class SharpPart:
    """A part with sharp edges in place of its roundings."""

    surface: PartSurface
    regions: tuple[FlatRegion, ...]
    """Its flat regions, the largest first."""
    off: float
    """How far the sharp edges are from the part as it is, units of the file."""


def sharpened(surface: PartSurface) -> SharpPart | None:
    """A part of flat panels with sharp edges in place of roundings; None if that is not what it is."""
    labels = planes_of(surface, flat_tolerance(surface))
    sizes = np.bincount(labels, surface.areas)
    attempts = (_drawn_in(surface, labels, (sizes >= share * surface.area)[labels]) for share in PANEL_SHARES)
    return next((found for found in attempts if found is not None), None)


def _drawn_in(surface: PartSurface, labels: Indices, is_panel: Mask) -> SharpPart | None:
    """The part without what is no panel; None if its panels do not meet then."""
    if is_panel.all() or not is_panel.any():
        return None
    planes = _planes_at(surface, labels, is_panel)
    moved, corners = surface.vertices.copy(), surface.vertices[sorted(planes)]
    for v, (normals, offsets) in planes.items():
        moved[v] += np.linalg.pinv(normals, rcond=PARALLEL) @ (offsets - normals @ moved[v])
        if np.abs(normals @ moved[v] - offsets).max() > 1e-6 * surface.size:
            return None
    rounded = np.unique(surface.faces[~is_panel])
    shifts = np.linalg.norm(moved - surface.vertices, axis=1)
    if not set(rounded.tolist()) <= planes.keys() or shifts.max() > MOST_MOVED * surface.size:
        return None
    sharp = surface_of(moved, surface.faces, max(surface.precision, 1e-9 * surface.size))
    regions = flat_regions(sharp)
    if not is_flat_faced(sharp, regions):
        return None
    edges = np.unique(np.round(moved[sorted(planes)], 12), axis=0)
    return SharpPart(sharp, regions, float(cKDTree(corners).query(edges)[0].max()))


def _planes_at(surface: PartSurface, labels: Indices, is_panel: Mask) -> dict[int, tuple[Array, Array]]:
    """The planes, normals (k, 3) and offsets (k,), that each vertex of a rounding is to lie in: two or more."""
    pairs, _ = surface.neighbours
    piece = connected_pieces(len(surface.faces), pairs[~is_panel[pairs].any(axis=1)])
    beside: dict[int, set[int]] = defaultdict(set)
    for a, b in pairs[is_panel[pairs].sum(axis=1) == 1]:
        panel, other = (a, b) if is_panel[a] else (b, a)
        beside[int(piece[other])].add(int(labels[panel]))
    wanted: dict[int, set[int]] = defaultdict(set)
    plane = {label: _plane(surface, labels == label) for near in beside.values() for label in near}
    for rounding, near in beside.items():
        if len(near) < 2:
            continue
        names = sorted(near)
        normals = np.array([plane[label][0] for label in names])
        offsets = np.array([plane[label][1] for label in names])
        vertices = np.unique(surface.faces[(piece == rounding) & ~is_panel])
        away = np.abs(surface.vertices[vertices] @ normals.T - offsets)
        reach = float(np.partition(away, 1, axis=1)[:, 1].max()) * (1.0 + 1e-6) + flat_tolerance(surface)
        for v, distances in zip(vertices.tolist(), away, strict=True):
            wanted[v].update(label for label, distance in zip(names, distances, strict=True) if distance <= reach)
    found = {}
    for v, labels_there in wanted.items():
        there = [plane[label] for label in sorted(labels_there)]
        found[v] = np.array([normal for normal, _ in there]), np.array([offset for _, offset in there])
    return found


def _plane(surface: PartSurface, faces: Mask) -> tuple[Array, float]:
    """The unit normal (3,) and the offset of some faces' plane."""
    normal = surface.area_vectors[faces].sum(axis=0)
    normal = normal / np.linalg.norm(normal)
    middle = surface.areas[faces] @ surface.corners[faces].mean(axis=1) / surface.areas[faces].sum()
    return normal, float(normal @ middle)
