"""Sheets to score: made by hand, and from random play."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import play_uniform
from origami_lab.game.kernels.state import RUNNING, SINGLE, States


def hand_made(
    game: Game,
    flat: Sequence[Sequence[int]] | NDArray[np.int64],
    folded: Sequence[Sequence[float]] | NDArray[np.float64],
    triangles: Sequence[Sequence[int]] | NDArray[np.int64],
    extended: Sequence[int] | NDArray[np.int64] = (),
) -> States:
    """A state of a game without symmetry: (V, 2) board points, (V, 3) or (K, V, 3) their folded places, triangles."""
    assert game.symmetry.order == 1
    points = np.broadcast_to(np.asarray(folded, dtype=float), (len(game.angles), len(flat), 3))
    states = np.zeros(1, dtype=game.rules.dtype)
    s = states[0]
    s["n_vertices"], s["n_triangles"], s["reach"] = len(flat), len(triangles), len(game.angles)
    s["phase"], s["n_extensions"] = 1, 1
    s["xy"][: len(flat)] = flat
    s["position"][: len(flat)] = points.transpose(1, 0, 2)
    s["corners"][: len(triangles)] = 8 * np.asarray(triangles)
    s["images"][: len(triangles)] = SINGLE
    s["modes"][np.asarray(extended, dtype=int)] = 1
    return states


def shuffled(game: Game, states: States, plain: Game, rng: np.random.Generator, move: NDArray[np.float64]) -> States:
    """A state's whole sheet, images and all, as a state of a game without symmetry, in another order and place.

    ``move`` (3, 3) turns or mirrors it in space. The four corners of the start pattern stay the first vertices.
    """
    sheet = game.sheet(states)
    order = np.concatenate([rng.permutation(4), 4 + rng.permutation(len(sheet.flat) - 4)])
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    points = np.zeros((len(game.angles), len(order), 3))
    points[: sheet.reach] = sheet.points[:, order] @ move.T
    triangles = number[rng.permutation(sheet.triangles)]
    out = hand_made(plain, sheet.flat[order], points, triangles, np.flatnonzero(sheet.modes[order]))
    out["reach"] = sheet.reach
    return out


def episodes(game: Game, seed: int, count: int) -> Iterator[States]:
    """States at the end of random episodes that have something to score; the array is reused."""
    rng = np.random.default_rng(seed)
    states = game.new_states(1)
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    while count:
        game.clear(states)
        play_uniform(states, 0, game.rules.record, rng.random(1000), 0, 1000, legal)
        if states["status"][0] != RUNNING and not game.is_penalised(states) and states["n_extensions"][0]:
            count -= 1
            yield states
