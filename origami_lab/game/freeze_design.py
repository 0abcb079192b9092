"""From a state to a finished design: panels as polygons, edges, fold angles."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.folded_sheet import FoldedSheet

Segment = tuple[int, int]

NEARLY_FOLDED_FLAT = np.pi - 1e-5
"""Fold angles beyond this, in radians, take their sign from the angle before."""


def split_edges(flat: NDArray[np.int64], triangles: NDArray[np.int64]) -> list[list[Segment]]:
    """Directed boundary segments of each triangle, split where a vertex lies inside a side.

    A child placed on a boundary segment leaves such a vertex on the side of the panel within.
    """
    out: list[list[Segment]] = []
    for triangle in triangles:
        sides: list[Segment] = []
        for u, v in zip(triangle, np.roll(triangle, -1), strict=True):
            d = flat[v] - flat[u]
            rel = flat - flat[u]
            on_line = d[0] * rel[:, 1] == d[1] * rel[:, 0]
            along = rel @ d
            inside = np.flatnonzero(on_line & (along > 0) & (along < d @ d))
            chain = [int(u), *(int(w) for w in inside[np.argsort(along[inside])]), int(v)]
            sides.extend(pairwise(chain))
        out.append(sides)
    return out


def join_panels(sides: list[list[Segment]], creases: Mapping[Segment, int]) -> NDArray[np.int32]:
    """(T,) panel of each triangle: triangles joined over segments that are no creases."""
    owner: dict[Segment, int] = {side: t for t, triangle in enumerate(sides) for side in triangle}
    parent = list(range(len(sides)))

    def root(t: int) -> int:
        while parent[t] != t:
            parent[t] = parent[parent[t]]
            t = parent[t]
        return t

    for (u, v), t in owner.items():
        other = owner.get((v, u))
        if other is not None and (min(u, v), max(u, v)) not in creases:
            parent[root(t)] = root(other)
    roots = [root(t) for t in range(len(sides))]
    numbers = {r: i for i, r in enumerate(dict.fromkeys(roots))}
    return np.array([numbers[r] for r in roots], dtype=np.int32)


def outline(segments: list[Segment], flat: NDArray[np.int64]) -> tuple[int, ...]:
    """The polygon around a panel, from its directed boundary segments, counter-clockwise."""
    following: dict[int, list[int]] = defaultdict(list)
    for u, v in segments:
        following[u].append(v)
    start, current = segments[0]
    polygon = [start]
    before = start
    following[start].remove(current)
    while current != start:
        polygon.append(current)
        choices = following[current]
        # where the outline touches itself the panel continues on the left: first clockwise from where we came
        back = np.arctan2(*(flat[before] - flat[current])[::-1])
        angles = [(back - np.arctan2(*(flat[w] - flat[current])[::-1])) % (2 * np.pi) for w in choices]
        best = int(np.argmin(angles))
        before, current = current, choices.pop(best)
    return tuple(polygon)


def finished_design(
    sheet: FoldedSheet,
    points: NDArray[np.float64],
    driving_angles: NDArray[np.float64],
    best: int,
    actions: tuple[int, ...],
    metadata: Mapping[str, object],
) -> CreasePattern:
    """Freeze a state's sheet as a crease pattern with its motion.

    ``points`` (K, V, 3) are the sheet's vertices at the (K,) driving angles.
    """
    flat, triangles, creases = sheet.flat, sheet.triangles, sheet.creases
    reach = len(driving_angles)
    sides = split_edges(flat, triangles)
    panel_of = join_panels(sides, creases)
    owner = {side: t for t, triangle in enumerate(sides) for side in triangle}
    borders: list[list[Segment]] = [[] for _ in range(int(panel_of.max(initial=-1)) + 1)]
    edges: list[Segment] = []
    for (u, v), t in owner.items():
        other = owner.get((v, u))
        if other is None or panel_of[other] != panel_of[t]:
            borders[panel_of[t]].append((u, v))
            if other is None or u < v:
                edges.append((u, v))
    if not len(triangles):  # a single crease alone: a sheet without area
        edges = list(creases)
    boundary = np.array([(v, u) not in owner for u, v in edges], dtype=np.bool_)
    driven = np.array(
        [
            creases.get((min(u, v), max(u, v)), 0) != 0 and not outer
            for (u, v), outer in zip(edges, boundary, strict=True)
        ],
        dtype=np.bool_,
    )
    normals = _panel_normals(points, triangles, panel_of, len(borders))
    angles = np.zeros((reach, len(edges)))
    for e, (u, v) in enumerate(edges):
        if not boundary[e]:
            left, right = normals[:, panel_of[owner[(u, v)]]], normals[:, panel_of[owner[(v, u)]]]
            axis = points[:, v] - points[:, u]
            axis /= np.linalg.norm(axis, axis=1, keepdims=True)
            sine = np.einsum("kj,kj->k", np.cross(right, left), axis)
            angles[:, e] = np.arctan2(sine, np.einsum("kj,kj->k", right, left))
            for k in range(1, reach):
                # a crease does not pass π: there rounding would choose between mountain and valley
                if abs(angles[k, e]) > NEARLY_FOLDED_FLAT:
                    angles[k, e] = np.copysign(angles[k, e], angles[k - 1, e])
    return CreasePattern(
        vertices=flat.astype(np.float64),
        modes=sheet.modes,
        edges=np.array(edges, dtype=np.int32).reshape(-1, 2),
        boundary=boundary,
        driven=driven,
        fold_angles=angles,
        panels=tuple(outline(border, flat) for border in borders),
        triangles=triangles.astype(np.int32),
        triangle_panels=panel_of,
        driving_angles=np.array(driving_angles),
        folded=np.array(points),
        best=best,
        actions=actions,
        metadata=metadata,
    )


def _panel_normals(
    points: NDArray[np.float64], triangles: NDArray[np.int64], panel_of: NDArray[np.int32], count: int
) -> NDArray[np.float64]:
    """(K, F, 3) unit normals: the area-weighted mean over each panel's triangles."""
    normals = np.zeros((len(points), count, 3))
    for triangle, panel in zip(triangles, panel_of, strict=True):
        a, b, c = (points[:, v] for v in triangle)
        normals[:, panel] += np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=2, keepdims=True)
