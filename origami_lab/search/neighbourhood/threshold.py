"""What lies too far from the target: the aspiration threshold of a run, at its one driving angle.

A placed vertex never moves, nor does a panel. So a sheet with a vertex (or, where panels count, with a point of a
panel) further than the threshold from the target can never become a design that good, and the place of a child shows
it before the child is played.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.boundary import NEXT, PREV
from origami_lab.game.kernels.collisions import place_corner
from origami_lab.game.kernels.extension import middle_place, outer_place
from origami_lab.game.kernels.legal_actions import placing_side
from origami_lab.game.kernels.state import ALL_IMAGES, THIRD, Record, board_points, point_x, point_y
from origami_lab.jit import bare, inlined
from origami_lab.objectives.known_places import Surface, strayed_squared

ROUNDING = 1e-12
"""Relative: a place at the threshold to within this does not stray."""


class Aim(NamedTuple):
    """What a run aims at.

    Attributes
    ----------
    target
        What the sheet must stay near.
    angle
        Index of the run's driving angle.
    threshold
        The distance to be reached, in board cells.
    spacing
        Of the points inside panels that must stay near, too, in board cells; 0 for vertices only.
    """

    target: Surface
    angle: int
    threshold: float
    spacing: float


@bare
def place_strays(s: Record, r: Record, aim: Aim, x: float, y: float, z: float) -> bool:
    """Whether a folded place, or one of its images, is further than the threshold from the target.

    What compactness takes off for the place alone counts as distance.
    """
    target = aim.target
    limit = aim.threshold * (1.0 + ROUNDING)
    if target.compactness > 0.0:
        limit -= target.compactness * np.sqrt(x * x + y * y + z * z)
        if limit < 0.0:
            return True
    limit *= limit
    for g in range(r.order if target.images else 1):
        gx = r.matrices[g, 0] * x + r.matrices[g, 1] * y
        gy = r.matrices[g, 2] * x + r.matrices[g, 3] * y
        # looked for up to a little more than the limit
        squared, s.near = strayed_squared(target, gx, gy, z, limit, limit + 1e-6 * limit + 1e-30, s.near, s.far)
        if squared > limit:
            return True
    return False


@bare
def triangle_strays(s: Record, r: Record, aim: Aim, p: NDArray[np.float64]) -> bool:
    """Whether a point of a regular grid on the folded triangle p (3, 3), its corners left out, strays."""
    longest = 0.0
    for i in range(3):
        j = (i + 1) % 3
        # the middle of an edge strays most often
        x, y, z = 0.5 * (p[i, 0] + p[j, 0]), 0.5 * (p[i, 1] + p[j, 1]), 0.5 * (p[i, 2] + p[j, 2])
        if place_strays(s, r, aim, x, y, z):
            return True
        longest = max(longest, (p[i, 0] - p[j, 0]) ** 2 + (p[i, 1] - p[j, 1]) ** 2 + (p[i, 2] - p[j, 2]) ** 2)
    n = int(np.ceil(np.sqrt(longest) / aim.spacing))
    for a in range(n + 1):
        for b in range(n + 1 - a):
            c = n - a - b
            if max(a, b, c) == n:
                continue
            u, v, w = a / n, b / n, c / n
            x = u * p[0, 0] + v * p[1, 0] + w * p[2, 0]
            y = u * p[0, 1] + v * p[1, 1] + w * p[2, 1]
            z = u * p[0, 2] + v * p[1, 2] + w * p[2, 2]
            if place_strays(s, r, aim, x, y, z):
                return True
    return False


@bare
def sheet_strays(s: Record, r: Record, aim: Aim, first_vertex: int, first_triangle: int) -> bool:
    """Whether a vertex from ``first_vertex`` on, or a panel from ``first_triangle`` on, strays."""
    k = aim.angle
    for v in range(first_vertex, s.n_vertices):
        if place_strays(s, r, aim, s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]):
            return True
    if aim.spacing > 0.0:
        p = s.triangle
        for t in range(first_triangle, s.n_triangles):
            for j in range(3):
                place_corner(s, r, s.corners[t, j], k, p, j)
            if triangle_strays(s, r, aim, p):
                return True
    return False


@bare
def seam_strays(s: Record, r: Record, aim: Aim, first_triangle: int) -> bool:
    """Whether a panel over a seam between images strays: the others are known from the places of their corners."""
    p = s.triangle
    for t in range(first_triangle, s.n_triangles):
        if s.images[t] != ALL_IMAGES:
            for j in range(3):
                place_corner(s, r, s.corners[t, j], aim.angle, p, j)
            if triangle_strays(s, r, aim, p):
                return True
    return False


@inlined
def set_corner(p: NDArray[np.float64], row: int, place: tuple[float, float, float]) -> None:
    p[row, 0], p[row, 1], p[row, 2] = place


@bare
def child_strays(s: Record, r: Record, aim: Aim, action: int) -> bool:
    """Whether the child that a location action places strays, or a panel it completes, or it does not exist.

    All from the closed forms of its place at the run's driving angle: nothing is played.
    """
    k, v = aim.angle, s.selected
    index = action - 2 * board_points(r)
    qx, qy = point_x(r, index), point_y(r, index)
    p = s.triangle
    if s.phase != THIRD:
        side = placing_side(s, r)
        place = outer_place(s, r, k, side, qx, qy)
        if place_strays(s, r, aim, place[0], place[1], place[2]):
            return True
        if aim.spacing > 0.0:
            place_corner(s, r, 8 * v, k, p, 0)
            place_corner(s, r, s.prev[v] if side == PREV else s.next[v], k, p, 1)
            set_corner(p, 2, place)
            return triangle_strays(s, r, aim, p)
        return False
    exists, x, y, z = middle_place(s, r, k, qx, qy)
    if not exists or place_strays(s, r, aim, x, y, z):
        return True
    if aim.spacing > 0.0:
        place_corner(s, r, 8 * v, k, p, 0)
        set_corner(p, 1, (x, y, z))
        set_corner(p, 2, outer_place(s, r, k, PREV, s.first_x, s.first_y))
        if triangle_strays(s, r, aim, p):
            return True
        if s.axis[v] > 0 and not aim.target.images:
            return False  # the other side is an image
        set_corner(p, 2, outer_place(s, r, k, NEXT, s.second_x, s.second_y))
        return triangle_strays(s, r, aim, p)
    return False
