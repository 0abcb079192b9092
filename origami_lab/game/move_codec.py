"""From moves to actions and back, in a rules."""

from __future__ import annotations

from collections.abc import Sequence

from origami_lab.game.kernels import play
from origami_lab.game.kernels.boundary import NEXT, near_side, tail
from origami_lab.game.kernels.state import NOT_FOLDABLE, PLACEMENT, SELECTION, States
from origami_lab.game.moves import Extend, Move, Place, Point, Source, Terminate
from origami_lab.game.rules import Rules


def encode(rules: Rules, move: Move, states: States, i: int = 0) -> list[int]:
    """The actions that make up a move in a state; raises ValueError where they cannot be told."""
    points = rules.points
    if isinstance(move, Terminate):
        return [3 * points]
    if isinstance(move, Place):
        option = move.value - int(rules.record["first_placement"][0])
        return [3 * points + 5 + 2 * option + (move.sign > 0)]
    if isinstance(move, Source):
        return [3 * points + 1 + 2 * (move.end == "end") + (move.sign > 0)]
    leaf = _leaf(states, i, move.leaf)
    select = _index(rules, move.leaf) + (points if move.mode > 0 else 0)
    if int(states["axis"][i][leaf]) > 0:
        near = move.b if near_side(states[i], rules.record[0], leaf) == NEXT else move.a
        return [select, 2 * points + _index(rules, near), 2 * points + _index(rules, move.c)]
    return [select, *(2 * points + _index(rules, p) for p in (move.a, move.b, move.c))]


def decode(rules: Rules, actions: Sequence[int], states: States) -> list[Move]:
    """The moves that legal actions make up, played on from a state; an incomplete extension is left out."""
    out: list[Move] = []
    for action in actions:
        phase = int(states["phase"][0])
        head_tail = _ends(states) if phase == SELECTION else None
        before = states.copy() if phase > SELECTION else states
        n_before = int(states["n_extensions"][0])
        rules.play(states, int(action))
        if phase == PLACEMENT:
            option = int(action) - 3 * rules.points - 5
            out.append(Place(option // 2 + int(rules.record["first_placement"][0]), 1 if option % 2 else -1))
        elif phase == SELECTION and action == 3 * rules.points:
            out.append(Terminate())
        elif phase == SELECTION and action > 3 * rules.points and head_tail is not None:
            option = int(action) - 3 * rules.points - 1
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
                    _point(rules, int(action) - 2 * rules.points),
                )
            )
    return out


def _index(rules: Rules, point: Point) -> int:
    x, y = point
    if abs(x) > rules.half[0] or abs(y) > rules.half[1]:
        raise ValueError(f"point {point} is not on the board")
    return (y + rules.half[1]) * rules.board[0] + x + rules.half[0]


def _point(rules: Rules, index: int) -> Point:
    return index % rules.board[0] - rules.half[0], index // rules.board[0] - rules.half[1]


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
