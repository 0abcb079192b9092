"""Laying down a start pattern that was made by moves, cutting parts of it off, and how far it folds.

Like every start pattern it is exempt from the maximum crease length and may have sources; otherwise the game's rules
hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.kernels.play import clear_state, legal_of, replay_unchecked, step
from origami_lab.game.kernels.state import FULL, NOT_FOLDABLE, States
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_codec import encode
from origami_lab.game.move_table import ACTIONS, EXTEND, lay_rest, table_of
from origami_lab.game.moves import Extend, Move, Point, Source
from origami_lab.game.rules import Rules
from origami_lab.geometry.groups import SymmetryGroup

LARGEST_ANGLE = 1799
"""Tenths of a degree: below a half-turn, which is degenerate."""
MOST_NAMED = 24
"""Vertices that a message lists."""


def empty_board(rules: Rules) -> States:
    """One state before placement."""
    states = np.empty(1, dtype=rules.dtype)  # rows are written before they are read
    clear_state(states, 0)
    return states


def play_move(rules: Rules, move: Move, states: States) -> None:
    """Play a move on the first state.

    Raises
    ------
    ValueError
        If it is not legal; an extension may have begun then.
    """
    legal = np.empty(rules.max_legal, dtype=np.int32)
    for action in encode(rules, move, states):
        if action not in legal[: legal_of(states, 0, rules.record, legal)]:
            raise ValueError(f"{move} is not legal in this state")
        step(states, 0, rules.record, action, legal)


def lay(rules: Rules, moves: Sequence[Move], *, shortest_motion: bool = False) -> States:
    """One state with the start pattern that the moves make up, under the rules of a rules.

    Raises
    ------
    InputError
        If the board or the capacity is too small for it, a move is not legal, or it does not fold.
    """
    states, exempt = empty_board(rules), rules.for_start_pattern(shortest_motion=shortest_motion)
    field, value = rules.start.label
    wide, high = (max(needs) for needs in zip((0, 0), *map(_reach_of, moves), strict=True))
    square = rules.board[0] == rules.board[1]
    sides = (("board.size", max(wide, high)),) if square else (("board.width", wide), ("board.height", high))
    for (key, needed), side, half in zip(sides, rules.board, rules.half, strict=False):
        if needed > half:
            raise InputError(key, side, f"must be at least {2 * needed + 1} for the start pattern of {field}={value}")
    for number, move in enumerate(moves):
        try:
            play_move(exempt, move, states)
        except ValueError:
            if int(states["status"][0]) == FULL:
                break
            expected = f"move {number} is not legal in this game: {_spoken(move)}"
            raise InputError(field, value, expected) from None
        if int(states["status"][0]) == NOT_FOLDABLE:
            if rules.fixed and not shortest_motion:
                raise InputError(
                    "driving_angle.fixed",
                    f"{math.degrees(rules.angles[-1]):.6g}",
                    f"the start pattern of {field}={value} does not fold so far;"
                    " driving_angle.fixed=start takes the largest angle that it admits",
                )
            first = math.degrees(rules.angles[0])
            expected = f"does not fold to the first driving angle, {first:.4g} degrees: {_spoken(move)}"
            raise InputError(field, value, expected)
    if int(states["status"][0]) == FULL:
        expected = f"must be larger: the start pattern of {field}={value} fills it"
        raise InputError("capacity", rules.capacity, expected)
    return states


def cut_off(rules: Rules, moves: Sequence[Move], remove: Iterable[Point]) -> tuple[Move, ...]:
    """The moves that are left when vertices lose their extensions, and so all that grew from them.

    A move goes, too, if one of the creases into its leaf goes, or if it is no longer legal without what went. So all
    that stays folds as it did.

    Raises
    ------
    InputError
        If there is no such vertex, if it was never extended, or if the pattern cannot be laid.
    """
    whole = lay(rules, moves, shortest_motion=True)
    group = rules.symmetry
    extended = {_orbit(group, move.leaf) for move in moves if isinstance(move, Extend)}
    flat = {(int(x), int(y)) for x, y in FoldedSheet(whole, 0, rules.record).flat}
    wanted = set()
    for point in remove:
        if _orbit(group, point) not in extended:
            what = "has never been extended" if point in flat else "is not a vertex of the start pattern"
            raise InputError("start.remove", list(point), f"{what}: {_removable(group, moves, point)}")
        wanted.add(_orbit(group, point))
    table, points = table_of(whole, rules.record, empty_board(rules))
    goes = np.array([_orbit(group, (int(x), int(y))) in wanted for x, y in points[table["leaf"]]], dtype=np.int8)
    goes[table["kind"] != EXTEND] = 0
    kept, notes = np.zeros(len(table), dtype=np.int8), np.empty(ACTIONS, dtype=note_dtype(len(rules.angles)))
    exempt = rules.for_start_pattern(shortest_motion=True).record
    lay_rest(empty_board(rules), 0, exempt, table, points, goes, notes, kept)
    return tuple(move for move, keeps in zip(moves, kept, strict=True) if keeps)


def largest_angle(rules: Rules, states: States) -> float:
    """How far the pattern in a state folds, in degrees: a multiple of 0.1, rounded down.

    At every tenth of a degree up to there its vertices fold and its panels do not pass through each other. 0 if the
    first one is too much already.
    """
    record, scratch = rules.for_start_pattern(shortest_motion=True).record, empty_board(rules)
    log = states["actions"][0][: int(states["n_actions"][0])]
    count = len(rules.angles)
    for start in range(0, LARGEST_ANGLE, count):
        tenths = np.minimum(np.arange(start + 1, start + count + 1), LARGEST_ANGLE)
        record["angles"][0] = np.radians(tenths / 10)
        free = int(replay_unchecked(scratch, 0, record, log))
        if free < count:
            return min(start + free, LARGEST_ANGLE) / 10
    return LARGEST_ANGLE / 10


def _orbit(group: SymmetryGroup, point: Point) -> Point:
    """One point that stands for all images of a point."""
    x, y = min((group.matrices @ np.array(point, dtype=np.int64)).tolist())
    return x, y


def _removable(group: SymmetryGroup, moves: Sequence[Move], point: Point) -> str:
    """The end of a message: the vertices that can be removed, the nearest to a point first."""
    images = {
        _orbit(group, move.leaf): group.matrices @ np.array(move.leaf) for move in moves if isinstance(move, Extend)
    }
    near = [min(found.tolist(), key=lambda image: math.dist(image, point)) for found in images.values()]
    near.sort(key=lambda image: (math.dist(image, point), image))
    if not near:
        return "the start pattern has no extended vertex to be removed"
    named = ", ".join(f"[{x},{y}]" for x, y in near[:MOST_NAMED])
    more = f" and {len(near) - MOST_NAMED} more" if len(near) > MOST_NAMED else ""
    images_too = "" if len(group.matrices) == 1 else "; mirror images go with it"
    return f"must be an extended vertex: {named}{more}{images_too}"


def _reach_of(move: Move) -> tuple[int, int]:
    """Half of the sides of the smallest board that a move needs."""
    if isinstance(move, Extend):
        x, y = (max(*(abs(point[j]) for point in (move.a, move.b, move.c)), abs(move.leaf[j]) + 1) for j in range(2))
        return x, y
    return 0, 0  # where a start pattern may be placed is said before


def _spoken(move: Move) -> str:
    """A move in a message."""
    if isinstance(move, Extend):
        a, b, c = (list(point) for point in (move.a, move.b, move.c))
        return f"the extension of {list(move.leaf)} in mode {move.mode:+d} to a={a} b={b} c={c}"
    if isinstance(move, Source):
        return f"the source at {list(move.leaf)}"
    return str(move)
