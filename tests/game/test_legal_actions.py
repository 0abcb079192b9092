"""Masks against brute force: legal is what leaves the orbit's sheet a simple polygon and the vertex solvable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import pytest

from benchmarks.random_play import makes_half_turn
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import NOT_FOLDABLE, PLACEMENT, RUNNING, SELECTION, States
from origami_lab.game.moves import Lay, Place
from origami_lab.game.start_patterns import CHOOSE, Crease, Panel, Rectangle, Square, Start
from tests.growing import on_board
from tests.oracles import BoardSheet, Point

Board = int | tuple[int, int]

ROUNDING = 1e-7
"""Where the spherical triangle exists by less than this either answer is right."""


class Comparison:
    """A game and the oracle played side by side."""

    def __init__(self, game: Game, oracle: BoardSheet) -> None:
        self.game, self.oracle = game, oracle
        self.states, self.spare = game.new_states(1), game.new_states(1)
        self.chosen: list[Point] = []
        self.source_sign = 0
        self.half_turns = 0
        self.begins_source = 3 * game.rules.points + 5 + 2 * int(game.rules.record["n_placements"][0])

    def points(self, actions: set[int], offset: int) -> set[Point]:
        inside = (a - offset for a in actions if offset <= a < offset + self.game.rules.points)
        n, (half_x, half_y) = self.game.board[0], self.game.rules.half
        return {(a % n - half_x, a // n - half_y) for a in inside}

    def compare(self, actions: set[int]) -> None:
        n, oracle = self.game.rules.points, self.oracle
        if self.game.rules.record["straight_sectors"][0]:
            oracle.folded = self.game.sheet(self.states), float(self.game.angles[0])
        if self.chosen:
            self.compare_locations(self.points(actions, 2 * n))
            return
        free = oracle.boundary_sources() if oracle.anywhere else set()
        if int(self.states[0]["phase"]) == PLACEMENT:
            assert self.points(actions, 2 * n) == free
            return
        begins = {a for a in actions if a >= self.begins_source}
        assert begins == ({self.begins_source, self.begins_source + 1} if free else set())
        leaves = oracle.selectable()
        assert self.points(actions, 0) == leaves == self.points(actions, n)
        assert (3 * n in actions) == oracle.extended
        ends = {end for _, end in oracle.sources()}
        assert {"start" for a in actions if a in (3 * n + 1, 3 * n + 2)} == ends & {"start"}
        assert {"end" for a in actions if a in (3 * n + 3, 3 * n + 4)} == ends & {"end"}

    def compare_locations(self, legal: set[Point]) -> None:
        oracle, (v, *children) = self.oracle, self.chosen
        if not children:
            assert legal == oracle.first(v)
        elif len(children) == 1:
            assert legal == oracle.second(v, children[0])
        else:
            a, b = children
            fits = oracle.third(v, a, b)
            sheet, rho = self.game.sheet(self.states), float(self.game.angles[0])
            slack = {c: oracle.triangle_slack(sheet, rho, v, a, b, c) for c in fits}
            if oracle.has_half_turn(v, a, b):  # what the children before have settled
                assert legal == fits
                self.half_turns += 1
                return
            if opposite(v, a, b):
                mode = int(self.states[0]["mode"])
                opens = {c: mode * oracle.opens_towards(sheet, rho, v, a, b, c) for c in fits}
                slack = {c: min(slack[c], opens[c]) for c in fits}
            assert legal <= {c for c in fits if slack[c] > -ROUNDING}
            if legal or not is_straight(v, a, b):
                assert legal >= {c for c in fits if slack[c] > ROUNDING}

    def play(self, action: int) -> None:
        """Play on both; an extension that cannot fold is taken back."""
        game, oracle, n = self.game, self.oracle, self.game.rules.points
        sheet = self.states[0]
        point = next(iter(self.points({action}, 0) | self.points({action}, n) | self.points({action}, 2 * n)), None)
        if int(sheet["phase"]) == PLACEMENT and oracle.ring:
            [v] = self.points({action}, 2 * n)
            oracle.lay_source(v, oracle.neighbours(v)[1], self.source_sign)
            game.play(self.states, action)
            return
        if int(sheet["phase"]) == PLACEMENT:
            game.play(self.states, action)
            if int(sheet["phase"]) == SELECTION:
                [placed] = game.moves(game.finished_actions(self.states))
                if isinstance(placed, Lay):
                    oracle.place_outline(placed.corners, [placed.sign * sign for sign in placed.signs])
                else:
                    assert isinstance(placed, Place)
                    square = isinstance(game.start, Square)
                    (oracle.place_square if square else oracle.place_crease)(placed.value, placed.sign)
            return
        if action > 3 * n + 4:
            self.source_sign = 1 if (action - self.begins_source) % 2 else -1
            game.play(self.states, action)
            return
        if action > 3 * n:
            option = action - 3 * n - 1
            end = ("start", "end")[option // 2]
            v = next(w for w, side in oracle.sources() if side == end)
            prev, following = oracle.neighbours(v)
            oracle.lay_source(*((prev, v) if end == "start" else (v, following)), 1 if option % 2 else -1)
        elif point is not None:
            if not self.chosen:
                self.spare = self.states.copy()
            self.chosen.append(point)
            v = self.chosen[0]
            if len(self.chosen) == 2 and oracle.axes(v):
                image = mirror_image(oracle, v, point)
                self.chosen = [v, point, image] if oracle.near_side(v) == "prev" else [v, image, point]
        game.play(self.states, action)
        if len(self.chosen) == 4:
            v, a, b, c = self.chosen
            self.chosen = []
            if sheet["status"] == NOT_FOLDABLE:
                self.states = self.spare
            else:
                oracle.extend(v, a, b, c)


def is_straight(v: Point, a: Point, b: Point) -> bool:
    """Whether a and b lie on one line through v: then one of the two modes does not fold from the flat sheet."""
    ax, ay, bx, by = a[0] - v[0], a[1] - v[1], b[0] - v[0], b[1] - v[1]
    return ax * by == ay * bx and ax * bx + ay * by < 0


def opposite(v: Point, a: Point, b: Point) -> bool:
    ax, ay, bx, by = a[0] - v[0], a[1] - v[1], b[0] - v[0], b[1] - v[1]
    return ax * by == ay * bx and ax * bx + ay * by < 0


def mirror_image(oracle: BoardSheet, v: Point, q: Point) -> Point:
    a, b, c, d = oracle.axes(v)[0]
    return a * q[0] + b * q[1], c * q[0] + d * q[1]


STARTS: list[tuple[str, Start]] = [(symmetry, Square("choose")) for symmetry in ("none", "y", "x", "xy", "xyd")]
STARTS += [(symmetry, Crease("choose")) for symmetry in ("none", "y")]
ANYWHERE: dict[str, tuple[str, Start]] = {
    **{f"rectangle {symmetry}": (symmetry, Rectangle()) for symmetry in ("none", "y", "x", "xy")},
    "any square": ("none", Square("choose", "choose")),
    "square of a size": ("y", Square(1, "choose")),
    "square beside the centre": ("none", Square("choose", (1, -1))),
    "wide": ("x", Rectangle(4, "choose")),
    "from a corner": ("none", Rectangle(corner=(-2, -1))),
    "any crease": ("none", Crease(ends=CHOOSE)),
    "any crease, below": ("none", Crease(ends=CHOOSE, stays="lower")),
    "any crease y": ("y", Crease(ends=CHOOSE)),
    "any crease x": ("x", Crease(ends=CHOOSE, stays="lower")),
    "crease below": ("y", Crease("choose", stays="lower")),
    "oblique crease": ("none", Crease(ends=((-2, -1), (1, 1)))),
    "triangle": ("none", Panel(((-1, -1), (2, 0), (0, 2)))),
    "mixed signs": ("y", Panel(((0, 2), (-2, 0), (0, -1), (2, 0)), (1, -1, -1, 1))),
    "three sides": ("x", Panel(((1, 1), (-2, 2), (-2, -2), (1, -1)), (1, 1, 1, 0))),
    "a bare corner": ("none", Panel(((2, 1), (-1, 2), (-2, 0), (0, -2)), (1, 0, 0, 1))),
    "bare corners on an axis": ("y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (0, 0, 1, 0, 0))),
    "octagon": ("xyd", Panel(((2, 1), (1, 2), (-1, 2), (-2, 1), (-2, -1), (-1, -2), (1, -2), (2, -1)))),
    "diamond": ("xyd", Panel(((2, 0), (0, 2), (-2, 0), (0, -2)))),
    "every other side": ("xy", Panel(((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1)), (0, 0, 1, 0, 0, 1))),
}
"""Start patterns whose size and place are given or chosen, with the symmetry that they have."""


@pytest.mark.parametrize(("symmetry", "start"), STARTS, ids=[f"{s}-{type(t).__name__.lower()}" for s, t in STARTS])
@pytest.mark.parametrize(
    ("board", "length"), [(7, None), (9, None), (9, 2.0), (11, 2.9), ((11, 7), None), ((7, 11), None)]
)
def test_masks_equal_brute_force(symmetry: str, start: Start, board: Board, length: float | None) -> None:
    if symmetry == "xyd" and isinstance(board, tuple):
        pytest.skip("a board that is wider than high is not symmetric in the diagonals")
    compare_masks(symmetry, start, board, length, episodes=5, seed=1)


@pytest.mark.parametrize("name", ANYWHERE)
@pytest.mark.parametrize(("board", "length"), [(7, None), ((11, 9), 2.9)])
def test_masks_equal_brute_force_from_any_start(name: str, board: Board, length: float | None) -> None:
    symmetry, start = ANYWHERE[name]
    if symmetry == "xyd" and isinstance(board, tuple):
        board = 9
    compared = compare_masks(symmetry, start, board, length, episodes=6, seed=2)
    assert compared > 12


ON_BOUNDARY: list[tuple[str, Start]] = [
    *STARTS,
    ("none", Crease(ends=CHOOSE, stays="lower")),
    ("y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (0, 0, 1, 0, 0))),
    ("none", Panel(((2, 1), (-1, 2), (-2, 0), (0, -2)), (1, 0, 0, 1))),
    ("xyd", Panel(((2, 0), (0, 2), (-2, 0), (0, -2)))),
    ("xy", Panel(((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1)), (0, 0, 1, 0, 0, 1))),
]


@pytest.mark.parametrize(("symmetry", "start"), ON_BOUNDARY)
@pytest.mark.parametrize("length", [None, 2.9])
def test_masks_equal_brute_force_with_sources_on_the_boundary(
    symmetry: str, start: Start, length: float | None
) -> None:
    assert compare_masks(symmetry, start, 9, length, episodes=8, seed=3, sources="boundary") > 12


@pytest.mark.parametrize(("symmetry", "start"), ON_BOUNDARY)
@pytest.mark.parametrize("sources", ["boundary", "axis"])
def test_masks_equal_brute_force_where_sectors_are_half_turns(symmetry: str, start: Start, sources: str) -> None:
    """Every other action makes one, if it can; what the middle child may be then is for the oracle to say, too."""
    assert compare_masks(symmetry, start, 9, None, episodes=30, seed=4, sources=sources, seek=True) > 12


@pytest.mark.parametrize(("symmetry", "start"), ON_BOUNDARY)
def test_masks_equal_brute_force_without_half_turns(symmetry: str, start: Start) -> None:
    assert compare_masks(symmetry, start, 9, None, episodes=4, seed=5, sources="boundary", straight=False) > 12


LIMITS: dict[str, dict[str, float]] = {
    "short": {"min_crease_length": 2.0},
    "diagonal": {"min_crease_length": 2.0**0.5},
    "sharp": {"min_sector_angle": 45.0},
    "odd": {"min_sector_angle": 31.7},
    "narrow": {"min_panel_width": 0.8},
    "half a diagonal": {"min_panel_width": 0.5**0.5},
    "all": {"min_crease_length": 1.2, "min_sector_angle": 22.0, "min_panel_width": 0.6},
}


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("sources", [True, "boundary"])
def test_limits_are_exact(name: str, sources: bool | str) -> None:
    compared = 0
    for symmetry, start in (*STARTS[:5], ("none", Crease("choose")), ON_BOUNDARY[-1], ON_BOUNDARY[-4]):
        compared += compare_masks(symmetry, start, 9, 3.5, episodes=2, seed=5, sources=sources, limits=LIMITS[name])
    assert compared > 60


def compare_masks(
    symmetry: str,
    start: Start,
    board: Board,
    length: float | None,
    episodes: int,
    seed: int,
    sources: bool | str = True,
    straight: bool = True,
    seek: bool = False,
    limits: Mapping[str, float] = MappingProxyType({}),
) -> int:
    rng = np.random.default_rng(seed)
    game = on_board(
        board, symmetry, start, max_crease_length=length, source_action=sources, straight_sectors=straight, **limits
    )
    compared = half_turns = 0
    for _ in range(episodes):
        oracle = BoardSheet(
            game.rules.half,
            symmetry,
            length,
            anywhere=sources == "boundary",
            min_length=limits.get("min_crease_length", 0.0),
            min_sector=math.radians(limits.get("min_sector_angle", 0.0)),
            min_width=limits.get("min_panel_width", 0.0),
        )
        both = Comparison(game, oracle)
        for _ in range(80):
            actions = game.legal(both.states)
            if both.oracle.ring:
                both.compare({int(a) for a in actions})
                compared += 1
            choices = [int(a) for a in actions if a != 3 * game.rules.points]
            if not choices or both.states[0]["status"] != RUNNING:
                break
            sought = [a for a in choices if seek and makes_half_turn(both.states[0], game.rules.record[0], a)]
            both.play(int(rng.choice(sought if sought and rng.random() < 0.5 else choices)))
        half_turns += both.half_turns
    assert (half_turns > 0) == seek or (straight and not seek)
    return compared


def snapshot(states: States) -> bytes:
    return states.tobytes()


@pytest.mark.parametrize(("symmetry", "limits"), [("none", {}), ("y", {}), ("xyd", {}), ("y", LIMITS["all"])])
def test_step_accepts_what_the_mask_allows_and_nothing_else(symmetry: str, limits: dict[str, float]) -> None:
    """Design page, section 9, item 8."""
    rng = np.random.default_rng(3)
    game = Game(7, symmetry, Square("choose"), capacity=24, **limits)
    for _ in range(2):
        states = game.new_states(1)
        for _ in range(40):
            legal = game.legal(states)
            before = snapshot(states)
            for action in range(-2, game.rules.n_actions + 2):
                if action in legal:
                    trial = states.copy()
                    game.play(trial, action)
                    assert int(trial["n_actions"][0]) == int(states["n_actions"][0]) + 1
                else:
                    with pytest.raises(ValueError, match="not legal"):
                        game.play(states, action)
                    assert snapshot(states) == before
            if not len(legal):
                break
            game.play(states, int(rng.choice(legal)))
