"""Independent truths: slow, plain Python, exact where the question is discrete.

* :func:`triangles_cross` in rational arithmetic.
* :class:`BoardSheet` plays the game on the whole sheet, image by image, as a list of boundary points; what is legal
  is found by trying: insert the child and all its images, then test all pairs of boundary segments.
* Single-vertex kinematics by spherical trigonometry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np

from origami_lab.game.folded_sheet import FoldedSheet
from tests.sheet_checks import polygon_is_simple

Point = tuple[int, int]
Vector = tuple[Fraction, ...]
EPSILON = 1e-9
"""Directions on a board differ by far more than this (radians)."""

# --- triangles in space ----------------------------------------------------------------------------------------------


def _sub(a: Vector, b: Vector) -> Vector:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def triangles_cross(p: Iterable[Sequence[int]], q: Iterable[Sequence[int]]) -> bool:
    """Whether the relative interiors of two triangles in different planes have a point in common, exactly."""
    ps, qs = ([tuple(Fraction(x) for x in corner) for corner in t] for t in (p, q))
    normal = _cross(_sub(qs[1], qs[0]), _sub(qs[2], qs[0]))
    height = [_dot(normal, _sub(corner, qs[0])) for corner in ps]
    if not (min(height) < 0 < max(height)):
        return False
    # the chord in which p meets the plane of q
    chord: list[Vector] = [corner for corner, h in zip(ps, height, strict=True) if h == 0]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        if height[i] * height[j] < 0:
            t = height[i] / (height[i] - height[j])
            chord.append(tuple(a + t * (b - a) for a, b in zip(ps[i], ps[j], strict=True)))
    start, end = chord
    # the open part of it, 0 < t < 1, strictly inside all three sides of q
    low, high = Fraction(0), Fraction(1)
    for i in range(3):
        inward = _cross(normal, _sub(qs[(i + 1) % 3], qs[i]))
        value, slope = _dot(inward, _sub(start, qs[i])), _dot(inward, _sub(end, start))
        if slope == 0:
            if value <= 0:
                return False
        elif slope > 0:
            low = max(low, -value / slope)
        else:
            high = min(high, -value / slope)
    return low < high


# --- one vertex ------------------------------------------------------------------------------------------------------


def spherical_angle(opposite: float, side: float, other: float) -> float:
    """The angle of a spherical triangle between two sides, by the law of cosines; ValueError if there is none."""
    cosine = (math.cos(opposite) - math.cos(side) * math.cos(other)) / (math.sin(side) * math.sin(other))
    return math.acos(cosine)


def spherical_triangle_exists(u1: float, u2: float, u3: float) -> bool:
    """U_max ≤ U_min + U_med, for sides below π whose sum is below 2π."""
    low, middle, high = sorted((u1, u2, u3))
    return high <= low + middle and u1 + u2 + u3 <= 2 * math.pi


# --- the game --------------------------------------------------------------------------------------------------------


def angle_between(a: Point, b: Point) -> float:
    """Counter-clockwise from direction a to direction b, in [0, 2π)."""
    angle = (math.atan2(b[1], b[0]) - math.atan2(a[1], a[0])) % (2 * math.pi)
    return 0.0 if 2 * math.pi - angle < EPSILON else angle


def _is_sector(angle: float) -> bool:
    return EPSILON < angle < math.pi - EPSILON


def _is_half_turn(angle: float) -> bool:
    return abs(angle - math.pi) <= EPSILON


@dataclass
class BoardSheet:
    """The whole sheet, images included, as a counter-clockwise ring of leaves."""

    half: tuple[int, int]
    symmetry: str
    max_length: float | None
    sources_allowed: bool = True
    anywhere: bool = False
    """Whether sources may be laid on any boundary segment, too."""
    ring: list[Point] = field(default_factory=list)
    incoming: dict[Point, list[Point]] = field(default_factory=dict)
    """Creases into each leaf, counter-clockwise from its next side to its prev side: their other ends."""
    driven: dict[frozenset[Point], int] = field(default_factory=dict)
    extended: bool = False
    folded: tuple[FoldedSheet, float] | None = None
    """The folded sheet and its smallest driving angle, where sectors of π are allowed if they fold."""
    stays: Point = (0, 1)
    """The direction, seen from a single crease, of the panel that stays in the plane."""
    min_length: float = 0.0
    """Of creases that are laid after the start pattern."""
    min_sector: float = 0.0
    """Of the angle between two neighbouring creases of a vertex, of which one is new, in radians."""
    min_width: float = 0.0
    """Of each new triangle of a panel."""

    def __post_init__(self) -> None:
        mirrors = {"y": [(-1, 0, 0, 1)], "x": [(1, 0, 0, -1)], "xy": [(-1, 0, 0, 1), (1, 0, 0, -1)]}
        mirrors["xyd"] = [*mirrors["xy"], (0, 1, 1, 0)]
        group = {(1, 0, 0, 1)}
        while True:  # closure of the mirrors under multiplication
            new = {_times(g, m) for g in group for m in mirrors.get(self.symmetry, [])} | group
            if new == group:
                break
            group = new
        self.group = sorted(group, reverse=True)
        self.mirrors = [g for g in group if g[0] * g[3] - g[1] * g[2] < 0]

    # the board

    def playable(self, q: Point) -> bool:
        x, y = q
        if abs(x) > self.half[0] or abs(y) > self.half[1]:
            return False
        left, up = x <= 0 or self.symmetry not in ("y", "xy", "xyd"), y >= 0 or "x" not in self.symmetry
        return left and up and (self.symmetry != "xyd" or -x >= y)

    def axes(self, q: Point) -> list[tuple[int, ...]]:
        return [m for m in self.mirrors if _apply(m, q) == q]

    def orbit(self, v: Point) -> dict[Point, tuple[int, ...]]:
        """Images of v, each with a group element that makes it."""
        out: dict[Point, tuple[int, ...]] = {}
        for g in sorted(self.group, key=lambda g: g != (1, 0, 0, 1)):
            out.setdefault(_apply(g, v), g)
        return out

    def neighbours(self, v: Point) -> tuple[Point, Point]:
        i = self.ring.index(v)
        return self.ring[i - 1], self.ring[(i + 1) % len(self.ring)]

    # moves

    def place_square(self, h: int, sign: int) -> None:
        self.ring = [(h, h), (-h, h), (-h, -h), (h, -h)]
        for p in self.ring:
            prev, following = self.neighbours(p)
            self.incoming[p] = [following, prev]
            self.driven[frozenset((p, following))] = sign

    def place_crease(self, y: int, sign: int) -> None:
        self.ring = [(-1, y), (1, y)]
        self.incoming = {(-1, y): [(1, y)], (1, y): [(-1, y)]}
        self.driven[frozenset(self.ring)] = sign

    def place_outline(self, corners: Sequence[Point], signs: Sequence[int]) -> None:
        """Any convex panel, counter-clockwise; or a crease, whose panel on the left of the way along it stays."""
        self.ring = list(corners)
        if len(corners) == 2:
            (x0, y0), (x1, y1) = corners
            self.stays = (y0 - y1, x1 - x0)
            self.incoming = {corners[0]: [corners[1]], corners[1]: [corners[0]]}
            self.driven[frozenset(corners)] = signs[0]
            return
        self.incoming = {p: [] for p in corners}
        for p, sign in zip(corners, signs, strict=True):
            _, following = self.neighbours(p)
            if sign:
                self.incoming[p].insert(0, following)
                self.incoming[following].append(p)
                self.driven[frozenset((p, following))] = sign

    def lay_source(self, u: Point, w: Point, sign: int) -> None:
        """Between u and its successor w, and the images."""
        for g in self.group:
            gu, gw = _apply(g, u), _apply(g, w)
            if frozenset((gu, gw)) in self.driven:
                continue
            if self.neighbours(gu)[1] != gw:
                gu, gw = gw, gu
            self.incoming[gu].insert(0, gw)
            self.incoming[gw].append(gu)
            self.driven[frozenset((gu, gw))] = sign

    def extend(self, v: Point, a: Point, b: Point, c: Point) -> None:
        self.extended = True
        for u, g in self.orbit(v).items():
            prev_child, next_child = (_apply(g, a), _apply(g, b))
            if g in self.mirrors:
                prev_child, next_child = next_child, prev_child
            prev, following = self.neighbours(u)
            i, middle = self.ring.index(u), _apply(g, c)
            new = [middle]
            self.incoming[middle] = [u]
            if prev_child == prev:
                self.incoming[prev].insert(0, u)
            else:
                new.insert(0, prev_child)
                self.incoming[prev_child] = [u]
            if next_child == following:
                self.incoming[following].append(u)
            else:
                new.append(next_child)
                self.incoming[next_child] = [u]
            self.ring[i : i + 1] = new

    # what is legal

    def selectable(self) -> set[Point]:
        """Leaves in the playable area, off the border, with all sectors below π, or one of π that folds."""
        return {v for v in self.ring if self.playable(v) and self._is_selectable(v)}

    def _is_selectable(self, v: Point) -> bool:
        if abs(v[0]) >= self.half[0] or abs(v[1]) >= self.half[1] or len(self.axes(v)) > 1 or not self.incoming[v]:
            return False
        prev, following = self.neighbours(v)
        towards = [_minus(w, v) for w in self.incoming[v]]
        sectors = [angle_between(d, e) for d, e in pairwise(towards)]
        inner = all(_is_sector(sector) or _is_half_turn(sector) for sector in sectors)
        if any(_is_half_turn(sector) for sector in sectors):
            inner = inner and self.folds_alike(v, (1, 0)) and self.folds_alike(v, (0, 1))
        before = angle_between(_minus(following, v), towards[0])
        after = angle_between(towards[-1], _minus(prev, v))
        for sector, crease in ((before, towards[0]), (after, towards[-1])):
            inner = inner and (sector < math.pi - EPSILON or (_is_half_turn(sector) and self.folds_alike(v, crease)))
        return inner

    def folds_alike(self, v: Point, d: Point) -> bool:
        """Whether the panels on both sides of leaf v have a direction of the board at one place in space.

        Then what is beyond the outermost creases may be one plane that the direction lies in. With a half-turn at v
        that is all: the rest is a path of length π between opposite points of the unit sphere.
        """
        if self.folded is None:
            return False
        prev, following = self.neighbours(v)
        one = self._folded_direction(*self.folded, v, prev, "prev", d)
        other = self._folded_direction(*self.folded, v, following, "next", d)
        return bool(np.abs(one - other).max() < 1e-7)

    def sources(self) -> set[tuple[Point, str]]:
        """Leaf and end of each segment between a playable leaf and its mirror image that has no source yet."""
        out: set[tuple[Point, str]] = set()
        if not self.sources_allowed:
            return out
        for v in self.ring:
            if self.playable(v) and not self.axes(v):
                prev, following = self.neighbours(v)
                images = self.orbit(v)
                if prev in images and frozenset((v, prev)) not in self.driven and self._may_be_crease(prev, v):
                    out.add((v, "start"))
                if following in images and frozenset((v, following)) not in self.driven:
                    if self._may_be_crease(v, following):
                        out.add((v, "end"))
        return out

    # limits of what can be folded

    def _may_be_crease(self, u: Point, w: Point) -> bool:
        """Whether a crease may lie on the boundary segment from u to its successor w."""
        return math.dist(u, w) >= self.min_length - EPSILON and self._is_blunt(u, w) and self._is_blunt(w, u)

    def _is_blunt(self, u: Point, w: Point) -> bool:
        """Whether a crease from u along the boundary to w keeps its distance from the next one of u's."""
        if not self.incoming[u]:
            return True
        follows = self.neighbours(u)[1] == w
        beside = _minus(self.incoming[u][0 if follows else -1], u)
        towards = _minus(w, u)
        angle = angle_between(towards, beside) if follows else angle_between(beside, towards)
        return min(angle, 2 * math.pi - angle) >= self.min_sector - EPSILON

    def _is_wide(self, *corners: Point) -> bool:
        """Whether a triangle is wide enough in every direction; it is narrowest at right angles to a side."""
        places = np.array(corners, dtype=float)
        extents = []
        for side in places - np.roll(places, 1, axis=0):
            if side.any():
                across = np.array([-side[1], side[0]]) / np.linalg.norm(side)
                extents.append(np.ptp(places @ across))
        narrowest = min(extents, default=0.0)
        return narrowest < EPSILON or narrowest >= self.min_width - EPSILON

    def _panels_are_wide(self, v: Point, neighbour: Point, q: Point) -> bool:
        """Whether an outer child brings no panel that is too narrow; over a seam its image has a part in one."""
        if not self._is_wide(v, neighbour, q):
            return False
        orbit = self.orbit(v)
        return neighbour not in orbit or self._is_wide(neighbour, _apply(orbit[neighbour], q), q)

    def boundary_sources(self) -> set[Point]:
        """Playable leaves whose segment to the next one, playable too, has no source yet."""
        out = set()
        for v in self.ring:
            following = self.neighbours(v)[1]
            if self.playable(v) and self.playable(following) and frozenset((v, following)) not in self.driven:
                if self._may_be_crease(v, following):
                    out.add(v)
        return out

    def near_side(self, v: Point) -> str | None:
        """Of an on-axis leaf: the side on which the playable area lies."""
        if not self.axes(v):
            return None
        prev, _ = self.neighbours(v)
        return "prev" if self._playable_direction(v, _minus(prev, v)) else "next"

    def _playable_direction(self, v: Point, d: Point) -> bool:
        x, y = 1000 * v[0] + d[0], 1000 * v[1] + d[1]
        left, up = x <= 0 or self.symmetry not in ("y", "xy", "xyd"), y >= 0 or "x" not in self.symmetry
        return left and up and (self.symmetry != "xyd" or -x >= y)

    def first(self, v: Point) -> set[Point]:
        """Where the first outer child may lie: a, or on an axis the one on the playable side."""
        side = self.near_side(v) or "prev"
        return self._outer(v, side, None)

    def second(self, v: Point, a: Point) -> set[Point]:
        return self._outer(v, "next", a)

    def _outer(self, v: Point, side: str, a: Point | None) -> set[Point]:
        prev, following = self.neighbours(v)
        d_prev, d_next = _minus(prev, v), _minus(following, v)
        outside = angle_between(d_prev, d_next) or 2 * math.pi
        neighbour = prev if side == "prev" else following
        found, insert = set(), []
        for q in self._board():
            d = _minus(q, v)
            if not self.playable(q) or q == v or self._too_long(d):
                continue
            theta = angle_between(d_prev, d)
            if side == "next" and theta < EPSILON and outside > 2 * math.pi - EPSILON:
                theta = 2 * math.pi
            if theta > outside + EPSILON:
                continue
            if side == "prev":
                sector = angle_between(_minus(self.incoming[v][-1], v), d_prev) + theta
                room = theta < outside - EPSILON
            else:
                sector = outside - theta + angle_between(d_next, _minus(self.incoming[v][0], v))
                room = theta > EPSILON and (a is None or theta > angle_between(d_prev, _minus(a, v)) + EPSILON)
            if _is_half_turn(sector):
                # its outer panel needs an area, and the other creases must be flat
                crease = _minus(self.incoming[v][-1 if side == "prev" else 0], v)
                beside = theta if side == "prev" else outside - theta
                if _is_half_turn(beside) or not self.folds_alike(v, crease):
                    continue
            elif not _is_sector(sector):
                continue
            if not (room and sector >= self.min_sector - EPSILON):
                continue
            if q == neighbour:
                if neighbour not in self.orbit(v) and self._is_blunt(neighbour, v):
                    found.add(q)
            elif self._panels_are_wide(v, neighbour, q):
                insert.append(q)
        if self.axes(v):
            mirror = self.axes(v)[0]
            children = [(q, _apply(mirror, q)) if side == "prev" else (_apply(mirror, q), q) for q in insert]
            children = [pair for pair in children if pair[0] != pair[1]]
        else:
            children = [(q, None) if side == "prev" else (a, q) for q in insert]
        simple = self._simple(v, [(pair[0], None, pair[1]) for pair in children])
        at = 0 if side == "prev" else 1
        return found | {pair[at] for pair, fits in zip(children, simple, strict=True) if fits}

    def third(self, v: Point, a: Point, b: Point) -> set[Point]:
        """Where the middle child may lie, but for the kinematics."""
        found = []
        for q in self._board():
            d = _minus(q, v)
            if not self.playable(q) or q in self.ring or self._too_long(d):
                continue
            if set(self.axes(v)) - set(self.axes(q)):
                continue
            sectors = angle_between(_minus(a, v), d), angle_between(d, _minus(b, v))
            if not all(_is_sector(sector) and sector >= self.min_sector - EPSILON for sector in sectors):
                continue
            if self._is_wide(v, a, q) and self._is_wide(v, q, b):
                found.append(q)
        simple = self._simple(v, [(a, q, b) for q in found])
        return {q for q, fits in zip(found, simple, strict=True) if fits}

    def has_half_turn(self, v: Point, a: Point, b: Point) -> bool:
        """Whether a sector at v, but for those beside the middle child, is π."""
        towards = [_minus(b, v), *(_minus(w, v) for w in self.incoming[v]), _minus(a, v)]
        return any(_is_half_turn(angle_between(d, e)) for d, e in pairwise(towards))

    def triangle_slack(self, sheet: FoldedSheet, rho: float, v: Point, a: Point, b: Point, c: Point) -> float:
        """By how much the spherical triangle (U1, U2, U3) exists at the smallest driving angle ρ; negative: not."""
        prev, following = self.neighbours(v)
        A = self._folded_direction(sheet, rho, v, prev, "prev", _minus(a, v))
        B = self._folded_direction(sheet, rho, v, following, "next", _minus(b, v))
        u1 = math.atan2(float(np.linalg.norm(np.cross(A, B))), float(A @ B))
        u2, u3 = angle_between(_minus(a, v), _minus(c, v)), angle_between(_minus(c, v), _minus(b, v))
        return min(u1 + u2 - u3, u1 + u3 - u2, u2 + u3 - u1, 2 * math.pi - u1 - u2 - u3)

    def opens_towards(self, sheet: FoldedSheet, rho: float, v: Point, a: Point, b: Point, c: Point) -> float:
        """For opposite a and b: the mode whose middle crease starts flat has this sign.

        Folded a little, a straight line a–v–b bends up (+) or down (−). The middle crease then closes the vertex from
        outside only if it bends the same way, as a valley or a mountain; otherwise it would lie folded back.
        """
        prev, following = self.neighbours(v)
        A = self._folded_direction(sheet, rho, v, prev, "prev", _minus(a, v))
        B = self._folded_direction(sheet, rho, v, following, "next", _minus(b, v))
        C = self._folded_direction(sheet, rho, v, prev, "prev", _minus(c, v))
        return float((A + B) @ np.cross(A, C))

    def _folded_direction(self, sheet: FoldedSheet, rho: float, v: Point, w: Point, side: str, d: Point) -> np.ndarray:
        """Where the board direction d points on the panel beside the boundary segment v–w."""
        edge = np.array(_minus(w, v), dtype=float)
        edge /= np.linalg.norm(edge)
        outward = np.array([-edge[1], edge[0]]) * (1 if side == "prev" else -1)
        along, out = float(np.dot(edge, d)), float(np.dot(outward, d))
        E, P, N = _edge_frame(sheet, v, w, outward)
        sign = self.driven.get(frozenset((v, w)), 0)
        if len(self.ring) == 2 and outward @ self.stays > 0:
            sign = 0
        # a valley lifts the flap towards the side that the normal points to
        flap = math.cos(sign * rho) * P + math.sin(sign * rho) * N
        direction = along * E + out * flap
        return direction / np.linalg.norm(direction)

    def _board(self) -> list[Point]:
        xs, ys = (range(-half, half + 1) for half in self.half)
        return [(x, y) for y in ys for x in xs]

    def _too_long(self, d: Point) -> bool:
        """Too long, or too short."""
        if math.hypot(*d) < self.min_length - EPSILON:
            return True
        return self.max_length is not None and math.hypot(*d) > self.max_length + EPSILON

    def _simple(self, v: Point, children: list[tuple[Point | None, Point | None, Point | None]]) -> list[bool]:
        """Whether the sheet stays a simple polygon when v and its images get these children (None: not yet)."""
        by_length: dict[int, list[int]] = {}
        rings = []
        for i, (a, c, b) in enumerate(children):
            ring: list[tuple[Point, bool]] = []
            for u in self.ring:
                g = self.orbit(v).get(u)
                if g is None:
                    ring.append((u, False))
                    continue
                before, after = (b, a) if g in self.mirrors else (a, b)
                prev, following = self.neighbours(u)
                if before is not None and _apply(g, before) != prev:
                    ring.append((_apply(g, before), True))
                ring.append((u, False) if c is None else (_apply(g, c), False))
                if after is not None and _apply(g, after) != following:
                    ring.append((_apply(g, after), True))
            # images that merge on an axis
            points = [p for j, (p, new) in enumerate(ring) if not (new and ring[j - 1] == (p, True))]
            rings.append(points)
            by_length.setdefault(len(points), []).append(i)
        out = [False] * len(children)
        for members in by_length.values():
            simple = polygon_is_simple(np.array([rings[i] for i in members], dtype=np.int64))
            for i, fits in zip(members, simple, strict=True):
                out[i] = bool(fits)
        return out


def _edge_frame(
    sheet: FoldedSheet, v: Point, w: Point, outward: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Images of the direction v→w, of the outward direction and of the normal, on the panel within the sheet."""
    flat = [tuple(int(x) for x in p) for p in sheet.flat]
    points = sheet.points[0]
    E = points[flat.index(w)] - points[flat.index(v)]
    E = E / np.linalg.norm(E)
    if not len(sheet.triangles):
        return E, np.append(outward, 0.0), np.array([0.0, 0.0, 1.0])
    for triangle in sheet.triangles:
        for i in range(3):
            p, q = flat[triangle[i]], flat[triangle[(i + 1) % 3]]
            if _is_on(v, p, q) and _is_on(w, p, q):
                a, b, c = (points[t] for t in triangle)
                N = np.cross(b - a, c - a)
                N /= np.linalg.norm(N)
                left = outward[1] * (w[0] - v[0]) - outward[0] * (w[1] - v[1]) > 0
                # is this panel on the inside of the segment?
                third = flat[triangle[(i + 2) % 3]]
                side = outward @ np.array(_minus(third, v))
                if side < 0:
                    return E, np.cross(N, E) * (1 if left else -1), N
    raise AssertionError("no panel beside a boundary segment")


def _is_on(r: Point, p: Point, q: Point) -> bool:
    turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    return turn == 0 and min(p[0], q[0]) <= r[0] <= max(p[0], q[0]) and min(p[1], q[1]) <= r[1] <= max(p[1], q[1])


def _apply(g: tuple[int, ...], p: Point) -> Point:
    return g[0] * p[0] + g[1] * p[1], g[2] * p[0] + g[3] * p[1]


def _times(g: tuple[int, ...], h: tuple[int, ...]) -> tuple[int, ...]:
    return (
        g[0] * h[0] + g[1] * h[2],
        g[0] * h[1] + g[1] * h[3],
        g[2] * h[0] + g[3] * h[2],
        g[2] * h[1] + g[3] * h[3],
    )


def _minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1]
