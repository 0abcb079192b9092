"""Random play, with every invariant of the sheet and its motion checked after each episode.

    python -m benchmarks.random_play --episodes 10000

plays each symmetry group and start pattern on several boards, counts how often each kind of move occurred
and prints a table. Plain random play makes small patterns; the *growing* driver avoids the end of the
episode and takes back extensions that cannot fold, so that patterns grow large. The checks themselves are
in :mod:`tests.sheet_checks`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.boundary import is_own_image
from origami_lab.game.kernels.play import Actions, leaf_at, play_action, settle
from origami_lab.game.kernels.state import (
    FIRST,
    NOT_FOLDABLE,
    RUNNING,
    SECOND,
    SELECTION,
    STRAIGHT,
    STUCK,
    THIRD,
    Record,
    States,
    board_points,
    code_x,
    code_y,
    copy_state,
    point_x,
    point_y,
)
from origami_lab.game.kernels.straight_sectors import opposite, plane_side
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start
from origami_lab.jit import kernel
from tests.sheet_checks import check_sheets

KINDS = (
    "extension",
    "merge prev",
    "merge next",
    "merge both",
    "merge axis leaf",  # into a neighbour that lies on an axis
    "on segment",  # an outer child on the boundary segment
    "on seam",  # the same, on the segment between a leaf and its image
    "child on start",  # a new outer child on the start axis, where the image merges
    "child on end",
    "leaf on start",  # an extended leaf on the start axis (of xyd: a diagonal)
    "leaf on end",
    "source start",
    "source end",
    "source on boundary",
    "mode -",
    "mode +",
    "taken back",  # by the growing driver
    "straight leaf",  # a leaf with an incoming sector of π
    "straight on",  # an outer child straight on from an incoming crease
)
STATUSES = ("running", "terminated", "stuck", "not foldable", "full", "stuck inside")


@kernel
def classify(s: Record, r: Record, counts: NDArray[np.int64]) -> None:
    """Count what kind of extension the selected leaf, its outer children chosen, is about to have."""
    v = s.selected
    counts[0] += 1
    counts[14 if s.mode < 0 else 15] += 1
    x, y = s.xy[v, 0], s.xy[v, 1]
    merges = np.zeros(2, np.bool_)
    for side in range(2):
        code = s.prev[v] if side == 0 else s.next[v]
        qx, qy = (s.first_x, s.first_y) if side == 0 else (s.second_x, s.second_y)
        nx, ny = code_x(s, r, code), code_y(s, r, code)
        own = s.axis[v] == 0 and is_own_image(s, r, v, code)
        if qx == nx and qy == ny:
            merges[side] = True
            if s.axis[v] == 0 and s.axis[code >> 3] != 0:
                counts[4] += 1
        elif (nx - x) * (qy - y) == (ny - y) * (qx - x):
            counts[6 if own else 5] += 1
        if own:
            for i in range(r.n_axes):
                if r.normals[i, 0] * qx + r.normals[i, 1] * qy == 0:
                    counts[7 + side] += 1
    if merges[0] and merges[1]:
        counts[3] += 1
    elif merges[0]:
        counts[1] += 1
    elif merges[1]:
        counts[2] += 1
    if s.axis[v] != 0:
        counts[9 if v == s.head else 10] += 1
    if s.locked[v] == STRAIGHT:
        counts[17] += 1
    elif plane_side(s, r) >= 0:
        counts[18] += 1


@kernel
def makes_half_turn(s: Record, r: Record, action: int) -> bool:
    """Whether a legal action selects a leaf with a sector of π, or lays an outer child straight on from a crease."""
    points = board_points(r)
    at = action % points
    x, y = point_x(r, at), point_y(r, at)
    if s.phase == SELECTION:
        return action < 2 * points and s.locked[leaf_at(s, x, y)] == STRAIGHT
    if s.phase != FIRST and s.phase != SECOND:
        return False
    v = s.selected
    x, y = x - s.xy[v, 0], y - s.xy[v, 1]
    crease = s.last[v] if s.phase == FIRST else s.first[v]
    return opposite(code_x(s, r, crease) - s.xy[v, 0], code_y(s, r, crease) - s.xy[v, 1], x, y)


@kernel
def play_counted(
    states: States,
    i: int,
    spare: States,
    rules: States,
    draws: NDArray[np.float64],
    retries: int,
    seek: bool,
    legal: Actions,
    counts: NDArray[np.int64],
    middles: NDArray[np.int64],
) -> int:
    """Play state i to its end with uniform actions; returns the number of extensions.

    With ``retries`` > 0 the end of the episode is avoided and an extension that cannot be completed is taken
    back, until there were that many or the draws are used up. With ``seek`` every other action is one that makes a
    sector of π, where there is one. ``middles`` (n, 5) receives leaf x, y, middle
    child x, y and mode of each extension.
    """
    s, r = states[i], rules[0]
    terminate = 3 * board_points(r)
    done = taken_back = 0
    before = np.zeros_like(counts)
    for draw in draws:
        n = settle(s, r, legal)
        failed = s.status == NOT_FOLDABLE or (s.status == STUCK and s.phase != SELECTION)
        if failed and taken_back < retries:
            taken_back += 1
            copy_state(s, spare[0])
            counts[:] = before
            counts[16] += 1
            n = settle(s, r, legal)
        if n == 0:
            break
        action = legal[int(draw * n)]
        if retries > 0 and action == terminate and n > 1:
            action = legal[0]
        if seek and draw * n % 1.0 < 0.5:
            for j in range(n):
                other = legal[(int(draw * n) + j) % n]
                if makes_half_turn(s, r, other):
                    action = other
                    break
        if s.phase == SELECTION:
            copy_state(spare[0], s)
            before[:] = counts
            if action > terminate:
                counts[11 if action < terminate + 3 else 12 if action < terminate + 5 else 13] += 1
        elif s.phase == THIRD:
            v = s.selected
            middles[done, 0], middles[done, 1] = s.xy[v, 0], s.xy[v, 1]
            at = action - 2 * board_points(r)
            middles[done, 2], middles[done, 3], middles[done, 4] = point_x(r, at), point_y(r, at), s.mode
            classify(s, r, counts)
        extensions = s.n_extensions
        play_action(s, r, action)
        done += s.n_extensions - extensions
        if s.status == NOT_FOLDABLE:
            counts[:] = before
    settle(s, r, legal)
    return done


@kernel
def replay_flipped(states: States, i: int, source: States, j: int, rules: States, legal: Actions) -> int:
    """Replay with all modes and signs flipped; returns how many actions were legal before one was not."""
    s, t, r = states[i], source[j], rules[0]
    n = board_points(r)
    for k in range(t.n_actions):
        action = t.actions[k]
        if action < n:
            action += n
        elif action < 2 * n:
            action -= n
        elif action > 3 * n:
            action = 3 * n + 1 + ((action - 3 * n - 1) ^ 1)
        count = settle(s, r, legal)
        found = False
        for m in range(count):
            found = found or legal[m] == action
        if not found:
            return k
        play_action(s, r, action)
    settle(s, r, legal)
    return int(t.n_actions)


_DIAMOND = ((2, 0), (0, 2), (-2, 0), (0, -2))
_HEXAGON = ((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1))
STARTS: dict[str, tuple[Start, tuple[str, ...]]] = {
    "square": (Square("choose"), ("none", "y", "x", "xy", "xyd")),
    "crease": (Crease("choose"), ("none", "y")),
    "any-square": (Square("choose", "choose"), ("none", "y", "x", "xy", "xyd")),
    "rectangle": (Rectangle(), ("none", "y", "x", "xy")),
    "any-crease": (Crease(ends="choose"), ("none", "y", "x")),
    "lower-crease": (Crease(ends="choose", stays="lower"), ("none", "y", "x")),
    "diamond": (Panel(_DIAMOND), ("none", "y", "x", "xy", "xyd")),
    "mixed-panel": (Panel(_HEXAGON, (1, 1, -1, 1, 1, -1)), ("none", "y", "x", "xy")),
    # two of its sides are driven, and two corners have no crease
    "bare-panel": (Panel(_HEXAGON, (0, 0, 1, 0, 0, 1)), ("none", "y", "x", "xy")),
}
"""Start patterns, and the symmetry groups that they have."""


@dataclass(frozen=True)
class Configuration:
    """One way to play."""

    symmetry: str
    start: str
    board: int | tuple[int, int]
    length: float | None
    growing: bool = False
    sources: bool | str = True
    straight: bool = False
    """Whether sectors of π are sought."""

    def game(self, capacity: int | None = None) -> Game:
        start, _ = STARTS[self.start]
        width, height = self.sides
        return Game(
            symmetry=self.symmetry,
            start=start,
            board_width=width,
            board_height=height,
            max_crease_length=self.length,
            source_action=self.sources,
            capacity=capacity,
        )

    @property
    def sides(self) -> tuple[int, int]:
        """Points of the board along x and along y."""
        return (self.board, self.board) if isinstance(self.board, int) else self.board

    def __str__(self) -> str:
        length = "∞" if self.length is None else f"{self.length:g}"
        anywhere = (" sources" if self.sources == "boundary" else "") + (" straight" if self.straight else "")
        board = f"{self.board:>2}" if isinstance(self.board, int) else "{}x{}".format(*self.board)
        return f"{self.symmetry:>4} {self.start} {board} {length:>3}{' grow' if self.growing else ''}{anywhere}"


def configurations(growing: bool) -> Iterator[Configuration]:
    """Each symmetry group × start pattern × board × maximum crease length."""
    for start, (_, symmetries) in STARTS.items():
        for symmetry in symmetries:
            # a board that is wider than high has no diagonal symmetry
            sides: list[tuple[int, int]] = [] if symmetry == "xyd" else [(13, 9), (7, 21)]
            boards: list[int | tuple[int, int]] = [9, 13, 25, *sides]
            for board in boards:
                for length in (None, 2.9):
                    yield Configuration(symmetry, start, board, length, growing)
                    if start in ("square", "any-crease", "bare-panel"):
                        yield Configuration(symmetry, start, board, length, growing, "boundary")
                        yield Configuration(symmetry, start, board, length, growing, "boundary", straight=True)


def _flipped_differs(game: Game, states: States, flipped: States, i: int, legal: Actions) -> str:
    """What is wrong with the mirror image in z, played by flipping all modes and signs."""
    game.clear(flipped, i)
    s, t = states[i], flipped[i]
    played = replay_flipped(flipped, i, states, i, game.rules.record, legal)
    if played < s["n_actions"]:
        return f"flipped action {played} is not legal"
    n, reach = int(s["n_vertices"]), int(s["reach"])
    if any(s[field] != t[field] for field in ("n_vertices", "reach", "status", "n_triangles")):
        return "the flipped episode ends in another state"
    if not np.array_equal(s["position"][:n, :reach] * [1, 1, -1], t["position"][:n, :reach]):
        return "flipped positions are not the mirror image in z"
    return ""


@dataclass
class Tally:
    """Counts of one configuration."""

    counts: NDArray[np.int64]
    statuses: NDArray[np.int64]
    largest: int
    error: float
    """Largest deviation of a panel from its flat self, relative to its size, or of a vertex from closure."""
    violations: list[str]


def play_and_check(configuration: Configuration, episodes: int, seed: int = 0, capacity: int | None = None) -> Tally:
    """Play episodes of one configuration and check every invariant after each."""
    growing = configuration.growing
    game = configuration.game(capacity or (96 if growing else 48))
    rng = np.random.default_rng([seed, episodes])
    batch = 8 if growing else 100
    states, flipped, spare = game.new_states(batch), game.new_states(batch), game.new_states(1)
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    middles = np.zeros((batch, game.rules.capacity, 5), dtype=np.int64)
    counts = np.zeros(len(KINDS), dtype=np.int64)
    tally = Tally(counts, np.zeros(len(STATUSES), dtype=np.int64), 0, 0.0, [])
    for first in range(0, episodes, batch):
        n = min(batch, episodes - first)
        extensions = np.zeros(n, dtype=np.int64)
        for i in range(n):
            game.clear(states, i)
            draws = rng.random(1200 if growing else 400)
            extensions[i] = play_counted(
                *(states, i, spare, game.rules.record, draws, 60 if growing else 0, configuration.straight),
                *(legal, counts, middles[i]),
            )
            status, inside = int(states[i]["status"]), int(states[i]["phase"]) != SELECTION
            tally.statuses[5 if status == STUCK and inside else status] += 1
            if status == RUNNING and not growing:
                tally.violations.append(f"{configuration} episode {first + i}: never ended")
            problem = _flipped_differs(game, states, flipped, i, legal)
            if problem:
                tally.violations.append(f"{configuration} episode {first + i}: {problem}")
        report = check_sheets(game, states[:n], middles[:n], extensions)
        tally.largest = max(tally.largest, report.largest)
        tally.error = max(tally.error, report.error)
        for i, problem in report.violations:
            actions = game.finished_actions(states, i)
            tally.violations.append(f"{configuration} episode {first + i}: {problem}\n  actions {actions}")
    return tally


def main(arguments: list[str] | None = None) -> int:
    """Print the table of counts; the exit code says whether anything was violated."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--episodes", type=int, default=1000, help="for each configuration")
    parser.add_argument("--growing", type=int, default=100, help="growing episodes for each configuration")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="only configurations whose name holds this")
    options = parser.parse_args(arguments)
    out = sys.stdout
    names = (*KINDS, *STATUSES, "largest", "error", "s")
    out.write("configuration\t" + "\t".join(names) + "\n")
    violations: list[str] = []
    for growing, episodes in ((False, options.episodes), (True, options.growing)):
        for configuration in configurations(growing):
            if episodes == 0 or options.only not in str(configuration):
                continue
            started = time.perf_counter()
            tally = play_and_check(configuration, episodes, options.seed)
            seconds = time.perf_counter() - started
            numbers = (*tally.counts, *tally.statuses, tally.largest, f"{tally.error:.1e}", f"{seconds:.1f}")
            out.write(f"{configuration}\t" + "\t".join(str(value) for value in numbers) + "\n")
            out.flush()
            violations += tally.violations
    for violation in violations[:20]:
        out.write(violation + "\n")
    for what, count in Counter(v.split("\n")[0].split(": ")[1] for v in violations).most_common():
        out.write(f"{count} × {what}\n")
    out.write(f"{len(violations)} violations\n")
    return int(bool(violations))


if __name__ == "__main__":
    sys.exit(main())
