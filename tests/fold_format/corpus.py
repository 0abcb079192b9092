"""Patterns in closed form and of the game, as plain arrays: what dialects are written from and compared with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs
from tests.known_designs.closed_forms import rotation, signed_angle
from tests.known_designs.fold_documents import known_design

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pattern:
    """A flat sheet and three states of it."""

    name: str
    flat: Array
    """(V, 2)"""
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]
    """Counter-clockwise."""
    letters: tuple[str, ...]
    folded: tuple[Array, ...]
    """(V, 3) each."""
    degrees: tuple[tuple[float, ...], ...]
    """Fold angles at each state."""
    one_freedom: bool = True
    """Whether no driven creases need be declared."""


def pattern(
    name: str, flat: Array, faces: Sequence[Sequence[int]], folded: Sequence[Array], one_freedom: bool = True
) -> Pattern:
    """A pattern from its panels and states; fold angles are measured, letters are those of the last state."""
    sides = {(u, v): f for f, face in enumerate(faces) for u, v in zip(face, (*face[1:], face[0]), strict=True)}
    edges = tuple(sorted({(min(side), max(side)) for side in sides}))
    inner = [(u, v) in sides and (v, u) in sides for u, v in edges]
    degrees = tuple(
        tuple(
            math.degrees(signed_angle(points, u, v, faces[sides[u, v]], faces[sides[v, u]])) if crease else 0.0
            for (u, v), crease in zip(edges, inner, strict=True)
        )
        for points in folded
    )
    letters = tuple(
        "B" if not crease else "V" if angle > 0 else "M" for crease, angle in zip(inner, degrees[-1], strict=True)
    )
    whole = tuple(tuple(int(v) for v in face) for face in faces)
    return Pattern(name, np.asarray(flat, float), edges, whole, letters, tuple(folded), degrees, one_freedom)


def of_design(name: str, design: CreasePattern, states: Sequence[int], one_freedom: bool = True) -> Pattern:
    """Some states of a design of ours."""
    return pattern(name, design.vertices, design.panels, [design.folded[k] for k in states], one_freedom)


def miura(rows: int, columns: int, gamma: float, thetas: Sequence[float], a: float = 1.0, b: float = 1.2) -> Pattern:
    """The Miura-ori of parallelograms with sides a, b and the acute angle γ (degrees), by Schenk and Guest."""
    tangent, sine = math.tan(math.radians(gamma)), math.sin(math.radians(gamma))

    def points(theta: float) -> Array:
        c = math.cos(theta) * tangent
        height, step = a * math.sin(theta) * sine, b * c / math.sqrt(1 + c * c)
        length, shift = a * math.sqrt(1 - (math.sin(theta) * sine) ** 2), b / math.sqrt(1 + c * c)
        return np.array(
            [
                (j * step, i * length + (j % 2) * shift, (i % 2) * height)
                for i in range(rows + 1)
                for j in range(columns + 1)
            ]
        )

    n = columns + 1
    faces = [
        (i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j) for i in range(rows) for j in range(columns)
    ]
    return pattern(f"miura {rows}×{columns}", points(0.0)[:, :2], faces, [points(theta) for theta in thetas])


def huffman(sectors: Sequence[float], turns: Sequence[float], way: int = 1) -> Pattern:
    """A vertex of degree four with any sectors, as in Huffman's study of such vertices: its spherical quadrilateral.

    Crease 0 is driven by ``turns``; crease 2 lies where two circles of the sphere meet, around creases 1 and 3.
    """
    one, two, three, four = sectors
    heading = np.radians(np.cumsum([0.0, *sectors[:3]]))
    tips = np.column_stack([np.cos(heading), np.sin(heading)]) * np.array([[2.0], [1.7], [2.3], [1.9]])
    flat = np.vstack([[0.0, 0.0], tips])
    cosine = [math.cos(math.radians(sector)) for sector in (two, three)]

    def fold(turn: float) -> Array:
        first = np.array([1.0, 0.0, 0.0])
        second = np.array([*np.array([math.cos(math.radians(one)), math.sin(math.radians(one))]), 0.0])
        # panel 3 lies on the right of crease 0: seen from panel 0 it turns by −turn for a valley's +turn
        last = rotation([1, 0, 0], -turn) @ [math.cos(math.radians(four)), -math.sin(math.radians(four)), 0.0]
        dot = float(second @ last)
        x, y = np.linalg.solve([[1.0, dot], [dot, 1.0]], cosine)
        across = np.cross(second, last)
        rest = 1.0 - (x * x + y * y + 2 * x * y * dot)
        assert rest >= 0.0
        third = x * second + y * last + way * math.sqrt(rest) / np.linalg.norm(across) * across
        length = np.linalg.norm(tips, axis=1)
        return np.vstack([[0, 0, 0], np.array([first, second, third, last]) * length[:, None]])

    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1)]
    return pattern(f"huffman {sectors}", flat, faces, [fold(math.radians(turn)) for turn in turns])


def corpus() -> dict[str, Pattern]:
    """All patterns by name."""
    found = [
        miura(3, 3, 60.0, (0.3, 0.6, 0.9)),
        miura(2, 5, 75.0, (0.2, 0.5, 0.7)),
        huffman((80.0, 95.0, 70.0, 115.0), (15.0, 40.0, 65.0)),
        huffman((100.0, 60.0, 110.0, 90.0), (10.0, 25.0, 50.0), way=-1),
        of_design("degree four", designs.degree_four(), (0, 1, 3)),
        of_design("degree four, other mode", designs.degree_four(mode="B"), (1, 2, 3)),
        of_design("valley", designs.single_valley(), (1, 3, 4)),
        of_design("pyramid of the game", known_design("pyramid"), (1, 3, 5), one_freedom=False),
        of_design("cube of the game", known_design("cube"), (1, 2, 4), one_freedom=False),
    ]
    return {p.name: p for p in found}
