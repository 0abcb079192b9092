"""From moves to actions and back, in a rules."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from origami_lab.game.kernels import play
from origami_lab.game.kernels.boundary import NEXT, near_side, tail
from origami_lab.game.kernels.boundary_sources import boundary_action
from origami_lab.game.kernels.corner_choice import start_corners
from origami_lab.game.kernels.state import (
    CREASE,
    LARGEST_PANEL,
    NOT_FOLDABLE,
    PANEL,
    PLACEMENT,
    SELECTION,
    SQUARE,
    States,
)
from origami_lab.game.moves import Extend, Lay, Move, Place, Point, Source, Terminate
from origami_lab.game.rules import Rules


def encode(rules: Rules, move: Move, states: States, i: int = 0) -> list[int]:
    """The actions that make up a move in a state; raises ValueError where they cannot be told."""
    points = rules.points
    if isinstance(move, Terminate):
        return [3 * points]
    if isinstance(move, Place):
        option = move.value - int(rules.record["first_placement"][0])
        return [3 * points + 5 + 2 * option + (move.sign > 0)]
    if isinstance(move, Lay):
        return _encode_lay(rules, move)
    if isinstance(move, Source) and move.end == "next":
        return [int(boundary_action(rules.record[0])) + (move.sign > 0), 2 * points + _index(rules, move.leaf)]
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
    begins_source = int(boundary_action(rules.record[0]))
    for action in actions:
        phase = int(states["phase"][0])
        head_tail = _ends(states) if phase == SELECTION else None
        before = states if phase == SELECTION else states.copy()
        n_before = int(states["n_extensions"][0])
        rules.play(states, int(action))
        if phase == PLACEMENT and int(before["n_vertices"][0]):
            out.append(Source(_point(rules, int(action) - 2 * rules.points), "next", int(before["mode"][0])))
        elif phase == PLACEMENT:
            if int(action) >= 3 * rules.points:
                out.append(_placed(rules, before, int(action) - 3 * rules.points - 5))
        elif phase == SELECTION and action == 3 * rules.points:
            out.append(Terminate())
        elif phase == SELECTION and action >= begins_source:
            continue  # its place follows
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


def _placed(rules: Rules, before: States, option: int) -> Place | Lay:
    """The move that an option and what was picked before it make up."""
    sign, r = 1 if option % 2 else -1, rules.record[0]
    plain = r["start"] == SQUARE and not r["centre"].any()
    if plain or (r["start"] == CREASE and not r["stays_below"]):
        return Place(option // 2 + int(r["first_placement"]), sign)
    corners, signs = _outline(rules, before, option // 2)
    return Lay(corners, signs, sign)


def _outline(rules: Rules, states: States, option: int) -> tuple[tuple[Point, ...], tuple[int, ...]]:
    """Corners and signs of the sides of the start pattern that an option, or the picks of a state, name."""
    room, r = np.zeros((LARGEST_PANEL, 2), dtype=np.int32), rules.record[0]
    count = int(start_corners(states[0], r, option, room))
    signs = tuple(int(sign) for sign in r["sides"][:count]) if r["start"] == PANEL else (1, 1, 1, 1)
    return tuple((int(x), int(y)) for x, y in room[:count]), (1, 0) if count == 2 else signs


def _encode_lay(rules: Rules, move: Lay) -> list[int]:
    """The actions that lay a start pattern: each way that the rules offer is tried."""
    states, r = np.zeros(1, dtype=rules.dtype), rules.record[0]
    bit, picks = int(move.sign > 0), []
    if r["picks"]:
        ends = sorted(move.corners)
        for name, (x, y) in zip(("first", "second"), (ends[0], ends[-1]), strict=True):
            images = rules.symmetry.matrices @ np.array((x, y))
            x, y = (int(t) for t in images[rules.symmetry.playable(images)][0])
            states[f"{name}_x"], states[f"{name}_y"] = x, y
            picks.append(2 * rules.points + _index(rules, (x, y)))
    for option in range(int(r["n_placements"])):
        corners, signs = _outline(rules, states, option)
        for turned in (1, -1):
            wanted = tuple(turned * sign for sign in move.signs)
            if _same_round((*zip(corners, signs, strict=True),), (*zip(move.corners, wanted, strict=True),)):
                sign = bit if turned > 0 else 1 - bit
                return [*picks[: int(r["picks"])], 3 * rules.points + 5 + 2 * option + sign]
    raise ValueError(f"{move} is no start pattern of this game")


def _same_round(these: tuple[object, ...], those: tuple[object, ...]) -> bool:
    """Whether two rounds are the same, wherever they begin."""
    return len(these) == len(those) and any(these[i:] + these[:i] == those for i in range(len(these)))


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
