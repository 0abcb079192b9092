"""What an agent sees: both observations against the sheet itself, and against each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import SELECTION, States
from origami_lab.game.moves import Extend, Place, Source
from origami_lab.game.observation import PHASES, CompactView, TensorView, possible_actions, view_of
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square

BARE = Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (0, 0, -1, 0, 0))
GAMES = {
    "bowl": lambda: Game(25, "xyd", Square("choose"), max_crease_length=2.9),
    "pyramid": lambda: Game(9, "xy", Square(1)),
    "two mirrors and a long crease": lambda: Game(13, "x", Square(2)),
    "face": lambda: Game(13, "y", Crease("choose"), max_crease_length=2.9),
    "plain": lambda: Game(9, "none", Crease(0)),
    "any rectangle": lambda: Game(9, "none", Rectangle()),
    "any square": lambda: Game(11, "x", Square("choose", "choose")),
    "any crease": lambda: Game(9, "none", Crease(ends="choose")),
    "sides that are not driven": lambda: Game(11, "y", BARE),
    "sources on the boundary": lambda: Game(11, "y", Square("choose"), source_action="boundary"),
    "sources without symmetry": lambda: Game(11, "none", Crease(0), source_action="boundary"),
    "wide": lambda: Game(board_width=13, board_height=9, symmetry="y", start=Square("choose")),
    "high": lambda: Game(board_width=7, board_height=13, symmetry="x", start=Square("choose")),
}


@pytest.fixture(params=GAMES)
def game(request: pytest.FixtureRequest) -> Game:
    return GAMES[request.param]()


def played(game: Game, episodes: int) -> Iterator[tuple[States, int]]:
    """The states of random play, with the action before each (−1: none)."""
    rng = np.random.default_rng(4)
    states = game.new_states(1)
    for _ in range(episodes):
        game.clear(states)
        yield states, -1
        while len(legal := game.legal(states)):
            if len(legal) > 1:  # longer episodes
                legal = legal[legal != 3 * game.rules.points]
            action = int(rng.choice(legal))
            game.play(states, action)
            yield states, action


def seen(view: CompactView | TensorView, states: States) -> NDArray[np.float32]:
    out = np.full(view.shape, 7, dtype=view.dtype)
    view.write(states, 0, out)
    assert np.abs(out).max() <= 1
    return out


def test_the_tensor_shows_the_sheet(game: Game) -> None:
    """Vertices, modes and creases as the sheet that objectives see has them, which is made in another way."""
    view, seen_extended, half = TensorView(game), 0, np.array([game.rules.half]).T
    for states, _ in played(game, 12):
        tensor = seen(view, states)
        if int(states["phase"][0]) != SELECTION:
            continue
        sheet = game.sheet(states)
        expected = np.zeros(view.shape, dtype=np.int8)
        (x, y), modes = sheet.flat.T + half, sheet.modes
        expected[x, y, 0] = modes
        for (u, v), sign in sheet.creases.items():
            # a crease leads from the vertex that was extended; of two such, from the one that is older
            forward, back = (sign, sign) if sign else (1, -1) if modes[u] else (-1, 1)
            expected[x[u], y[u], 1 + v], expected[x[v], y[v], 1 + u] = forward, back
            seen_extended += sign == 0
        assert np.array_equal(np.abs(tensor), np.abs(expected))
        ends = np.array([modes[u] == 0 or modes[v] == 0 or s != 0 for (u, v), s in sheet.creases.items()])
        for (u, v), certain in zip(sheet.creases, ends, strict=True):
            if certain:  # else both are extended, and the sheet does not say which was first
                assert tensor[x[u], y[u], 1 + v] == expected[x[u], y[u], 1 + v]
    assert seen_extended > 50


def test_the_tensor_shows_what_is_chosen() -> None:
    game = Game(9, "xy", Square(1))
    view, n, half = TensorView(game), game.rules.points, max(game.rules.half)
    states = game.new_states(1)

    def at(x: int, y: int) -> int:
        return (y + half) * 9 + x + half

    game.play(states, 3 * n + 6)
    square = seen(view, states)
    assert [tuple(p - half) for p in np.argwhere(np.any(square != 0, axis=2))] == [(-1, -1), (-1, 1), (1, -1), (1, 1)]
    assert np.count_nonzero(square) == 8
    assert square.sum() == 8  # four driven creases, valleys, at both ends
    game.play(states, at(-1, 1))
    assert seen(view, states)[-1 + half, 1 + half, 0] == -1
    assert np.count_nonzero(seen(view, states)[:, :, -1]) == 4
    game.play(states, 2 * n + at(0, 4))  # on an axis: two images
    tensor = seen(view, states)
    numbers = np.flatnonzero(tensor[-1 + half, 1 + half, 1:-1] == 1)
    assert numbers.tolist() == sorted({*np.flatnonzero(square[-1 + half, 1 + half, 1:-1] == 1), 4})
    assert tensor[0 + half, 4 + half, 1:-1].tolist().count(-1) == 2
    game.play(states, 2 * n + at(-4, 0))
    game.play(states, 2 * n + at(-2, 2))
    tensor = seen(view, states)
    assert not tensor[:, :, -1].any()
    assert np.count_nonzero(tensor[:, :, 0] == -1) == 4
    assert (tensor == 1).sum() - 8 == (tensor == -1)[:, :, 1:].sum() == 12


def test_a_capped_tensor_is_the_beginning_of_the_whole_one(game: Game) -> None:
    whole, capped = TensorView(game), TensorView(game, 20)
    assert whole.shape == (*game.board, game.rules.points + 2)
    for states, _ in played(game, 3):
        full, part = seen(whole, states), seen(capped, states)
        assert np.array_equal(part[:, :, :21], full[:, :, :21])
        assert np.array_equal(part[:, :, -1], full[:, :, -1])


def test_the_compact_observation_is_an_order_smaller_and_says_as_much(game: Game) -> None:
    """The tensor, made from the compact observation alone."""
    compact, tensor = CompactView(game), TensorView(game)
    smaller = 10 if game.symmetry.order > 1 else 5
    assert smaller * compact.shape[0] < np.prod(tensor.shape)
    most = 0
    for states, _ in played(game, 12):
        found = rebuilt(game, seen(compact, states))
        assert np.array_equal(found, seen(tensor, states))
        most = max(most, int(states["n_vertices"][0]))
    assert most > 6


HUB = [
    Place(1, 1),
    Extend((-1, 1), 1, (10, 12), (-7, 0), (-4, 13)),
    Source((1, 1), "next", 1),
    Extend((1, -1), -1, (3, -14), (11, -3), (14, -8)),
    Source((11, -3), "next", -1),
    Extend((10, 12), 1, (2, 1), (3, 13), (14, 15)),
    Source((1, 1), "next", 1),
    Extend((2, 1), -1, (9, -1), (15, 12), (14, -2)),
    Source((1, 1), "next", 1),
    Source((14, -8), "next", -1),
    Extend((11, -3), 1, (14, -6), (9, -2), (15, -4)),
    Source((9, -2), "next", -1),
    Extend((9, -1), 1, (8, -1), (14, -2), (13, -3)),
    Source((1, 1), "next", -1),
    Source((-4, 13), "next", -1),
    Source((14, 15), "next", 1),
    Source((3, -14), "next", -1),
    Extend((8, -1), 1, (4, 0), (13, -3), (7, -1)),
    Source((1, 1), "next", -1),
]
"""Moves, found by random play, that lead nine driven creases to one vertex."""


def test_the_compact_observation_loses_no_driven_crease_of_a_vertex_with_many() -> None:
    game = Game(31, "none", Square(1), source_action="boundary")
    states = game.new_states(1)
    for move in HUB:
        for action in game.encode(move, states):
            game.play(states, action)
            assert np.array_equal(rebuilt(game, seen(CompactView(game), states)), seen(TensorView(game), states))
    driven = Counter(end for ends, sign in game.sheet(states).creases.items() if sign for end in ends)
    assert max(driven.values()) == 9


def rebuilt(game: Game, compact: NDArray[np.float32]) -> NDArray[np.int8]:
    group, half = game.symmetry, game.rules.half
    columns, rows_of_board = (range(-h, h + 1) for h in half)
    points = [(x, y) for y in rows_of_board for x in columns if group.playable(np.array([(x, y)]))[0]]
    d = len(points)
    rows = compact[:-PHASES].astype(np.float64).reshape(d, -1)
    assert np.abs(compact[-PHASES:]).sum() == 1
    order = np.rint(rows[:, 0] * d).astype(int)
    vertices = [points[k] for k in sorted(np.flatnonzero(order), key=lambda k: order[k])]
    assert sorted(order[order > 0]) == list(range(1, len(vertices) + 1))
    chosen, creases, driven, current = [], [], [], []
    for point, row in zip(points, rows, strict=True):
        offsets = np.rint(row[3:] * 2 * max(half)).astype(int)
        children = [(point[0] + offsets[k], point[1] + offsets[k + 1]) for k in (0, 2, 4) if offsets[k : k + 2].any()]
        creases += [(point, child) for child in children]
        if row[2]:
            current.append(point)
            chosen = [child for child in children if child not in vertices]
        for k in range(6, rows.shape[1] - 3, 3):
            if row[3 + k + 2]:
                driven.append((point, (point[0] + offsets[k], point[1] + offsets[k + 1]), int(row[3 + k + 2])))
    number: dict[tuple[int, int], int] = {}
    matrices = [tuple(int(m) for m in matrix.ravel()) for matrix in group.matrices]

    def images(*some: tuple[int, int]) -> Iterator[list[tuple[int, int]]]:
        for a, b, c, e in matrices:
            yield [(a * x + b * y, c * x + e * y) for x, y in some]

    for vertex in [*vertices, *chosen]:
        for (image,) in images(vertex):
            number.setdefault(image, len(number))
    out = np.zeros((*game.board, game.rules.points + 2), dtype=np.int8)

    def put(at: tuple[int, int], k: int, value: int) -> None:
        out[at[0] + half[0], at[1] + half[1], k] = value

    for point, row in zip(points, rows, strict=True):
        for (image,) in images(point):
            if row[1]:
                put(image, 0, int(row[1]))
            if point in current:
                put(image, -1, 1)
    for u, w in creases:
        for a, b in images(u, w):
            put(a, 1 + number[b], 1)
            put(b, 1 + number[a], -1)
    if order.any() and compact[-PHASES]:  # a source is begun
        out[:, :, -1] = compact[-PHASES]
    for u, w, sign in driven:
        for a, b in images(u, w):
            put(a, 1 + number[b], sign)
            put(b, 1 + number[a], sign)
    return out


def test_all_that_is_played_is_possible(game: Game) -> None:
    possible = set(possible_actions(game).tolist())
    actions = {action for _, action in played(game, 20)} - {-1}
    assert actions <= possible
    assert len(possible) <= game.rules.n_actions
    if game.symmetry.order == 8:
        assert 6 * len(possible) < game.rules.n_actions


def test_bad_views_are_refused() -> None:
    game = Game(9, "xy", Square(1))
    with pytest.raises(InputError, match="observation=picture: must be compact or tensor"):
        view_of(game, "picture")
    for bad in (0, 82, 2.0, True):
        with pytest.raises(InputError, match="whole number from 1 to 81"):
            view_of(game, "tensor", bad)  # type: ignore[arg-type]
