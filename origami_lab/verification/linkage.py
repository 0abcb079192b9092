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
from origami_lab.verification.loop_closure import Closure
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
class PanelTree:
    """The panels but the central one, each hung onto its parent by a crease; parents come first."""

    children: Indices
    """(F − 1,) their numbers."""
    parents: Indices
    creases: Indices
    hinges: Indices
    """A vertex on each crease."""
    along: Array
    """(F − 1, 3) flat unit vectors along the creases, with the child on the left."""
    levels: tuple[slice, ...]
    """What has its parents in the level before."""

    def summed(self, steps: Array, count: int) -> Array:
        """(F, …) what adds up of steps (F − 1, …) on the way from the central panel to each."""
        total = np.zeros((count, *steps.shape[1:]))
        for level in self.levels:
            total[self.children[level]] = total[self.parents[level]] + steps[level]
        return total


class Linkage:
    """The sheet as a linkage of rigid panels."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.flat = np.column_stack([sheet.points, np.zeros(len(sheet.points))])
        most = max((len(fan.edges) for fan in sheet.fans), default=0)
        around = np.full((len(sheet.fans), most), len(sheet.edges), dtype=np.int64)
        sectors = np.zeros((len(sheet.fans), most))
        for number, fan in enumerate(sheet.fans):
            around[number, : len(fan.edges)] = fan.edges
            sectors[number, : len(fan.edges)] = fan.sectors
        self._around, self._sectors = around, (np.cos(sectors), np.sin(sectors))

    def closure(self, rho: Array) -> Closure:
        """How far the loops are from closed, at fold angles (E,)."""
        product, directions = self._walked(rho)
        skew = np.stack(
            [
                product[:, 2, 1] - product[:, 1, 2],
                product[:, 0, 2] - product[:, 2, 0],
                product[:, 1, 0] - product[:, 0, 1],
            ],
            axis=1,
        )
        cosine = (product[:, 0, 0] + product[:, 1, 1] + product[:, 2, 2] - 1.0) / 2.0
        angle = np.arctan2(np.sqrt(np.einsum("fk,fk->f", skew, skew)) / 2.0, cosine)
        return Closure(skew / 2.0, angle, directions, self._around, len(rho))

    def _walked(self, rho: Array) -> tuple[Array, Array]:
        """(fans, 3, 3) products of the turns around all loops, (fans, D, 3) directions of the creases that are met.

        All loops are walked at once; beyond the end of its own a short one meets creases that do not turn.
        """
        fold = np.append(rho, 0.0)[self._around]
        c, s = np.cos(fold), np.sin(fold)
        cz, sz = self._sectors
        turns = np.zeros((*fold.shape, 3, 3))  # Rx(ρᵢ)·Rz(αᵢ)
        turns[..., 0, 0], turns[..., 0, 1] = cz, -sz
        turns[..., 1, 0], turns[..., 1, 1], turns[..., 1, 2] = c * sz, c * cz, -s
        turns[..., 2, 0], turns[..., 2, 1], turns[..., 2, 2] = s * sz, s * cz, c
        directions = np.empty((*fold.shape, 3))
        product = np.broadcast_to(np.eye(3), (len(fold), 3, 3))
        for i in range(fold.shape[1]):
            directions[:, i] = product[:, :, 0]
            product = product @ turns[:, i]
        directions[self._around == len(rho)] = 0.0
        return product, directions

    @cached_property
    def tree(self) -> PanelTree:
        """The tree of panels, from a central one outwards."""
        sheet = self.sheet
        neighbours = defaultdict(list)
        for e in np.flatnonzero(sheet.inner):
            left, right = (int(f) for f in sheet.beside[e])
            u, v = (int(end) for end in sheet.edges[e])
            neighbours[right].append((left, int(e), u, v))
            neighbours[left].append((right, int(e), v, u))
        root = int(np.argmin(self._off_centre()))
        rows: list[tuple[int, int, int, int, int]] = []
        seen, frontier, levels = {root}, [root], []
        while frontier:
            first = len(rows)
            for parent in frontier:
                for child, crease, start, end in neighbours[parent]:
                    if child not in seen:
                        seen.add(child)
                        rows.append((child, parent, crease, start, end))
            frontier = [row[0] for row in rows[first:]]
            levels.append(slice(first, len(rows)))
        children, parents, creases, starts, ends = np.array(rows, dtype=np.int64).reshape(-1, 5).T
        along = self.flat[ends] - self.flat[starts]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        return PanelTree(children, parents, creases, starts, along, tuple(levels[:-1]))

    def _off_centre(self) -> Array:
        """(F,) distances from the sheet's middle: a central panel makes a shallow tree."""
        sheet = self.sheet
        middles = np.array([sheet.points[list(face)].mean(axis=0) for face in sheet.faces])
        used = sheet.points[np.unique(sheet.edges)]
        centre = (used.min(axis=0) + used.max(axis=0)) / 2.0
        return np.asarray(np.linalg.norm(middles - centre, axis=1))

    def place(self, driving: float, rho: Array, speed: Array, residual: float) -> State:
        """Positions and velocities of all panels at fold angles and their derivatives (E,)."""
        tree, count = self.tree, len(self.sheet.faces)
        child, parent, hinge = tree.children, tree.parents, self.flat[tree.hinges]
        turns = _turn_about(tree.along, rho[tree.creases])
        # x = turn·X + shift, as 4 × 4 matrices
        hinged = np.zeros((len(child), 4, 4))
        hinged[:, :3, :3], hinged[:, 3, 3] = turns, 1.0
        hinged[:, :3, 3] = hinge - (turns @ hinge[:, :, None])[:, :, 0]
        placed = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
        for level in tree.levels:
            placed[child[level]] = placed[parent[level]] @ hinged[level]
        turn, shift = placed[:, :3, :3].copy(), placed[:, :3, 3].copy()
        spin = tree.summed(speed[tree.creases, None] * (turn[parent] @ tree.along[:, :, None])[:, :, 0], count)
        before, after = ((turn[panels] @ hinge[:, :, None])[:, :, 0] for panels in (parent, child))
        drift = tree.summed(cross(spin[parent], before) - cross(spin[child], after), count)
        return State(driving, rho, speed, turn, shift, spin, drift, residual)

    def vertices(self, state: State) -> Array:
        """(V, 3) folded positions, each on one of its panels; unused vertices are NaN."""
        out = np.full((len(self.flat), 3), np.nan)
        for index, face in enumerate(self.sheet.faces):
            ring = list(face)
            out[ring] = self.flat[ring] @ state.turn[index].T + state.shift[index]
        return out


def _turn_about(axis: Array, angle: Array) -> Array:
    """(N, 3, 3) rotations about unit vectors (N, 3): Rodrigues."""
    x, y, z = axis.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * skew + (1.0 - c) * (skew @ skew))
