"""Creases that never fold: their panels are one panel, and vertices that only they met at are none."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from origami_lab.fold_format.panel_triangles import triangulate
from origami_lab.game.crease_pattern import FLAT_ANGLE, CreasePattern
from origami_lab.game.freeze_design import Segment, outline


def without_flat_creases(design: CreasePattern) -> CreasePattern:
    """The pattern without creases that stay flat at all its driving angles.

    Panels on both sides of such a crease become one. A vertex inside a panel goes, and one where nothing but a
    straight crease or boundary passes through. What is left folds as before. A panel that would get a hole stays cut.
    """
    still = ~design.boundary & (np.abs(design.fold_angles) <= FLAT_ANGLE).all(axis=0)
    groups = _joined(design, still)
    if groups is None:
        return design
    panel_of, kept = groups
    owner = {side: panel_of[p] for p, panel in enumerate(design.panels) for side in _sides(panel)}
    borders: list[list[Segment]] = [[] for _ in range(max(panel_of) + 1)]
    for (u, v), panel in owner.items():
        if owner.get((v, u)) != panel:
            borders[panel].append((u, v))
    return _tidied(design, [outline(border, _parts(design)) for border in borders], kept)


def _joined(design: CreasePattern, still: NDArray[np.bool_]) -> tuple[list[int], NDArray[np.bool_]] | None:
    """The new panel of each panel, and which edges are kept; None if nothing changes."""
    sides = {side: p for p, panel in enumerate(design.panels) for side in _sides(panel)}
    kept = np.ones(len(design.edges), dtype=np.bool_)
    parent = list(range(len(design.panels)))

    def root(p: int) -> int:
        while parent[p] != p:
            p = parent[p]
        return p

    for e in np.flatnonzero(still).tolist():
        u, v = (int(t) for t in design.edges[e])
        one, other = root(sides[u, v]), root(sides[v, u])
        if one == other:
            continue  # the last edge of a ring: seen below
        parent[other] = one
        members = {p for p in range(len(parent)) if root(p) == one}
        if not _has_one_outline(design, members):
            parent[other] = other
    roots = [root(p) for p in range(len(parent))]
    numbers = {p: i for i, p in enumerate(dict.fromkeys(roots))}
    for e in range(len(design.edges)):
        u, v = (int(t) for t in design.edges[e])
        kept[e] = design.boundary[e] or roots[sides[u, v]] != roots[sides[v, u]]
    return None if kept.all() else ([numbers[p] for p in roots], kept)


def _has_one_outline(design: CreasePattern, panels: set[int]) -> bool:
    """Whether the panels together are bounded by one closed polygon."""
    sides = {side for p in panels for side in _sides(design.panels[p])}
    border = [(u, v) for u, v in sides if (v, u) not in sides]
    return len(outline(border, _parts(design))) == len(border)


def _tidied(design: CreasePattern, panels: list[tuple[int, ...]], kept: NDArray[np.bool_]) -> CreasePattern:
    """The pattern with other panels and fewer edges, without the vertices that mean nothing any more."""
    edges = [(int(u), int(v)) for u, v in design.edges[kept]]
    numbers = [int(e) for e in np.flatnonzero(kept)]
    at: dict[int, set[int]] = defaultdict(set)
    for i, (u, v) in enumerate(edges):
        at[u].add(i)
        at[v].add(i)
    alive = [True] * len(edges)
    for vertex in sorted(at):
        if len(at[vertex]) != 2:
            continue
        i, j = sorted(at[vertex])
        a, b = (sum(edges[k]) - vertex for k in (i, j))
        if not _passes(design, vertex, a, b, numbers[i], numbers[j]):
            continue
        # the edge keeps its direction, so that its fold angle keeps its meaning
        edges[i] = (a, b) if edges[i][1] == vertex else (b, a)
        alive[j] = False
        at[b].remove(j)
        at[b].add(i)
        del at[vertex]
    used = sorted(vertex for vertex, touching in at.items() if touching)
    number = {vertex: n for n, vertex in enumerate(used)}
    polygons = tuple(tuple(number[v] for v in panel if v in number) for panel in panels)
    rows = [numbers[i] for i in range(len(edges)) if alive[i]]
    vertices = design.vertices[used]
    triangles, owners = triangulate(vertices, polygons)
    return replace(
        design,
        vertices=vertices,
        modes=design.modes[used],
        edges=np.array([(number[u], number[v]) for (u, v), live in zip(edges, alive, strict=True) if live], np.int32),
        boundary=design.boundary[rows],
        driven=design.driven[rows],
        fold_angles=design.fold_angles[:, rows],
        panels=polygons,
        triangles=triangles.astype(np.int32),
        triangle_panels=owners.astype(np.int32),
        folded=design.folded[:, used],
    )


def _passes(design: CreasePattern, vertex: int, a: int, b: int, i: int, j: int) -> bool:
    """Whether two edges that meet at a vertex are one straight line of one kind."""
    one, other = design.vertices[a] - design.vertices[vertex], design.vertices[b] - design.vertices[vertex]
    straight = one[0] * other[1] == one[1] * other[0] and one @ other < 0
    alike = design.boundary[i] == design.boundary[j] and design.driven[i] == design.driven[j]
    return bool(
        straight and alike and np.allclose(design.fold_angles[:, i], design.fold_angles[:, j], rtol=0, atol=1e-9)
    )


def _sides(panel: tuple[int, ...]) -> list[Segment]:
    return [(panel[i], panel[(i + 1) % len(panel)]) for i in range(len(panel))]


def _parts(design: CreasePattern) -> NDArray[np.int64]:
    """Coordinates as whole numbers in 2⁻²⁰ cells: only directions are asked for."""
    return np.asarray(np.round(design.vertices * 2**20), dtype=np.int64)
