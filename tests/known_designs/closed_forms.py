"""Designs made by hand from closed forms, without the game and its kinematics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.crease_pattern import CreasePattern

Array = NDArray[np.float64]

DRIVING_ANGLES: Array = 3.14 * np.arange(1, 11) / 10
"""The ten driving angles of the paper, radians."""


def rotation(axis: Sequence[float] | Array, angle: float) -> Array:
    """(3, 3) rotation about ``axis`` by ``angle``: Rodrigues."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)


def panel_normal(points: Array, panel: Sequence[int]) -> Array:
    """(3,) unit normal of a planar polygon by Newell's sum."""
    ring = points[list(panel)]
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


def signed_angle(points: Array, u: int, v: int, left: Sequence[int], right: Sequence[int]) -> float:
    """The fold angle of crease u→v between the panels on its left and right; valley positive."""
    n_left, n_right = panel_normal(points, left), panel_normal(points, right)
    along = points[v] - points[u]
    return float(
        np.arctan2(np.cross(n_right, n_left) @ along / np.linalg.norm(along), np.clip(n_left @ n_right, -1, 1))
    )


def design(
    vertices: Sequence[Sequence[float]],
    panels: Sequence[Sequence[int]],
    fold: Callable[[float], Array],
    *,
    best: int,
    driven: Sequence[tuple[int, int]] = (),
    modes: Sequence[int] | None = None,
    driving_angles: Array = DRIVING_ANGLES,
    **metadata: object,
) -> CreasePattern:
    """A pattern from its panels and the folded positions; fold angles are measured on those."""
    sides: dict[tuple[int, int], int] = {}
    for index, panel in enumerate(panels):
        for u, v in zip(panel, [*panel[1:], panel[0]], strict=True):
            assert (u, v) not in sides
            sides[u, v] = index
    edges = sorted({(min(edge), max(edge)) for edge in sides})
    folded = np.array([fold(angle) for angle in driving_angles])
    angles = np.zeros((len(driving_angles), len(edges)))
    boundary = np.array([(u, v) not in sides or (v, u) not in sides for u, v in edges])
    for e, (u, v) in enumerate(edges):
        if not boundary[e]:
            for k, points in enumerate(folded):
                angles[k, e] = signed_angle(points, u, v, panels[sides[u, v]], panels[sides[v, u]])
    fan = [(p[0], p[i], p[i + 1], index) for index, p in enumerate(panels) for i in range(1, len(p) - 1)]
    sources = {(min(edge), max(edge)) for edge in driven}
    return CreasePattern(
        vertices=np.array(vertices, dtype=float),
        modes=np.array(modes if modes is not None else [0] * len(vertices), dtype=np.int8),
        edges=np.array(edges, dtype=np.int32),
        boundary=boundary,
        driven=np.array([edge in sources for edge in edges]),
        fold_angles=angles,
        panels=tuple(tuple(panel) for panel in panels),
        triangles=np.array([t[:3] for t in fan], dtype=np.int32),
        triangle_panels=np.array([t[3] for t in fan], dtype=np.int32),
        driving_angles=np.array(driving_angles),
        folded=folded,
        best=best,
        actions=(3, 1, 4),
        metadata=MappingProxyType(metadata),
    )


def single_valley(best: int = 4) -> CreasePattern:
    """A 4×3 rectangle with one valley crease along x = 1; the left panel stays in z = 0."""
    vertices = [(-1.0, -1.0), (1.0, -1.0), (3.0, -1.0), (3.0, 2.0), (1.0, 2.0), (-1.0, 2.0)]

    def fold(rho: float) -> Array:
        x, z = 1 + 2 * np.cos(rho), 2 * np.sin(rho)
        return np.array([(-1, -1, 0), (1, -1, 0), (x, -1, z), (x, 2, z), (1, 2, 0), (-1, 2, 0)])

    panels = [(0, 1, 4, 5), (1, 2, 3, 4)]
    return design(vertices, panels, fold, best=best, driven=[(1, 4)], task="valley", search="hand", seed=0)


def degree_four(alpha_deg: float = 70.0, beta_deg: float = 40.0, mode: str = "A", best: int = 3) -> CreasePattern:
    """A flat-foldable vertex of degree 4 with sectors (α, β, π−α, π−β) and creases of different lengths.

    Mode A: ρ2 = −ρ0, ρ1 = ρ3, tan(ρ1/2) = sin((α+β)/2)/sin((α−β)/2)·tan(ρ0/2);
    mode B: ρ2 = ρ0, ρ3 = −ρ1, tan(ρ1/2) = −cos((α+β)/2)/cos((α−β)/2)·tan(ρ0/2). Crease 0 is driven and lies
    along x; panel i lies between creases i and i+1; panel 3 stays in the plane z = 0. The stored fold angles
    are those formulas, not measured.
    """
    alpha, beta = np.radians([alpha_deg, beta_deg])
    sectors = np.array([alpha, beta, np.pi - alpha, np.pi - beta])
    direction = np.concatenate([[0.0], np.cumsum(sectors)[:3]])
    lengths = np.array([2.0, 3.0, 2.5, 1.5])
    tips = lengths[:, None] * np.column_stack([np.cos(direction), np.sin(direction)])
    flat = np.vstack([[0.0, 0.0], tips])
    panels = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1)]

    def angles(rho: float) -> Array:
        tangent = np.tan(rho / 2)
        if mode == "A":
            other = 2 * np.arctan(np.sin((alpha + beta) / 2) / np.sin((alpha - beta) / 2) * tangent)
            return np.array([rho, other, -rho, other])
        other = -2 * np.arctan(np.cos((alpha + beta) / 2) / np.cos((alpha - beta) / 2) * tangent)
        return np.array([rho, other, rho, -other])

    def fold(rho: float) -> Array:
        points = np.column_stack([flat, np.zeros(5)])
        orientation = np.eye(3)  # of panel 3, right of crease 0
        out = points.copy()
        for crease, turn in enumerate(angles(rho)):
            out[crease + 1] = orientation @ points[crease + 1]
            orientation = orientation @ rotation(points[crease + 1], turn)
        assert np.allclose(orientation, np.eye(3), atol=1e-12)  # the loop closes
        return out

    made = design(flat.tolist(), panels, fold, best=best, driven=[(0, 1)], modes=[1, 0, 0, 0, 0], task="degree 4")
    stored = made.fold_angles.copy()
    for e, (u, v) in enumerate(made.edges):
        if u == 0:
            stored[:, e] = [angles(rho)[v - 1] for rho in made.driving_angles]
    object.__setattr__(made, "fold_angles", stored)
    return made


def miura(gamma_deg: float = 60.0, best: int = 5) -> CreasePattern:
    """A Miura vertex, sectors (γ, γ, π−γ, π−γ), mode B: |tan(ρ1/2)| = cosγ·|tan(ρ0/2)|."""
    return degree_four(gamma_deg, gamma_deg, "B", best)


def pyramid(best: int = 5) -> CreasePattern:
    """The known pyramid: square of half-width 1, flaps of height 3, pleats at the corners folded inside."""
    square = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
    tips = [(0.0, 4.0), (-4.0, 0.0), (0.0, -4.0), (4.0, 0.0)]
    pleats = [(-2.0, 2.0), (-2.0, -2.0), (2.0, -2.0), (2.0, 2.0)]
    panels: list[tuple[int, ...]] = [(0, 1, 2, 3)]
    for i in range(4):
        corner, after, tip, following = i, (i + 1) % 4, 4 + i, 4 + (i + 1) % 4
        panels += [(corner, tip, after), (after, tip, 8 + i), (after, 8 + i, following)]

    def fold(rho: float) -> Array:
        lean, height = 1 + 3 * np.cos(rho), 3 * np.sin(rho)
        tops = [(0, lean, height), (-lean, 0, height), (0, -lean, height), (lean, 0, height)]
        # The pleat's end lies in the diagonal plane at (−t, t, h): √2 from the corner, 2√2 from both tips.
        # |·−corner|² = 2(t−1)² + h² = 2 and |·−tip|² = t² + (t−lean)² + (h−height)² = 8: subtract.
        # −4t + 2 − (−2·lean·t + lean² − 2·h·height + height²) = −6   →   h = p + q·t
        p = (lean**2 + height**2 - 8) / (2 * height)
        q = (4 - 2 * lean) / (2 * height)
        t = np.roots([2 + q * q, 2 * p * q - 4, p * p])
        inner = min(t.real)  # a mountain pleat lies inside
        ends = [(sx * inner, sy * inner, p + q * inner) for sx, sy in np.sign(pleats)]
        return np.array([(*corner, 0.0) for corner in square] + tops + ends)

    return design(
        [*square, *tips, *pleats],
        panels,
        fold,
        best=best,
        driven=[(0, 1), (1, 2), (2, 3), (3, 0)],
        modes=[-1] * 4 + [0] * 8,
        task="pyramid",
        search="bfts",
        seed=3,
        board=9,
        **{"return": -3 * float(np.sin(np.arccos(-1 / 3) - 1.884))},
    )


def pleated_bowl(spokes: int = 20, rings: int = 6) -> CreasePattern:
    """A large pattern for pictures only: a pleated disc bent into the bowl z = 0.2r² − 0.6. NOT rigid."""
    radii = np.concatenate([[0.0], np.linspace(1.6, 10.0, rings)])
    flat: list[tuple[float, float]] = [(0.0, 0.0)]
    for j, r in enumerate(radii[1:]):
        phase = np.pi / spokes * (j % 2)
        flat += [
            (
                float(r * np.cos(2 * np.pi * i / spokes + phase)),
                float(r * np.sin(2 * np.pi * i / spokes + phase)),
            )
            for i in range(spokes)
        ]
    panels: list[tuple[int, ...]] = [(0, 1 + i, 1 + (i + 1) % spokes) for i in range(spokes)]
    for j in range(rings - 1):
        low, high = 1 + j * spokes, 1 + (j + 1) * spokes
        for i in range(spokes):
            k = (i + 1) % spokes
            if j % 2 == 0:
                panels += [(low + i, high + i, low + k), (low + k, high + i, high + k)]
            else:
                panels += [(low + i, high + i, high + k), (low + i, high + k, low + k)]
    points = np.array(flat)
    ring = np.array([0] + [j + 1 for j in range(rings) for _ in range(spokes)])

    def fold(rho: float) -> Array:
        share = rho / 1.884
        r = np.hypot(*points.T)
        bent = r * (1 - 0.5 * share * (r / 10.0) ** 0.5) + 0.12 * share * (-1.0) ** ring * (r > 2)
        bent = np.maximum(bent, 0.0)
        z = share * (0.2 * np.maximum(bent, 1.6) ** 2 - 0.512 + 0.10 * (-1.0) ** ring)
        scale = np.where(r > 0, bent / np.maximum(r, 1e-9), 1.0)
        return np.column_stack([points * scale[:, None], z])

    modes = [1, *((-1) ** (i + j) for j in range(rings - 1) for i in range(spokes)), *[0] * spokes]
    return design(
        flat,
        panels,
        fold,
        best=5,
        driven=[(1 + i, 1 + (i + 1) % spokes) for i in range(0, spokes, 5)],
        modes=modes,
        driving_angles=DRIVING_ANGLES[:7],
        task="bowl",
        search="bfts",
        seed=0,
        board=25,
        **{"return": -0.7123456},
    )


def bowl_mesh(segments: int = 96, rings: int = 24) -> tuple[Array, NDArray[np.int64]]:
    """The paper's bowl as (V, 3) vertices and (F, 3) faces: z = 0.2r² − 0.6 for 1.6 ≤ r ≤ 5 and its floor."""
    radii = np.linspace(1.6, 5.0, rings)
    angle = 2 * np.pi * np.arange(segments) / segments
    points = [(0.0, 0.0, 0.2 * 1.6**2 - 0.6)]
    points += [(r * np.cos(a), r * np.sin(a), 0.2 * r * r - 0.6) for r in radii for a in angle]
    faces = [(0, 1 + i, 1 + (i + 1) % segments) for i in range(segments)]
    for j in range(rings - 1):
        low, high = 1 + j * segments, 1 + (j + 1) * segments
        for i in range(segments):
            k = (i + 1) % segments
            faces += [(low + i, high + i, high + k), (low + i, high + k, low + k)]
    return np.array(points), np.array(faces, dtype=np.int64)


def pyramid_mesh() -> tuple[Array, NDArray[np.int64]]:
    """The paper's pyramid: base of half-width 1, apex at √8; closed."""
    points = np.array([(1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0), (0, 0, np.sqrt(8))], dtype=float)
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)]
    return points, np.array(faces, dtype=np.int64)
