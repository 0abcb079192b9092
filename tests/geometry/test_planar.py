"""Planar predicates against rational and floating-point geometry on the integer board."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from origami_lab.geometry.planar import cross, in_sector, segments_touch, triangle_contains, turn
from tests.oracles import angle_between
from tests.sheet_checks import segments_meet

coordinate = st.integers(-4, 4)
point = st.tuples(coordinate, coordinate)
direction = point.filter(lambda d: d != (0, 0))


@given(direction, direction)
def test_cross_is_positive_for_a_left_turn_below_pi(a: tuple[int, int], b: tuple[int, int]) -> None:
    angle = angle_between(a, b)
    assert (cross(*a, *b) > 0) == (1e-9 < angle < math.pi - 1e-9)


@given(point, point, point)
def test_turn_is_twice_the_area(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> None:
    matrix = np.array([[*a, 1], [*b, 1], [*c, 1]], dtype=float)
    assert turn(*a, *b, *c) == round(float(np.linalg.det(matrix)))


@given(direction, direction, direction)
def test_in_sector(p: tuple[int, int], n: tuple[int, int], d: tuple[int, int]) -> None:
    width = angle_between(p, n) if angle_between(p, n) > 1e-9 else 2 * math.pi
    assert in_sector(*p, *n, *d) == (angle_between(p, d) <= width + 1e-9)


@given(point, point, point, point)
def test_triangle_contains(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int], q: tuple[int, int]) -> None:
    area = turn(*a, *b, *c)
    if area <= 0:
        return
    weights = [Fraction(turn(*b, *c, *q), area), Fraction(turn(*c, *a, *q), area), Fraction(turn(*a, *b, *q), area)]
    assert sum(weights) == 1
    assert triangle_contains(*a, *b, *c, *q) == (min(weights) >= 0)


@given(point, point, point, point)
def test_segments_touch(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int], d: tuple[int, int]) -> None:
    meets = bool(segments_meet(*(np.array([p]) for p in (a, b, c, d)))[0])
    assert segments_touch(*a, *b, *c, *d) == meets == segments_touch(*d, *c, *a, *b)
