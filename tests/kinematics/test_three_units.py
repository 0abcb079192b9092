"""The vector form of the principle of three units against closed forms (design page, section 9, items 1–5).

One vertex of degree 4: creases 0 (incoming, folded by ρ0), 1 = a, 2 = c (middle), 3 = b, outward and
counter-clockwise; the sector angle αᵢ follows crease i; valleys are positive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from origami_lab.kinematics.three_units import frame_from_edge, hinge, lift, middle_crease, mirror_frames
from tests.known_designs.closed_forms import rotation
from tests.oracles import spherical_angle, spherical_triangle_exists
from tests.sheet_checks import rotation_x, rotation_z

Vector = tuple[float, float, float]
FLAT = np.array([[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Vertex:
    """A folded vertex of degree 4."""

    rho: tuple[float, float, float, float]
    creases: NDArray[np.float64]
    """(4, 3) unit directions in space."""


def fold(alpha: tuple[float, ...], rho0: float, mode: int) -> Vertex | None:
    """Solve a vertex with the package's kernels; None if there is no solution."""
    heading = np.cumsum([0.0, *alpha[:3]])
    flat = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    frames = [FLAT.copy() for _ in range(4)]  # panel i follows crease i; panel 3 stays
    hinge(frames[0], frames[3], 0, flat[0, 0], flat[0, 1], rho0)
    A, B = lift(frames[0], 0, *flat[1]), lift(frames[3], 0, *flat[3])
    exists, *C = middle_crease(A, B, math.cos(alpha[1]), math.cos(alpha[2]), mode)
    if not exists:
        return None
    frame_from_edge(frames[1], 0, tuple(C), tuple(np.cross(A, C)), *flat[2])
    frame_from_edge(frames[2], 0, tuple(C), tuple(np.cross(C, B)), *flat[2])
    creases = np.array([lift(frames[i], 0, *flat[i]) for i in range(4)])
    # panels carry both of their creases
    for i in range(4):
        np.testing.assert_allclose(lift(frames[i - 1], 0, *flat[i]), creases[i], atol=1e-9)
    normals = [np.cross(frame[0, :3], frame[0, 3:]) for frame in frames]
    rho = [math.atan2(np.cross(normals[i - 1], normals[i]) @ creases[i], normals[i - 1] @ normals[i]) for i in range(4)]
    return Vertex(tuple(rho), creases)  # type: ignore[arg-type]


angle = st.floats(0.15, math.pi - 0.15)
driving = st.floats(0.01, 3.14) | st.floats(-3.14, -0.01)
mode = st.sampled_from([-1, 1])


@st.composite
def sectors(draw: st.DrawFn) -> tuple[float, ...]:
    """Four sector angles in (0, π) with sum 2π; outer creases a, b not on one line, where a mode folds at once."""
    first = draw(st.tuples(angle, angle, angle))
    last = 2 * math.pi - sum(first)
    assume(0.15 < last < math.pi - 0.15 and abs(first[1] + first[2] - math.pi) > 0.02)
    return (*first, last)


def unit_angles(alpha: tuple[float, ...], rho0: float) -> tuple[float, float, float]:
    u1 = math.acos(math.cos(alpha[3]) * math.cos(alpha[0]) - math.sin(alpha[3]) * math.sin(alpha[0]) * math.cos(rho0))
    return u1, alpha[1], alpha[2]


@given(sectors(), driving, mode)
def test_loop_closure(alpha: tuple[float, ...], rho0: float, mode: int) -> None:
    vertex = fold(alpha, rho0, mode)
    assume(vertex is not None)
    assert vertex is not None
    product = np.eye(3)
    for rho, sector in zip(vertex.rho, alpha, strict=True):
        product = product @ rotation_x(np.array(rho)) @ rotation_z(np.array(sector))
    np.testing.assert_allclose(product, np.eye(3), atol=1e-9)


def test_golden_vertex() -> None:
    vertex = fold(tuple(np.radians([50, 80, 120, 110])), 0.8, +1)
    assert vertex is not None
    assert vertex.rho == pytest.approx((0.8, -0.35030, 0.73174, 0.33715), abs=1e-5)


@given(sectors(), driving, mode)
def test_opposite_creases_of_a_developable_vertex(alpha: tuple[float, ...], rho0: float, mode: int) -> None:
    vertex = fold(alpha, rho0, mode)
    assume(vertex is not None)
    assert vertex is not None
    sines = [math.sin(a) for a in alpha]
    ratio = math.sin(vertex.rho[0] / 2) ** 2 * sines[3] * sines[0]
    assert ratio == pytest.approx(math.sin(vertex.rho[2] / 2) ** 2 * sines[1] * sines[2], abs=1e-9)


@given(angle, angle, driving)
def test_flat_foldable_vertex(a: float, b: float, rho0: float) -> None:
    """Two modes: A with ρ2 = −ρ0 and B with ρ2 = ρ0."""
    assume(abs(a - b) > 0.05)
    assume(abs(a + b - math.pi) > 0.05)
    alpha, half = (a, b, math.pi - a, math.pi - b), math.tan(rho0 / 2)
    factors = {
        -1: math.sin((a + b) / 2) / math.sin((a - b) / 2),
        +1: -math.cos((a + b) / 2) / math.cos((a - b) / 2),
    }
    for relation, factor in factors.items():
        vertex = fold(alpha, rho0, relation if rho0 > 0 else -relation)
        assert vertex is not None
        expected = 2 * math.atan(factor * half)
        assert vertex.rho == pytest.approx((rho0, expected, relation * rho0, -relation * expected), abs=1e-8)


@pytest.mark.parametrize(("mode", "rho1"), [(-1, 2.09288), (+1, -0.62738)])
def test_golden_flat_foldable_vertex(mode: int, rho1: float) -> None:
    vertex = fold(tuple(np.radians([70, 40, 110, 140])), 1.0, mode)
    assert vertex is not None
    assert vertex.rho[1] == pytest.approx(rho1, abs=1e-5)


@given(st.floats(0.1, math.pi / 2 - 0.1), st.floats(0.05, 3.0))
def test_miura(gamma: float, rho0: float) -> None:
    vertex = fold((gamma, gamma, math.pi - gamma, math.pi - gamma), rho0, +1)
    assert vertex is not None
    assert abs(math.tan(vertex.rho[1] / 2)) == pytest.approx(math.cos(gamma) * math.tan(rho0 / 2), rel=1e-8)
    assert vertex.rho[2] == pytest.approx(rho0, abs=1e-8)


@given(sectors(), driving, mode)
def test_closed_form_of_the_principle_of_three_units(alpha: tuple[float, ...], rho0: float, mode: int) -> None:
    """θ by the spherical law of cosines, ρ2 = M(π − θ2); infeasible exactly when U_max > U_min + U_med."""
    u1, u2, u3 = unit_angles(alpha, rho0)
    slack = min(u1 + u2 - u3, u1 + u3 - u2, u2 + u3 - u1)
    assume(abs(slack) > 1e-6)
    vertex = fold(alpha, rho0, mode)
    assert (vertex is not None) == spherical_triangle_exists(u1, u2, u3) == (slack > 0)
    if vertex is not None:
        assert vertex.rho[2] == pytest.approx(mode * (math.pi - spherical_angle(u1, u2, u3)), abs=1e-7)
        # two spherical triangles stand on the side U1: of the incoming crease and of the middle one, on opposite
        # sides of the arc A–B if those fold the same way
        around_a = spherical_angle(alpha[3], alpha[0], u1), spherical_angle(u3, u2, u1)
        around_b = spherical_angle(alpha[0], alpha[3], u1), spherical_angle(u2, u3, u1)
        for rho, (known, new) in ((vertex.rho[1], around_a), (vertex.rho[3], around_b)):
            dihedral = known + new if rho0 * mode > 0 else abs(known - new)
            assert abs(rho) == pytest.approx(abs(math.pi - dihedral), abs=1e-6)


@given(sectors(), driving, mode)
def test_flipped_signs_mirror_the_vertex(alpha: tuple[float, ...], rho0: float, mode: int) -> None:
    one, other = fold(alpha, rho0, mode), fold(alpha, -rho0, -mode)
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert np.array_equal(one.creases * [1, 1, -1], other.creases)


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(-3, 3))
def test_hinge_is_a_rotation_about_the_crease(heading: float, turn: float, angle: float) -> None:
    u = np.array([math.cos(heading), math.sin(heading), 0.0])
    R = rotation([1.0, 2.0, -0.5], turn)
    out = np.zeros((1, 6))
    hinge(out, np.concatenate([R[:, 0], R[:, 1]])[None], 0, u[0], u[1], angle)
    np.testing.assert_allclose(out.reshape(2, 3).T, (R @ rotation(u, angle))[:, :2], atol=1e-12)


@pytest.mark.parametrize("matrix", [(-1, 0, 0, 1), (1, 0, 0, -1), (0, 1, 1, 0), (0, -1, 1, 0)])
def test_mirrored_frames_are_conjugated(matrix: tuple[int, int, int, int]) -> None:
    G = np.eye(3)
    G[:2, :2] = np.reshape(matrix, (2, 2))
    R = rotation([1.0, 2.0, -0.5], 1.1)
    out = np.zeros((1, 6))
    mirror_frames(out, np.concatenate([R[:, 0], R[:, 1]])[None], 0, *matrix)
    np.testing.assert_array_equal(out.reshape(2, 3).T, (G @ R @ G.T)[:, :2])


@given(st.floats(0.0, 1e-3), mode)
def test_accurate_where_the_outer_creases_are_nearly_parallel(width: float, mode: int) -> None:
    """A and B an angle 2·width apart, C on their bisecting plane at U2 = U3 = 1."""
    A, B = (math.cos(width), math.sin(width), 0.0), (math.cos(width), -math.sin(width), 0.0)
    exists, *C = middle_crease(A, B, math.cos(1.0), math.cos(1.0), mode)
    if width < 1e-11:
        assert not exists  # the middle crease is free to swing: not one degree of freedom
    elif width > 1e-6:
        x = math.cos(1.0) / math.cos(width)
        assert pytest.approx([x, 0.0, mode * math.sqrt(1 - x * x)], abs=1e-9) == C
