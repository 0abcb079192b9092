"""Flat regions of a surface: its floors and walls, their outlines, and how they are hinged to each other."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from origami_lab.geometry.graph import connected_pieces
from origami_lab.parts.surface import Array, Indices, PartSurface

PLANE = 1e-6
"""How far, as a part of the size, what counts as flat may be from a plane."""
LEAST_SHARE = 0.005
"""Of the area, for a region to count."""
NICE_ANGLE, NICE_WITHIN = 0.5, 5e-4
"""Fold angles within so many degrees of a multiple are taken for it, as far as the precision leaves it open."""


@dataclass(frozen=True, eq=False)
class Side:
    """A straight side of a flat region, from one corner to the next with the region on its left."""

    start: Array
    end: Array
    """(3,) units of the file."""
    neighbour: int
    """The flat region on the other side; −1 for none, as at a rim or beside a curved part."""
    fold: float
    """Degrees by which the neighbour is folded up (seen from the side that the normal points to) or, below 0, down."""

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))


@dataclass(frozen=True, eq=False)
class FlatRegion:
    """A connected flat piece of a part's surface."""

    normal: Array
    """(3,) unit vector."""
    centroid: Array
    """(3,) units of the file."""
    area: float
    """Square units of the file."""
    outlines: tuple[tuple[Side, ...], ...]
    """Its outer outline, counter-clockwise seen from where the normal points, then those of its holes."""

    @property
    def outline(self) -> tuple[Side, ...]:
        return self.outlines[0]


def flat_regions(surface: PartSurface) -> tuple[FlatRegion, ...]:
    """All flat regions with a noticeable share of the area, the largest first."""
    tolerance = flat_tolerance(surface)
    labels = planes_of(surface, tolerance)
    count = int(labels.max()) + 1
    vectors = np.zeros((count, 3))
    np.add.at(vectors, labels, surface.area_vectors)
    sizes = np.bincount(labels, surface.areas, count)
    middles = (
        np.stack(
            [np.bincount(labels, surface.areas * surface.corners.mean(axis=1)[:, k], count) for k in range(3)], axis=1
        )
        / np.maximum(sizes, 1e-300)[:, None]
    )
    normals = vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]
    off = np.abs(np.einsum("fjk,fk->fj", surface.corners - middles[labels][:, None], normals[labels])).max(axis=1)
    worst = np.zeros(count)
    np.maximum.at(worst, labels, off)
    kept = [k for k in range(count) if sizes[k] >= LEAST_SHARE * surface.area and worst[k] <= 2.0 * tolerance]
    kept.sort(key=lambda k: -sizes[k])
    place = np.full(count, -1)
    place[kept] = np.arange(len(kept))
    regions = place[labels]
    beside = _beside(surface, regions)
    loops = [_loops(surface, regions, k, beside) for k in range(len(kept))]
    found = []
    for k, label in enumerate(kept):
        outlines = [
            tuple(
                _side(
                    surface,
                    part,
                    normals[label],
                    np.asarray(sizes[kept], dtype=np.float64),
                    middles[kept],
                    normals[kept],
                )
                for part in sides
            )
            for sides in (_straight(surface.vertices, loop, tolerance) for loop in loops[k])
            if len(sides) >= 3
        ]
        if not outlines:
            continue
        outlines.sort(key=lambda sides: -_enclosed(sides, normals[label]))
        found.append(FlatRegion(normals[label], middles[label], float(sizes[label]), tuple(outlines)))
    return tuple(found) if len(found) == len(kept) else ()


def flat_tolerance(surface: PartSurface) -> float:
    """How far what counts as flat may be from a plane, units of the file."""
    return max(4.0 * surface.precision, PLANE * surface.size)


def planes_of(surface: PartSurface, tolerance: float) -> Indices:
    """(F,) which faces are flat together."""
    pairs, at = surface.neighbours
    longest = np.linalg.norm(surface.corners - np.roll(surface.corners, -1, axis=1), axis=2).max(axis=1)
    is_sliver = 2.0 * surface.areas <= 10.0 * tolerance * longest
    normals = surface.area_vectors / np.maximum(surface.areas, 1e-300)[:, None]
    flat = np.ones(len(pairs), dtype=bool)
    for own, other in ((0, 1), (1, 0)):
        apex = surface.faces[pairs[:, other], (at[:, other] + 2) % 3]
        height = np.einsum(
            "pk,pk->p", surface.vertices[apex] - surface.corners[pairs[:, own], 0], normals[pairs[:, own]]
        )
        flat &= is_sliver[pairs[:, own]] | (np.abs(height) <= tolerance)
    turned = np.einsum("pk,pk->p", normals[pairs[:, 0]], normals[pairs[:, 1]]) < 0.0
    flat &= ~turned | is_sliver[pairs].any(axis=1)
    return connected_pieces(len(surface.faces), pairs[flat])


def _beside(surface: PartSurface, regions: Indices) -> dict[tuple[int, int], list[int]]:
    """The flat regions (−1 for none) at each edge, by its vertices in order."""
    found: dict[tuple[int, int], list[int]] = defaultdict(list)
    for face, region in zip(surface.faces.tolist(), regions.tolist(), strict=True):
        for a, b in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0])):
            found[min(a, b), max(a, b)].append(region)
    return found


def _loops(
    surface: PartSurface, regions: Indices, region: int, beside: dict[tuple[int, int], list[int]]
) -> list[list[tuple[int, int, int]]]:
    """The border of a region as closed loops of edges: from, to, and the region on the other side."""
    following: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for face in surface.faces[regions == region].tolist():
        for a, b in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0])):
            here = beside[min(a, b), max(a, b)]
            others = list(here)
            others.remove(region)
            if region not in others:
                following[a].append((b, max(others, default=-1)))
    loops = []
    while following:
        start = at = min(following)
        loop = []
        while at in following:
            b, other = following[at].pop()
            if not following[at]:
                del following[at]
            loop.append((at, b, other))
            at = b
            if at == start:
                break
        if at == start:
            loops.append(loop)
    return loops


def _straight(vertices: Array, loop: list[tuple[int, int, int]], tolerance: float) -> list[tuple[Array, Array, int]]:
    """A loop of edges with those in one line and beside one neighbour joined."""

    def goes_on(first: tuple[int, int, int], second: tuple[int, int, int]) -> bool:
        a, b, c = vertices[first[0]], vertices[first[1]], vertices[second[1]]
        along = c - a
        reach = float(np.linalg.norm(along))
        off = float(np.linalg.norm(np.cross(b - a, along))) / reach if reach > 0.0 else math.inf
        return first[2] == second[2] and off <= tolerance and float((b - a) @ (c - b)) > 0.0

    begin = next((i for i in range(len(loop)) if not goes_on(loop[i - 1], loop[i])), 0)
    sides: list[tuple[int, int, int]] = []
    for edge in loop[begin:] + loop[:begin]:
        if sides and goes_on(sides[-1], edge):
            sides[-1] = (sides[-1][0], edge[1], edge[2])
        else:
            sides.append(edge)
    return [(vertices[a], vertices[b], other) for a, b, other in sides]


def _side(
    surface: PartSurface, part: tuple[Array, Array, int], normal: Array, sizes: Array, middles: Array, normals: Array
) -> Side:
    start, end, other = part
    if other < 0:
        return Side(start, end, -1, 0.0)
    along = (end - start) / np.linalg.norm(end - start)
    outward = np.cross(along, normal)
    into = np.cross(normals[other], along)
    into = into / np.linalg.norm(into)
    if into @ (middles[other] - start) < 0.0:  # into the neighbour, also where its border goes round its middle
        into = -into
    fold = math.degrees(math.atan2(float(into @ normal), float(into @ outward)))
    unsure = math.degrees(8.0 * surface.precision / math.sqrt(sizes[other]))
    nice = NICE_ANGLE * round(fold / NICE_ANGLE)
    return Side(start, end, other, nice if abs(fold - nice) <= NICE_WITHIN + unsure else fold)


def _enclosed(sides: tuple[Side, ...], normal: Array) -> float:
    """The area that an outline encloses, below 0 if it goes round clockwise."""
    points = np.array([side.start for side in sides])
    points = points - points[0]
    return float(0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) @ normal)
