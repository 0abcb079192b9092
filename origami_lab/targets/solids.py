"""Targets in closed form: the paper's pyramid, cube and bowl (appendix B)."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.targets.target import Target

LARGEST = 1e4
"""Board units: no board is so large by far, and with squares of absurd numbers nothing can be computed."""


def _positive(field: str, value: float) -> float:
    if not _number(field, value) >= 1.0 / LARGEST:
        raise InputError(field, value, f"must be a number from {1.0 / LARGEST:g} to {LARGEST:g} (board units)")
    return float(value)


def _number(field: str, value: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
        raise InputError(field, value, f"must be a number up to {LARGEST:g} (board units)")
    return float(value)


def pyramid(half_width: float = 1.0, apex: float = math.sqrt(8.0)) -> Target:
    """A square pyramid with its base on z = 0 and its apex at height ``apex``: closed.

    With the defaults the flaps have height 3 and lie on the board's grid. (The paper's appendix prints
    half-width 2, which cannot fold on its 9×9 board.)

    Raises
    ------
    InputError
        If a length is not positive.
    """
    w = _positive("target.half_width", half_width)
    ring = [(w, w, 0.0), (-w, w, 0.0), (-w, -w, 0.0), (w, -w, 0.0)]
    vertices = [*ring, (0.0, 0.0, 0.0), (0.0, 0.0, _positive("target.apex", apex))]
    faces = [(4, (k + 1) % 4, k) for k in range(4)] + [(5, k, (k + 1) % 4) for k in range(4)]
    return Target("pyramid", np.array(vertices), np.array(faces), closed=True)


def cube(edge: float = 2.0) -> Target:
    """The cube standing on z = 0 above the origin, edges parallel to the axes: closed.

    Every side is cut from its centre into four triangles, so the mesh has all symmetries of the cube.

    Raises
    ------
    InputError
        If ``edge`` is not positive.
    """
    half = 0.5 * _positive("target.edge", edge)
    square = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    triangles = []
    for axis in range(3):
        for side in (-1, 1):
            for k in range(4):  # from the centre of the side, counter-clockwise from outside
                corners = [(side, 0, 0), (side, *square[k]), (side, *square[(k + side) % 4])]
                triangles.append([np.roll(corner, axis) for corner in corners])
    unique, index = np.unique(np.array(triangles).reshape(-1, 3), axis=0, return_inverse=True)
    return Target("cube", half * (unique + np.array([0, 0, 1])), index.reshape(-1, 3), closed=True)


def bowl(
    coefficient: float = 0.2,
    offset: float = -0.6,
    inner: float = 1.6,
    outer: float = 5.0,
    error: float = 0.003,
) -> Target:
    """The paper's bowl: z = coefficient·r² + offset for inner ≤ r ≤ outer, and the flat disc within: open.

    Parameters
    ----------
    coefficient
        1/board units.
    offset, inner, outer
        Board units, 0 < inner < outer.
    error
        The mesh is nowhere further than this from the true surface, nor it from the mesh. Vertices lie on
        it. The mesh has all eight symmetries of the square exactly, to the last bit.

    Raises
    ------
    InputError
        If the numbers do not describe a bowl.
    """
    _positive("target.inner", inner)
    if not _positive("target.outer", outer) > inner:
        raise InputError("target.outer", outer, f"must be above target.inner={inner}")
    if abs(_number("target.coefficient", coefficient)) * outer * outer > 100.0 * outer:
        expected = f"must be at most {100.0 / outer:g}: the bowl would be 100 times as deep as it is wide"
        raise InputError("target.coefficient", coefficient, expected)
    _number("target.offset", offset)
    _positive("target.error", error)
    count, steps = _bowl_resolution(coefficient, inner, outer, error)

    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []

    def ring(number: int, radius: float, z: float, staggered: bool) -> NDArray[np.int64]:
        first = len(vertices)
        vertices.extend((x, y, z) for x, y in _circle(number, radius, staggered))
        return np.arange(first, first + number)

    # the paraboloid: rings of equally many points, every other one turned by half a step
    radii = [inner + (outer - inner) * i / steps for i in range(steps + 1)]
    rings = [ring(count, r, coefficient * r * r + offset, i % 2 == 1) for i, r in enumerate(radii)]
    for i in range(steps):
        low, high = rings[i], rings[i + 1]
        for k in range(count):
            n = (k + 1) % count
            tip, base = (high[k], low[n]) if i % 2 == 0 else (high[n], low[k])  # tip is between low[k] and low[n]
            faces += [(low[k], tip, low[n]), (base, high[k], high[n])]
    # the disc: every ring further in has half the points, down to eight and the centre
    z = coefficient * inner * inner + offset
    around, number = rings[0], count
    while number > 8:
        number //= 2
        share = 0.3 + 0.7 * math.log(number / 8 + 1) / math.log(count / 8 + 1)  # roughly even edges
        within = ring(number, share * inner, z, False)
        for k in range(number):
            n = (k + 1) % number
            a, b, c = around[2 * k], around[2 * k + 1], around[(2 * k + 2) % len(around)]
            faces += [(within[k], a, b), (within[k], b, within[n]), (within[n], b, c)]
        around = within
    centre = len(vertices)
    vertices.append((0.0, 0.0, z))
    faces += [(centre, around[k], around[(k + 1) % number]) for k in range(number)]
    return Target("bowl", np.array(vertices), np.array(faces), closed=False)


MOST_AROUND = 512
"""Points around a bowl: the default one has 128."""


def _bowl_resolution(coefficient: float, inner: float, outer: float, error: float) -> tuple[int, int]:
    """Points per ring (8·2^k) and steps between rings (even) that keep a bowl's mesh within ``error``."""
    count = 8
    while outer * (1.0 - math.cos(math.pi / count)) > error:  # sagitta of the rim
        count *= 2
    while count <= MOST_AROUND:
        for steps in range(2, count // 2 + 1, 2):
            radii = [inner + (outer - inner) * i / steps for i in range(steps + 1)]
            gaps = [_gap(coefficient, *pair, count) for r, s in pairwise(radii) for pair in ((r, s), (s, r))]
            if max(gaps) <= error:
                return count, steps
        count *= 2
    expected = f"would need more than {MOST_AROUND} points around for this bowl: must be larger, or the bowl smaller"
    raise InputError("target.error", error, expected)


def _gap(coefficient: float, base: float, tip: float, count: int) -> float:
    """The largest distance to the bowl from a triangle with its base on one ring and its tip on another.

    A triangle of circumradius R is at most coefficient·R² above z = coefficient·r²; the surface leans, so the
    distance is less by the cosine of its slope.
    """
    half_base = base * math.sin(math.pi / count)
    height = abs(tip - base * math.cos(math.pi / count))
    radius = (height * height + half_base * half_base) / (2.0 * height)
    return abs(coefficient) * radius * radius / math.hypot(1.0, 2.0 * coefficient * min(base, tip))


def _circle(number: int, radius: float, staggered: bool) -> list[tuple[float, float]]:
    """``number`` (a multiple of 8) points of a circle, counter-clockwise, with all eight symmetries exact.

    Computed for angles up to 45° and copied by exchanging and negating coordinates. They start on the x
    axis, or half a step later if ``staggered``.
    """
    shift = 0.5 if staggered else 0.0
    eighth: list[tuple[float, float]] = []
    for k in range(number // 8 + (0 if staggered else 1)):
        angle = 2.0 * math.pi * (k + shift) / number
        eighth.append((radius * math.cos(angle), radius * math.sin(angle)))
    if not staggered:
        eighth[0] = (radius, 0.0)
        eighth[-1] = (radius * math.sqrt(0.5), radius * math.sqrt(0.5))
    mirrored = [(y, x) for x, y in reversed(eighth)]
    quarter = eighth + (mirrored if staggered else mirrored[1:-1])
    half = quarter + [(-y, x) for x, y in quarter]
    return half + [(-x, -y) for x, y in half]
