"""The whole sheet of a state, images included: flat and folded. This is what an objective sees."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import SINGLE, States


@dataclass(frozen=True, eq=False)
class FoldedSheet:
    """Read-only view of a state's sheet with ``V`` vertices, ``T`` triangles and ``C`` creases.

    Holds references to the state: it is valid until that state is played on.
    """

    states: States
    index: int
    rules: States

    @property
    def reach(self) -> int:
        """How many driving angles, from flat up, the motion reaches."""
        return int(self.states["reach"][self.index])

    @property
    def first(self) -> int:
        """Index of the first driving angle at which a design may be used; the last one where the angle is fixed."""
        return int(self.rules["min_reach"][0]) - 1

    @cached_property
    def _numbers(self) -> NDArray[np.int64]:
        """(R, g) number of each representative's image under each group element."""
        state, rules = self.states[self.index], self.rules[0]
        n, order = int(state["n_vertices"]), int(rules["order"])
        axis, products = state["axis"][:n], rules["products"]
        numbers = np.empty((n, order), dtype=np.int64)
        count = 0
        for v in range(n):
            for g in range(order):
                twin = 0 if axis[v] == SINGLE else int(products[g, axis[v]]) if axis[v] > 0 else g
                if twin < g:
                    numbers[v, g] = numbers[v, twin]
                else:
                    numbers[v, g] = count
                    count += 1
        return numbers

    def _expand(self, codes: NDArray[np.int32], g: int) -> NDArray[np.int64]:
        """Vertex numbers of the images of codes under a group element."""
        products = self.rules[0]["products"]
        return self._numbers[codes >> 3, products[g, codes & 7]]

    @cached_property
    def flat(self) -> NDArray[np.int64]:
        """(V, 2) vertices on the board."""
        state, rules = self.states[self.index], self.rules[0]
        numbers = self._numbers
        out = np.empty((int(numbers.max(initial=-1)) + 1, 2), dtype=np.int64)
        xy = state["xy"][: len(numbers)]
        for g in range(numbers.shape[1]):
            out[numbers[:, g]] = xy @ rules["matrices"][g].reshape(2, 2).T
        return out

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """(reach, V, 3) folded vertices at each reachable driving angle, in board cells."""
        state, rules = self.states[self.index], self.rules[0]
        numbers = self._numbers
        out = np.empty((self.reach, len(self.flat), 3))
        position = state["position"][: len(numbers), : self.reach].transpose(1, 0, 2)
        for g in range(numbers.shape[1]):
            out[:, numbers[:, g], :2] = position[:, :, :2] @ rules["matrices"][g].reshape(2, 2).T
            out[:, numbers[:, g], 2] = position[:, :, 2]
        out.flags.writeable = False
        return out

    @cached_property
    def triangles(self) -> NDArray[np.int64]:
        """(T, 3) vertex numbers, counter-clockwise on the board."""
        state, rules = self.states[self.index], self.rules[0]
        n = int(state["n_triangles"])
        corners, images = state["corners"][:n], state["images"][:n]
        parts = []
        for g in range(int(rules["order"])):
            mirror = rules["products"][g][np.maximum(images, 0)]
            kept = (images == 0) | ((images > 0) & (g < mirror)) | ((images == SINGLE) & (g == 0))
            part = self._expand(corners[kept], g)
            a, b, c, d = (int(m) for m in rules["matrices"][g])
            parts.append(part if a * d - b * c > 0 else part[:, ::-1])
        return np.concatenate(parts) if parts else np.empty((0, 3), dtype=np.int64)

    @cached_property
    def creases(self) -> dict[tuple[int, int], int]:
        """Vertex pairs (smaller first) of all creases, with the sign of a driven one and 0 for the others."""
        state, rules = self.states[self.index], self.rules[0]
        n = int(state["n_creases"])
        out: dict[tuple[int, int], int] = {}
        for g in range(int(rules["order"])):
            for (u, v), sign in zip(self._expand(state["creases"][:n], g), state["driven"][:n], strict=True):
                out[(int(min(u, v)), int(max(u, v)))] = int(sign)
        return out

    @cached_property
    def modes(self) -> NDArray[np.int8]:
        """(V,) rigid body mode of extended vertices, 0 for leaves."""
        state = self.states[self.index]
        out = np.zeros(len(self.flat), dtype=np.int8)
        for g in range(self._numbers.shape[1]):
            out[self._numbers[:, g]] = state["modes"][: len(self._numbers)]
        return out

    @property
    def leaves(self) -> NDArray[np.int64]:
        """(L,) numbers of the vertices that are not extended: the boundary of the sheet."""
        return np.flatnonzero(self.modes == 0)
