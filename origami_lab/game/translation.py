"""From moves to actions and back, in a game."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from origami_lab.game import play
from origami_lab.game.masks import NEXT, near_side, tail
from origami_lab.game.moves import Extend, Move, Place, Point, Source, Terminate
from origami_lab.game.state import NOT_FOLDABLE, PLACEMENT, SELECTION, States

if TYPE_CHECKING:
    from origami_lab.game.game import Game


def encode(game: Game, move: Move, states: States, i: int = 0) -> list[int]:
    """The actions that make up a move in a state; raises ValueError where they cannot be told."""
    points = game.points
    if isinstance(move, Terminate):
        return [3 * points]
    if isinstance(move, Place):
        option = move.value - int(game.rules["first_placement"][0])
        return [3 * points + 5 + 2 * option + (move.sign > 0)]
    if isinstance(move, Source):
        return [3 * points + 1 + 2 * (move.end == "end") + (move.sign > 0)]
    leaf = _leaf(states, i, move.leaf)
    select = _index(game, move.leaf) + (points if move.mode > 0 else 0)
    if int(states["axis"][i][leaf]) > 0:
        near = move.b if near_side(states[i], game.rules[0], leaf) == NEXT else move.a
        return [select, 2 * points + _index(game, near), 2 * points + _index(game, move.c)]
    return [select, *(2 * points + _index(game, p) for p in (move.a, move.b, move.c))]


def decode(game: Game, actions: Sequence[int], states: States) -> list[Move]:
    """The moves that legal actions make up, played on from a state; an incomplete extension is left out."""
    out: list[Move] = []
    for action in actions:
        phase = int(states["phase"][0])
        head_tail = _ends(states) if phase == SELECTION else None
        before = states.copy() if phase > SELECTION else states
        n_before = int(states["n_extensions"][0])
        game.play(states, int(action))
        if phase == PLACEMENT:
            option = int(action) - 3 * game.points - 5
            out.append(Place(option // 2 + int(game.rules["first_placement"][0]), 1 if option % 2 else -1))
        elif phase == SELECTION and action == 3 * game.points:
            out.append(Terminate())
        elif phase == SELECTION and action > 3 * game.points and head_tail is not None:
            option = int(action) - 3 * game.points - 1
            out.append(Source(head_tail[option // 2], ("start", "end")[option // 2], 1 if option % 2 else -1))
        elif phase > SELECTION and (
            int(states["n_extensions"][0]) > n_before or int(states["status"][0]) == NOT_FOLDABLE
        ):
            s = before[0]
            x, y = (int(t) for t in s["xy"][s["selected"]])
            out.append(
                Extend(
                    (x, y),
                    int(s["mode"]),
                    (int(s["first_x"]), int(s["first_y"])),
                    (int(s["second_x"]), int(s["second_y"])),
                    _point(game, int(action) - 2 * game.points),
                )
            )
    return out


def _index(game: Game, point: Point) -> int:
    x, y = point
    if max(abs(x), abs(y)) > game.half:
        raise ValueError(f"point {point} is not on the board")
    return (y + game.half) * game.board_size + x + game.half


def _point(game: Game, index: int) -> Point:
    return index % game.board_size - game.half, index // game.board_size - game.half


def _leaf(states: States, i: int, point: Point) -> int:
    leaf = play.leaf_at(states[i], *point) if int(states["head"][i]) >= 0 else -1
    if leaf < 0:
        raise ValueError(f"{point} is not a leaf in the playable area")
    return int(leaf)


def _ends(states: States) -> tuple[Point, Point]:
    s = states[0]
    x, y = s["xy"][s["head"]]
    u, v = s["xy"][tail(s)]
    return (int(x), int(y)), (int(u), int(v))
