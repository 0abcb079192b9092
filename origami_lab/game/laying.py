"""Laying down a start pattern that was made by moves, cutting parts of it off, and how far it folds.

Like every start pattern it is exempt from the maximum crease length and may have sources; otherwise the game's rules
hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.moves import Extend, Move, Place, Point, Source
from origami_lab.game.play import clear_state, copy_to, legal_of, replay_unchecked, step
from origami_lab.game.state import FULL, NOT_FOLDABLE, States
from origami_lab.game.translation import encode
from origami_lab.geometry.groups import SymmetryGroup

if TYPE_CHECKING:
    from origami_lab.game.game import Game

LARGEST_ANGLE = 1799
"""Tenths of a degree: below a half-turn, which is degenerate."""


def empty_board(game: Game) -> States:
    """One state before placement."""
    states = np.empty(1, dtype=game.dtype)  # rows are written before they are read
    clear_state(states, 0)
    return states


def play_move(game: Game, move: Move, states: States, rules: States) -> None:
    """Play a move on the first state under rules that may differ from the game's.

    Raises
    ------
    ValueError
        If it is not legal; an extension may have begun then.
    """
    legal = np.empty(game.max_legal, dtype=np.int32)
    for action in encode(game, move, states):
        if action not in legal[: legal_of(states, 0, rules, legal)]:
            raise ValueError(f"{move} is not legal in this state")
        step(states, 0, rules, action, legal)


def exempt_rules(game: Game, *, shortest_motion: bool = False) -> States:
    """The game's rules as they hold for start patterns; with ``shortest_motion`` one driving angle is enough."""
    rules = game.rules.copy()
    rules["max_length_sq"], rules["sources"] = math.inf, 1
    if shortest_motion:
        rules["min_reach"] = 1
    return rules


def lay(game: Game, moves: Sequence[Move], *, shortest_motion: bool = False) -> States:
    """One state with the start pattern that the moves make up.

    Raises
    ------
    InputError
        If the board or the capacity is too small for it, a move is not legal, or it does not fold.
    """
    states, rules = empty_board(game), exempt_rules(game, shortest_motion=shortest_motion)
    field, value = game.start.label
    needed = max((_reach_of(move) for move in moves), default=0)
    if needed > game.half:
        expected = f"must be at least {2 * needed + 1} for the start pattern of {field}={value}"
        raise InputError("board.size", game.board_size, expected)
    for number, move in enumerate(moves):
        try:
            play_move(game, move, states, rules)
        except ValueError:
            if int(states["status"][0]) == FULL:
                break
            expected = f"move {number} is not legal in this game: {_spoken(move)}"
            raise InputError(field, value, expected) from None
        if int(states["status"][0]) == NOT_FOLDABLE:
            if game.fixed and not shortest_motion:
                raise InputError(
                    "driving_angle.fixed",
                    f"{math.degrees(game.angles[-1]):.6g}",
                    f"the start pattern of {field}={value} does not fold so far;"
                    " driving_angle.fixed=start takes the largest angle that it admits",
                )
            first = math.degrees(game.angles[0])
            expected = f"does not fold to the first driving angle, {first:.4g} degrees: {_spoken(move)}"
            raise InputError(field, value, expected)
    if int(states["status"][0]) == FULL:
        expected = f"must be larger: the start pattern of {field}={value} fills it"
        raise InputError("capacity", game.capacity, expected)
    return states


def cut_off(game: Game, moves: Sequence[Move], remove: Iterable[Point]) -> tuple[Move, ...]:
    """The moves that are left when vertices lose their extensions, and so all that grew from them.

    A move goes, too, if one of the creases into its leaf goes, or if it is no longer legal without what went. So all
    that stays folds as it did.

    Raises
    ------
    InputError
        If there is no such vertex, if it was never extended, or if the pattern cannot be laid.
    """
    whole = lay(game, moves, shortest_motion=True)
    group = game.symmetry
    extended = {_orbit(group, move.leaf) for move in moves if isinstance(move, Extend)}
    flat = {(int(x), int(y)) for x, y in game.sheet(whole).flat}
    wanted = set()
    for point in remove:
        if _orbit(group, point) not in extended:
            expected = "has never been extended" if point in flat else "is not a vertex of the start pattern"
            raise InputError("start.remove", list(point), f"{expected}: must be an extended vertex")
        wanted.add(_orbit(group, point))
    states, before = empty_board(game), empty_board(game)
    rules = exempt_rules(game, shortest_motion=True)
    kept: list[Move] = []
    loose: set[Point] = set()
    for move in moves:
        leaf = _orbit(group, move.leaf) if isinstance(move, Extend | Source) else None
        goes = leaf in loose or (isinstance(move, Extend) and leaf in wanted)
        if not goes:
            copy_to(before, 0, states, 0)
            try:
                play_move(game, move, states, rules)
                goes = int(states["status"][0]) == NOT_FOLDABLE
            except ValueError:
                goes = True
            if goes:
                copy_to(states, 0, before, 0)
        if not goes:
            kept.append(move)
        elif isinstance(move, Extend):
            loose |= {_orbit(group, point) for point in (move.a, move.b, move.c)}
        elif leaf is not None:
            loose.add(leaf)
    return tuple(kept)


def largest_angle(game: Game, states: States) -> float:
    """How far the pattern in a state folds, in degrees: a multiple of 0.1, rounded down.

    At every tenth of a degree up to there its vertices fold and its panels do not pass through each other. 0 if the
    first one is too much already.
    """
    rules, scratch = exempt_rules(game, shortest_motion=True), empty_board(game)
    log = states["actions"][0][: int(states["n_actions"][0])]
    count = len(game.angles)
    for start in range(0, LARGEST_ANGLE, count):
        tenths = np.minimum(np.arange(start + 1, start + count + 1), LARGEST_ANGLE)
        rules["angles"][0] = np.radians(tenths / 10)
        free = int(replay_unchecked(scratch, 0, rules, log))
        if free < count:
            return min(start + free, LARGEST_ANGLE) / 10
    return LARGEST_ANGLE / 10


def _orbit(group: SymmetryGroup, point: Point) -> Point:
    """One point that stands for all images of a point."""
    x, y = min((group.matrices @ np.array(point, dtype=np.int64)).tolist())
    return x, y


def _reach_of(move: Move) -> int:
    """Half-width of the smallest board that a move needs."""
    if isinstance(move, Place):
        return abs(move.value) + 1
    if isinstance(move, Extend):
        return max(*(abs(t) for point in (move.a, move.b, move.c) for t in point), *(abs(t) + 1 for t in move.leaf))
    return 0


def _spoken(move: Move) -> str:
    """A move in a message."""
    if isinstance(move, Extend):
        a, b, c = (list(point) for point in (move.a, move.b, move.c))
        return f"the extension of {list(move.leaf)} in mode {move.mode:+d} to a={a} b={b} c={c}"
    if isinstance(move, Source):
        return f"the source at {list(move.leaf)}"
    return str(move)
