"""Observations of a state for an agent (paper, appendix A, PPO): the paper's tensor, and a compact equivalent.

Both hold the crease graph as it stands: the vertices in order of appearance, their rigid body modes, the creases, which
of them are driven and with what sign, and the vertex that is being extended with the children chosen for it so far.

**Tensor**, (w, h, V + 2) of −1, 0, 1 on a board of w × h points, indices [x, y, k] from its lower left corner. k = 0:
the mode of the vertex at the point. k = 1 … V: its creases, to the k-th vertex of the sheet, mirror images counted: 1
for an outgoing crease, −1 for an incoming one. A driven crease has no direction: its sign stands at both ends.
k = V + 1: 1 at the vertex that is being extended, and at its images, and at the corners that are chosen for the start
pattern; everywhere the sign of a source whose place on the boundary is to be chosen. The paper's V is w · h.

**Compact**, a vector of some numbers for each playable point of the board, then one for each phase of the game. A point
holds, all in [−1, 1]: (order of appearance + 1) / number of playable points, 0 where there is no vertex; its mode;
whether it is being extended, or is chosen for the start pattern; the offsets (x, y) of up to three children, in units
of the board's longer side; offset and sign of up to two driven creases. The phase is 1, or the sign of a source that is
begun anywhere on the boundary. Images and their creases follow from the symmetry, so nothing is lost. On the bowl's
board it is 1,370 numbers; the paper's tensor is 391,875.

With sources anywhere on the boundary a vertex may get one driven crease after another, so each stands at its younger
end alone. Two places suffice for that: what comes to lie beside a leaf on the boundary is always a new vertex, because
an extension that merges with the leaf puts its middle child there; so at most two of its driven creases, to those
beside which it began, lead to vertices that are older or its own images.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.boundary import PREV, near_side
from origami_lab.game.kernels.state import (
    ON_BOUNDARY,
    PLACEMENT,
    SECOND,
    SELECTION,
    THIRD,
    Record,
    States,
    axis_of,
    code_x,
    code_y,
    image_code,
    point_index,
)
from origami_lab.jit import inlined, kernel

FEATURES = 15
"""Numbers for each playable point in the compact observation."""
PHASES = THIRD + 1

_ORDER, _MODE, _CURRENT, _CHILDREN, _DRIVEN = 0, 1, 2, 3, 9

Slots = NDArray[np.int32]
Image = NDArray[np.int8]


class View(Protocol):
    """A way to see states as arrays of ``shape`` and ``dtype`` with values in [−1, 1]."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    def write(self, states: States, i: int, out: NDArray[Any]) -> None:
        """Fill ``out`` with what is seen of state i."""
        ...


def view_of(game: Game, observation: str = "compact", vertices: int | None = None) -> View:
    """The view with that name: ``compact`` or ``tensor``.

    Parameters
    ----------
    vertices
        V of the tensor: later vertices are still seen, but not what is connected to them. None for all points.

    Raises
    ------
    InputError
        For any other name, or a number of vertices that is none.
    """
    if observation == "compact":
        return CompactView(game)
    if observation == "tensor":
        return TensorView(game, vertices)
    raise InputError("observation", observation, "must be compact or tensor")


class CompactView:
    """The compact observation, (features · playable points + PHASES,) float32."""

    def __init__(self, game: Game) -> None:
        playable = game.rules.playable_points
        self.count = int(playable.sum())
        self.shape: tuple[int, ...] = (FEATURES * self.count + PHASES,)
        self.dtype = np.dtype(np.float32)
        self._rules = game.rules.record
        self._slots = np.where(playable, np.cumsum(playable) - 1, -1).astype(np.int32)

    def write(self, states: States, i: int, out: NDArray[Any]) -> None:
        """Fill ``out`` with what is seen of state i."""
        write_compact(states, i, self._rules, self._slots, self.count, out)


class TensorView:
    """The paper's tensor, (w, h, V + 2) int8."""

    def __init__(self, game: Game, vertices: int | None = None) -> None:
        most = game.rules.points
        if vertices is not None and (
            isinstance(vertices, bool) or not isinstance(vertices, int) or not 1 <= vertices <= most
        ):
            expected = f"must be a whole number from 1 to {most}, the points of the board, or null for all of them"
            raise InputError("vertices", vertices, expected)
        self.shape: tuple[int, ...] = (*game.board, (most if vertices is None else vertices) + 2)
        self.dtype = np.dtype(np.int8)
        self._rules = game.rules.record

    def write(self, states: States, i: int, out: NDArray[Any]) -> None:
        """Fill ``out`` with what is seen of state i."""
        write_tensor(states, i, self._rules, out)


def possible_actions(game: Game) -> NDArray[np.int64]:
    """(m,) the actions that can ever be legal: all but those that name a point which is not playable."""
    points = np.flatnonzero(game.rules.playable_points)
    rest = np.arange(3 * game.rules.points, game.rules.n_actions)
    return np.concatenate([points, points + game.rules.points, points + 2 * game.rules.points, rest])


# --- compact ---------------------------------------------------------------------------------------------------------


@kernel
def write_compact(states: States, i: int, rules: States, slots: Slots, count: int, out: NDArray[np.float32]) -> None:
    """Fill the compact observation; ``slots`` numbers the ``count`` playable points among all, −1 for the others."""
    s, r = states[i], rules[0]
    out[:] = 0.0
    unit = 1.0 / (2 * max(r.half_x, r.half_y))
    # a sign is chosen before the place of a source on the boundary
    out[FEATURES * count + s.phase] = 1.0 if s.phase != PLACEMENT or s.n_vertices == 0 else s.mode
    for v in range(s.n_vertices):
        at = FEATURES * slots[point_index(r, s.xy[v, 0], s.xy[v, 1])]
        out[at + _ORDER] = (v + 1) / count
        out[at + _MODE] = s.modes[v]
    parent, child = -1, 0
    for e in range(s.n_creases):
        u, w = s.creases[e, 0], s.creases[e, 1]
        if s.driven[e] != 0:
            at_both = r.sources != ON_BOUNDARY or u >> 3 == w >> 3
            if at_both or u >> 3 > w >> 3:
                note_driven(s, r, u, w, s.driven[e], slots, unit, out)
            if at_both or u >> 3 < w >> 3:
                note_driven(s, r, w, u, s.driven[e], slots, unit, out)
            continue
        child = child + 1 if u == parent else 0  # the creases of an extension follow each other
        parent = u
        v = u >> 3
        x, y = code_x(s, r, w), code_y(s, r, w)
        note_child(s, r, v, child, x, y, slots, unit, out)
    if s.phase == PLACEMENT and s.n_vertices == 0:
        note_picks(s, r, slots, out)
    if s.phase > SELECTION:
        v = s.selected
        at = FEATURES * slots[point_index(r, s.xy[v, 0], s.xy[v, 1])]
        out[at + _MODE], out[at + _CURRENT] = s.mode, 1.0
        only = s.axis[v] > 0  # the other outer child is an image
        if s.phase == SECOND or (s.phase == THIRD and not (only and near_side(s, r, v) != PREV)):
            note_child(s, r, v, 0, s.first_x, s.first_y, slots, unit, out)
        if s.phase == THIRD and not (only and near_side(s, r, v) == PREV):
            note_child(s, r, v, 0 if only else 1, s.second_x, s.second_y, slots, unit, out)


@kernel
def note_picks(s: Record, r: Record, slots: Slots, out: NDArray[np.float32]) -> None:
    """Mark the places that are chosen for the start pattern so far."""
    if s.unfinished > 0:
        out[FEATURES * slots[point_index(r, s.first_x, s.first_y)] + _CURRENT] = 1.0
    if s.unfinished > 1:
        out[FEATURES * slots[point_index(r, s.second_x, s.second_y)] + _CURRENT] = 1.0


@inlined
def note_child(
    s: Record,
    r: Record,
    v: int,
    child: int,
    x: int,
    y: int,
    slots: Slots,
    unit: float,
    out: NDArray[np.float32],
) -> None:
    at = FEATURES * slots[point_index(r, s.xy[v, 0], s.xy[v, 1])] + _CHILDREN + 2 * child
    out[at], out[at + 1] = unit * (x - s.xy[v, 0]), unit * (y - s.xy[v, 1])


@inlined
def note_driven(
    s: Record,
    r: Record,
    here: int,
    there: int,
    sign: int,
    slots: Slots,
    unit: float,
    out: NDArray[np.float32],
) -> None:
    """Note a driven crease at one of its ends, or rather at the representative of that end."""
    v = here >> 3
    other = image_code(r, r.inverses[here & 7], there)
    dx = unit * (code_x(s, r, other) - s.xy[v, 0])
    dy = unit * (code_y(s, r, other) - s.xy[v, 1])
    dx, dy = np.float32(dx), np.float32(dy)
    first = FEATURES * slots[point_index(r, s.xy[v, 0], s.xy[v, 1])] + _DRIVEN
    for slot in range((FEATURES - _DRIVEN) // 3):
        at = first + 3 * slot
        if out[at + 2] == 0.0:
            out[at], out[at + 1], out[at + 2] = dx, dy, sign
            return
        if out[at] == dx and out[at + 1] == dy:
            return


# --- tensor ----------------------------------------------------------------------------------------------------------


@kernel
def write_tensor(states: States, i: int, rules: States, out: Image) -> None:
    """Fill the paper's tensor, whose last axis says how many vertices it has room for."""
    s, r = states[i], rules[0]
    out[:] = 0
    n = s.n_vertices
    # children chosen for an extension that is not complete count as vertices already
    x, y = np.empty(n + 2, np.int32), np.empty(n + 2, np.int32)
    for v in range(n):
        x[v], y[v] = s.xy[v, 0], s.xy[v, 1]
    chosen = np.empty(2, np.int32)
    n_chosen = 0
    if s.phase > SELECTION:
        only = s.axis[s.selected] > 0
        if s.phase == SECOND or (s.phase == THIRD and not (only and near_side(s, r, s.selected) != PREV)):
            x[n], y[n] = s.first_x, s.first_y
            chosen[0] = find(x, y, n)
            n_chosen = 1
            n = max(n, chosen[0] + 1)
        if s.phase == THIRD and not (only and near_side(s, r, s.selected) == PREV):
            x[n], y[n] = s.second_x, s.second_y
            chosen[n_chosen] = find(x, y, n)
            n = max(n, chosen[n_chosen] + 1)
            n_chosen += 1
    if s.phase == PLACEMENT and s.n_vertices > 0:
        out[:, :, out.shape[2] - 1] = s.mode
    elif s.phase == PLACEMENT:
        x[0], y[0], x[1], y[1] = s.first_x, s.first_y, s.second_x, s.second_y
        for k in range(s.unfinished):
            for g in range(r.order):
                out[image_x(r, x, y, g, k) + r.half_x, image_y(r, x, y, g, k) + r.half_y, out.shape[2] - 1] = 1
    numbers = np.empty((n, 8), np.int32)
    number_images(r, x, y, n, numbers)
    for g in range(r.order):
        for v in range(s.n_vertices):
            mark(r, x, y, g, v, 0, s.modes[v], out)
        for e in range(s.n_creases):
            u, w = image_code(r, g, s.creases[e, 0]), image_code(r, g, s.creases[e, 1])
            sign = s.driven[e]
            mark(r, x, y, u & 7, u >> 3, 1 + numbers[w >> 3, w & 7], 1 if sign == 0 else sign, out)
            mark(r, x, y, w & 7, w >> 3, 1 + numbers[u >> 3, u & 7], -1 if sign == 0 else sign, out)
        if s.phase > SELECTION:
            v = s.selected
            mark(r, x, y, g, v, 0, s.mode, out)
            for k in range(n_chosen):
                mark(r, x, y, g, v, 1 + numbers[chosen[k], g], 1, out)
                mark(r, x, y, g, chosen[k], 1 + numbers[v, g], -1, out)
            out[image_x(r, x, y, g, v) + r.half_x, image_y(r, x, y, g, v) + r.half_y, out.shape[2] - 1] = 1


@inlined
def image_x(r: Record, x: Slots, y: Slots, g: int, v: int) -> int:
    return r.matrices[g, 0] * x[v] + r.matrices[g, 1] * y[v]


@inlined
def image_y(r: Record, x: Slots, y: Slots, g: int, v: int) -> int:
    return r.matrices[g, 2] * x[v] + r.matrices[g, 3] * y[v]


@inlined
def mark(r: Record, x: Slots, y: Slots, g: int, v: int, k: int, value: int, out: Image) -> None:
    """Write to slice k at an image of vertex v, if there is such a slice; the last one is not for vertices."""
    if k < out.shape[2] - 1:
        out[image_x(r, x, y, g, v) + r.half_x, image_y(r, x, y, g, v) + r.half_y, k] = value


@kernel
def find(x: Slots, y: Slots, n: int) -> int:
    """The first vertex that lies where the n-th does."""
    v = 0
    while x[v] != x[n] or y[v] != y[n]:
        v += 1
    return v


@kernel
def number_images(r: Record, x: Slots, y: Slots, n: int, numbers: NDArray[np.int32]) -> None:
    """(n, 8) numbers of the images, in order of appearance; images that coincide have one number."""
    count = 0
    for v in range(n):
        axis = axis_of(r, x[v], y[v])
        for g in range(r.order):
            twin = 0 if axis < 0 else r.products[g, axis] if axis > 0 else g
            if twin < g:
                numbers[v, g] = numbers[v, twin]
            else:
                numbers[v, g] = count
                count += 1
