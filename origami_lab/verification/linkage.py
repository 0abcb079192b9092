"""Panels turned about creases: closure of the loops around vertices, and where everything is.

Around an interior vertex with creases at fold angles ρᵢ and sectors αᵢ after them, counter-clockwise, the loop closes
when ∏ Rx(ρᵢ)·Rz(αᵢ) = I. Its derivative by ρᵢ is the direction of crease i in space: the columns of the
closure Jacobian. Panels are placed by walking a tree of creases away from a central panel, which stays in z = 0.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from origami_lab.verification.flat_sheet import Sheet
from origami_lab.verification.plane_graph import Array, Indices, cross


@dataclass(frozen=True, eq=False)
class State:
    """The folded sheet at one driving angle, and how it moves there."""

    driving: float
    rho: Array
    """(E,) fold angles."""
    speed: Array
    """(E,) their derivatives by the driving angle."""
    turn: Array
    """(F, 3, 3) orientation of each panel: x = turn·X + shift for flat X."""
    shift: Array
    """(F, 3)"""
    spin: Array
    """(F, 3) angular velocity."""
    drift: Array
    """(F, 3) derivative of ``shift``: ẋ = spin × (turn·X) + drift."""
    residual: float
    """Radians: the largest angle by which a loop fails to close."""


@dataclass(frozen=True, eq=False)
class _Ring:
    """The interior vertices of one degree."""

    at: Indices
    """(n,) numbers of their fans."""
    edges: Indices
    """(n, d)"""
    sectors: Array
    """(n, d, 3, 3) Rz(αᵢ)."""


class Linkage:
    """The sheet as a linkage of rigid panels."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        by_degree = defaultdict(list)
        for number, fan in enumerate(sheet.fans):
            by_degree[len(fan.edges)].append((number, fan))
        self.rings = [
            _Ring(
                np.array([number for number, _ in fans]),
                np.array([fan.edges for _, fan in fans], dtype=np.int64),
                _turn_z(np.array([fan.sectors for _, fan in fans])),
            )
            for fans in by_degree.values()
        ]
        self.flat = np.column_stack([sheet.points, np.zeros(len(sheet.points))])

    def closure(self, rho: Array) -> tuple[Array, Array, Array]:
        """How far the loops are from closed, at fold angles (E,).

        Returns
        -------
        error, jacobian, angle
            (3·fans,) rotation vectors to first order, (3·fans, E) their derivatives, (fans,) angles in radians.
        """
        count = len(self.sheet.fans)
        jacobian = np.zeros((count, 3, len(rho)))
        error, angle = self._around(rho, jacobian)
        return error.reshape(-1), jacobian.reshape(-1, len(rho)), angle

    def residuals(self, rho: Array) -> Array:
        """(fans,) angles in radians by which the loops fail to close, at fold angles (E,)."""
        return self._around(rho, None)[1]

    def _around(self, rho: Array, jacobian: Array | None) -> tuple[Array, Array]:
        """(fans, 3) errors and (fans,) angles; ``jacobian`` (fans, 3, E) is filled in."""
        count = len(self.sheet.fans)
        error, angle = np.zeros((count, 3)), np.zeros(count)
        for ring in self.rings:
            product = np.broadcast_to(np.eye(3), (len(ring.at), 3, 3))
            for i in range(ring.edges.shape[1]):
                edges = ring.edges[:, i]
                if jacobian is not None:
                    jacobian[ring.at, :, edges] = product[:, :, 0]
                product = product @ _turn_x(rho[edges]) @ ring.sectors[:, i]
            skew = np.stack(
                [
                    product[:, 2, 1] - product[:, 1, 2],
                    product[:, 0, 2] - product[:, 2, 0],
                    product[:, 1, 0] - product[:, 0, 1],
                ],
                axis=1,
            )
            error[ring.at] = skew / 2.0
            angle[ring.at] = np.arctan2(
                np.linalg.norm(skew, axis=1) / 2.0, (np.trace(product, axis1=1, axis2=2) - 1.0) / 2.0
            )
        return error, angle

    @cached_property
    def levels(self) -> list[tuple[Indices, Indices, Indices, Indices, Array]]:
        """The tree of panels, one level after the other: children, parents, creases, a vertex on each crease, its
        flat direction with the child on the left."""
        sheet = self.sheet
        neighbours = defaultdict(list)
        for e in np.flatnonzero(sheet.inner):
            left, right = (int(f) for f in sheet.beside[e])
            u, v = (int(end) for end in sheet.edges[e])
            neighbours[right].append((left, int(e), u, v))
            neighbours[left].append((right, int(e), v, u))
        root = int(np.argmin(self._off_centre()))
        levels: list[tuple[Indices, Indices, Indices, Indices, Array]] = []
        seen, frontier = {root}, [root]
        while frontier:
            rows = []
            for parent in frontier:
                for child, *hinge in neighbours[parent]:
                    if child not in seen:
                        seen.add(child)
                        rows.append((child, parent, *hinge))
            frontier = [row[0] for row in rows]
            if rows:
                children, parents, creases, starts, ends = np.array(rows, dtype=np.int64).T
                along = self.flat[ends] - self.flat[starts]
                along /= np.linalg.norm(along, axis=1, keepdims=True)
                levels.append((children, parents, creases, starts, along))
        return levels

    def _off_centre(self) -> Array:
        """(F,) distances from the sheet's middle: a central panel makes a shallow tree."""
        sheet = self.sheet
        middles = np.array([sheet.points[list(face)].mean(axis=0) for face in sheet.faces])
        used = sheet.points[np.unique(sheet.edges)]
        centre = (used.min(axis=0) + used.max(axis=0)) / 2.0
        return np.asarray(np.linalg.norm(middles - centre, axis=1))

    def place(self, driving: float, rho: Array, speed: Array, residual: float) -> State:
        """Positions and velocities of all panels at fold angles and their derivatives (E,)."""
        count = len(self.sheet.faces)
        turn = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
        shift, spin, drift = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
        for child, parent, e, u, along in self.levels:
            axis = np.einsum("nij,nj->ni", turn[parent], along)
            turn[child] = turn[parent] @ _turn_about(along, rho[e])
            before = np.einsum("nij,nj->ni", turn[parent], self.flat[u])
            after = np.einsum("nij,nj->ni", turn[child], self.flat[u])
            shift[child] = shift[parent] + before - after
            spin[child] = spin[parent] + speed[e, None] * axis
            drift[child] = drift[parent] + cross(spin[parent], before) - cross(spin[child], after)
        return State(driving, rho, speed, turn, shift, spin, drift, residual)

    def vertices(self, state: State) -> Array:
        """(V, 3) folded positions, each on one of its panels; unused vertices are NaN."""
        out = np.full((len(self.flat), 3), np.nan)
        for index, face in enumerate(self.sheet.faces):
            ring = list(face)
            out[ring] = self.flat[ring] @ state.turn[index].T + state.shift[index]
        return out


def _turn_x(angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    out = np.zeros((*np.shape(angle), 3, 3))
    out[..., 0, 0] = 1.0
    out[..., 1, 1], out[..., 1, 2], out[..., 2, 1], out[..., 2, 2] = c, -s, s, c
    return out


def _turn_z(angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    out = np.zeros((*np.shape(angle), 3, 3))
    out[..., 2, 2] = 1.0
    out[..., 0, 0], out[..., 0, 1], out[..., 1, 0], out[..., 1, 1] = c, -s, s, c
    return out


def _turn_about(axis: Array, angle: Array) -> Array:
    """(N, 3, 3) rotations about unit vectors (N, 3): Rodrigues."""
    x, y, z = axis.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * skew + (1.0 - c) * (skew @ skew))
