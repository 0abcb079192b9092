"""A flat-faced part laid out around its base: where its corners lie when all is unfolded into the plane."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from origami_lab.parts.flat_region import FlatRegion, Side
from origami_lab.parts.frame import PartFrame
from origami_lab.parts.surface import Array


@dataclass(frozen=True, eq=False)
class BaseSide:
    """A side of the base, in the plane of the sheet."""

    start: Array
    end: Array
    """(2,) units of the file; counter-clockwise round the base."""
    fold: float
    """Degrees by which the wall beyond it is folded up; 0 if there is none."""
    wall: int
    """The flat region beyond it; −1 for none."""
    rises: tuple[Array | None, Array | None]
    """The wall's edge at its start and that at its end: (2,) how far along the side, away from it, and how far up the
    unfolded wall; None where the wall does not begin at the corner."""

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))


@dataclass(frozen=True, eq=False)
class Unfolding:
    """The base of a flat-faced part and, as far as they hang together, all other regions, in the plane of the sheet."""

    sides: tuple[BaseSide, ...]
    """Of the base's outer outline, counter-clockwise."""
    corners: Array
    """(n, 2) corners of the base and of its own walls, units of the file."""
    further: Array
    """(m, 2) corners of what hangs on the walls."""
    outlines: tuple[Array, ...]
    """(k, 2) the outer outline of each region."""

    @property
    def all_corners(self) -> Array:
        return np.concatenate([self.corners, self.further])


def unfold(regions: Sequence[FlatRegion], frame: PartFrame) -> Unfolding:
    """Unfold the regions about their hinges, the largest first, from the frame's base on."""
    assert frame.base is not None
    base = regions[frame.base]
    is_up = float(base.normal @ frame.rotation[2]) > 0.0
    maps: dict[int, _Map] = {frame.base: _Map(np.zeros(3), np.zeros(2), np.eye(3)[:2])}
    depth = {frame.base: 0}
    queue = [(0, 0.0, frame.base)]
    while queue:
        _, _, here = heapq.heappop(queue)
        for side in (side for outline in regions[here].outlines for side in outline):
            other = side.neighbour
            if other < 0 or other in maps:
                continue
            maps[other] = _beyond(maps[here], side, regions[here], regions[other], frame)
            depth[other] = depth[here] + 1
            heapq.heappush(queue, (depth[other], -regions[other].area, other))
    near = [_flat_corners(regions[k], maps[k], frame) for k in maps if depth[k] <= 1]
    far = [_flat_corners(regions[k], maps[k], frame) for k in maps if depth[k] > 1]
    sides = tuple(_base_side(side, regions, maps, frame, is_up) for side in base.outline)
    if not is_up:
        sides = sides[::-1]
    outlines = tuple(maps[k].flat(frame.placed(np.array([side.start for side in regions[k].outline]))) for k in maps)
    return Unfolding(sides, np.concatenate(near), np.concatenate(far) if far else np.empty((0, 2)), outlines)


@dataclass(frozen=True, eq=False)
class _Map:
    """From the plane of a region, in the frame's axes, to the plane of the sheet."""

    start: Array
    place: Array
    axes: Array
    """(2, 3)"""

    def flat(self, points: Array) -> Array:
        return np.asarray(self.place + (points - self.start) @ self.axes.T)


def _beyond(here: _Map, side: Side, region: FlatRegion, other: FlatRegion, frame: PartFrame) -> _Map:
    """The map of the region beyond a side, unfolded about it."""
    start, end = frame.placed(np.stack([side.start, side.end]))
    along = (end - start) / np.linalg.norm(end - start)
    into = np.cross(frame.rotation @ other.normal, along)
    middle = frame.placed(other.centroid)
    into = into / np.linalg.norm(into) * (1.0 if into @ (middle - start) > 0.0 else -1.0)
    flat_along = here.axes @ along
    inside = here.flat(frame.placed(region.centroid)) - here.flat(start)
    outward = np.array([flat_along[1], -flat_along[0]])
    if outward @ inside > 0.0:
        outward = -outward
    axes = np.outer(flat_along, along) + np.outer(outward, into)
    return _Map(start, here.flat(start), axes)


def _flat_corners(region: FlatRegion, to_flat: _Map, frame: PartFrame) -> Array:
    points = np.array([side.start for outline in region.outlines for side in outline])
    return to_flat.flat(frame.placed(points))


def _base_side(
    side: Side, regions: Sequence[FlatRegion], maps: dict[int, _Map], frame: PartFrame, is_up: bool
) -> BaseSide:
    start, end = frame.placed(np.stack([side.start, side.end]))
    rises: list[Array | None] = [None, None]
    if side.neighbour >= 0:
        to_flat = maps[side.neighbour]
        along = (end - start)[:2] / np.linalg.norm(end - start)
        for which, corner in enumerate((side.start, side.end)):
            top = _edge_from(regions[side.neighbour], corner, side)
            if top is not None:
                offset = to_flat.flat(frame.placed(top)) - to_flat.flat(frame.placed(corner))
                ahead = float(offset @ along) * (-1.0 if which == 0 else 1.0)
                up = abs(float(offset @ np.array([along[1], -along[0]])))
                rises[which] = np.array([ahead, up])
    fold = side.fold if is_up else -side.fold
    if is_up:
        return BaseSide(start[:2], end[:2], fold, side.neighbour, (rises[0], rises[1]))
    return BaseSide(end[:2], start[:2], fold, side.neighbour, (rises[1], rises[0]))


def _edge_from(wall: FlatRegion, corner: Array, hinge: Side) -> Array | None:
    """The other end of the wall's edge that leaves a corner of the base and is not the hinge."""
    close = 1e-6 * hinge.length
    for outline in wall.outlines:
        for i, here in enumerate(outline):
            if np.linalg.norm(here.start - corner) <= close:
                for point in (here.end, outline[i - 1].start):
                    off = np.cross(point - hinge.start, hinge.end - hinge.start)
                    if np.linalg.norm(off) > 1e-6 * hinge.length * hinge.length:
                        return point
    return None
