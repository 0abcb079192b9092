"""Limits on creases and panels: designs that come of play under them, measured anew."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import RUNNING
from origami_lab.game.start_patterns import Square
from tests.growing import GAMES, grown, on_board

LENGTH, ANGLE, WIDTH = 1.4, 24.0, 0.6
SLACK = 1e-6


def designed(game: Game, moves: int, seed: int) -> CreasePattern:
    """A random design of so many moves at most."""
    states = grown(game, np.random.default_rng(seed), moves)
    actions = game.finished_actions(states)
    return game.design(actions, int(states["reach"][0]) - 1)


def sectors(design: CreasePattern) -> list[float]:
    """Degrees between neighbouring creases of the vertices inside the sheet."""
    rim = {int(v) for edge in design.edges[design.boundary] for v in edge}
    found = []
    for v in set(range(len(design.vertices))) - rim:
        ends = [int(b if a == v else a) for a, b in design.edges if v in (a, b)]
        ways = sorted(math.degrees(math.atan2(*(design.vertices[w] - design.vertices[v])[::-1])) for w in ends)
        found += [b - a for a, b in pairwise([*ways, ways[0] + 360])]
    return found


def width(corners: np.ndarray) -> float:
    """The least extent of a polygon over all directions: it is reached at right angles to a side of its hull."""
    hull = corners[ConvexHull(corners).vertices]
    sides = np.roll(hull, -1, axis=0) - hull
    normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]
    return float(np.ptp(hull @ normals.T, axis=0).min())


@pytest.mark.parametrize("symmetry", ["none", "y", "xyd"])
@given(seed=st.integers(0, 10**6))
def test_designs_keep_all_limits(symmetry: str, seed: int) -> None:
    game = Game(
        *(11, symmetry, Square(1)),
        max_crease_length=4,
        min_crease_length=LENGTH,
        min_sector_angle=ANGLE,
        min_panel_width=WIDTH,
    )
    design = designed(game, 6, seed)
    lengths = np.linalg.norm(np.diff(design.vertices[design.edges[~design.boundary]], axis=1)[:, 0], axis=1)
    assert (lengths >= LENGTH - SLACK).all()  # the start's sides are 2
    assert all(angle >= ANGLE - SLACK for angle in sectors(design))
    assert all(width(design.vertices[list(panel)]) >= WIDTH - SLACK for panel in design.panels)


@pytest.mark.parametrize(
    ("limit", "measure"),
    [
        (
            {"min_crease_length": LENGTH},
            lambda d: np.linalg.norm(np.diff(d.vertices[d.edges], axis=1)[:, 0], axis=1).min(),
        ),
        ({"min_sector_angle": ANGLE}, lambda d: min(sectors(d))),
        ({"min_panel_width": WIDTH}, lambda d: min(width(d.vertices[list(panel)]) for panel in d.panels)),
    ],
    ids=["length", "angle", "width"],
)
def test_without_them_designs_would_not(limit: dict[str, float], measure: object) -> None:
    """The limits above are ones that random play offends against."""
    [least] = limit.values()
    found = [measure(designed(Game(11, "none", Square(1), max_crease_length=4), 6, seed)) for seed in range(6)]  # type: ignore[operator]
    assert min(found) < least


@pytest.mark.parametrize("name", GAMES)
def test_limits_that_refuse_nothing_change_nothing(name: str) -> None:
    """The same actions are legal, in the same order, all along."""
    board, symmetry, start, length = GAMES[name]
    rules = {"max_crease_length": length, "source_action": "boundary" if name.startswith("boundary") else True}
    tiny = {"min_crease_length": 1e-6, "min_sector_angle": 1e-3, "min_panel_width": 1e-6}
    games = on_board(board, symmetry, start, **rules), on_board(board, symmetry, start, **rules, **tiny)
    played = 0
    for seed in range(4):
        states, rng = [game.new_states(1) for game in games], np.random.default_rng(seed)
        for _ in range(60):
            legal = [game.legal(state) for game, state in zip(games, states, strict=True)]
            np.testing.assert_array_equal(*legal)
            choices = legal[0][legal[0] != 3 * games[0].rules.points]
            if not len(choices) or states[0]["status"][0] != RUNNING:
                break
            action = int(rng.choice(choices))
            for game, state in zip(games, states, strict=True):
                game.play(state, action)
        one, other = (state[0] for state in states)
        played += int(one["n_actions"])
        for field, count in (("actions", one["n_actions"]), ("corners", one["n_triangles"])):
            np.testing.assert_array_equal(one[field][:count], other[field][:count])
        places = [state["position"][: state["n_vertices"], : state["reach"]] for state in (one, other)]
        np.testing.assert_array_equal(*places)
    assert played > 20
