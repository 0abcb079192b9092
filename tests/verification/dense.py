"""Random patterns of the game, and a plain look at thousands of states of their motion.

What it shares with the verification is nothing: states come from the game's closed forms, crossings from its triangle
test, which is held against rational arithmetic on its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start
from origami_lab.geometry.triangles import triangles_cross
from origami_lab.jit import kernel

Array = NDArray[np.float64]

SYMMETRIES = ("none", "x", "y", "xy", "xyd")
BOARDS = (7, 9, 13, 17, 25)
_HEXAGON = ((2, 1), (0, 2), (-2, 1), (-2, -1), (0, -2), (2, -1))
STARTS: tuple[Start, ...] = (
    *(Square("choose"), Square(1), Square(2), Square("choose", "choose"), Rectangle()),
    *(Crease(0), Crease("choose"), Crease(ends="choose"), Crease(ends="choose", stays="lower")),
    Panel(((2, 0), (0, 2), (-2, 0), (0, -2))),
    Panel(_HEXAGON, (1, 1, -1, 1, 1, -1)),
    Panel(_HEXAGON, (0, 0, 1, 0, 0, 1)),  # two sides are driven, and two corners have no crease
)
SOURCES: tuple[bool | str, ...] = (False, True, "boundary")
STEPS = 1000
"""States between the flat sheet and the last state of a design that are looked at."""
DEEP = 1e-6
"""Board cells: panels that reach into each other by more are seen to cross."""
_FLAT = math.radians(3.0)
"""Driving angles below this may be too flat for the game, which takes outer creases within 1e-6 of a line for one."""
_NEAR_PI = 3.0
"""Radians: a crease whose angle changes its sign beyond this has passed ±180°."""


@dataclass(frozen=True)
class RandomPattern:
    """What a random player made."""

    game: Game
    actions: tuple[int, ...]
    reach: int
    """How many of the game's driving angles it folds to, with or without crossings."""

    def design(self) -> CreasePattern:
        """The pattern with its states at those angles."""
        return self.game.motion(self.actions, self.game.angles[: self.reach], {})

    def top(self) -> float:
        """The last driving angle, radians."""
        return float(self.game.angles[self.reach - 1])


def random_pattern(rng: np.random.Generator, *, collisions: bool) -> RandomPattern:
    """A random episode of a random game: group, board, start, longest crease, number of driving angles, sources.

    With ``collisions`` the game keeps to its rule that panels do not cross at its driving angles.
    """
    while True:
        try:
            game = Game(
                start=STARTS[int(rng.integers(len(STARTS)))],
                symmetry=str(rng.choice(SYMMETRIES)),
                board_width=(width := int(rng.choice(BOARDS))),
                board_height=width if rng.integers(3) else int(rng.choice(BOARDS)),
                max_crease_length=[None, 3.0, 5.0][int(rng.integers(3))],
                driving_angle_count=int(rng.choice([1, 3, 10, 10])),
                source_action=SOURCES[int(rng.integers(len(SOURCES)))],
                collisions=collisions,
            )
        except InputError:  # not every start goes with every group
            continue
        states = game.new_states(1)
        game.clear(states)
        legal = game.legal(states)
        for _ in range(int(rng.integers(6, 60))):
            if not len(legal):
                break
            legal = game.play(states, int(rng.choice(legal)))
        if states["n_extensions"][0] < 1 or states["reach"][0] < 1:
            continue
        actions = tuple(int(action) for action in game.finished_actions(states))
        reach = int(game.replay(actions)["reach"][0])
        if reach:
            return RandomPattern(game, actions, reach)


@kernel
def crossings_at(points: Array, triangles: NDArray[np.int32], panels: NDArray[np.int32], tolerance: float) -> int:
    """How many pairs of triangles with at most one common vertex cross, of different panels."""
    found = 0
    for i in range(len(triangles)):
        for j in range(i):
            if panels[i] == panels[j]:
                continue
            shared = 0
            for a in triangles[i]:
                for b in triangles[j]:
                    if a == b:
                        shared += 1
            if shared < 2 and triangles_cross(points[triangles[i]], points[triangles[j]], tolerance):
                found += 1
    return found


def seen(design: CreasePattern, tolerance: float = DEEP) -> NDArray[np.bool_]:
    """(K,) whether panels cross at each state of a design."""
    return np.array(
        [
            crossings_at(np.ascontiguousarray(points), design.triangles, design.triangle_panels, tolerance) > 0
            for points in design.folded
        ]
    )


def passed(design: CreasePattern) -> NDArray[np.bool_]:
    """(K,) whether a crease has passed ±180° since the state before: its angle has jumped to the other sign."""
    angles = design.fold_angles
    before = np.concatenate([np.zeros((1, angles.shape[1])), angles[:-1]])
    return np.asarray(((np.abs(angles - before) > _NEAR_PI) & (np.abs(before) > _NEAR_PI / 2)).any(axis=1))


def _reaches(pattern: RandomPattern, angles: Array) -> bool:
    try:
        pattern.game.motion(pattern.actions, angles, {})
    except ValueError:
        return False
    return True


def first_crossing(pattern: RandomPattern, steps: int = STEPS, within: Sequence[float] = ()) -> float:
    """The driving angle of the first of many states at which panels cross or have passed each other at a crease.

    Parameters
    ----------
    within
        Driving angles (radians) around which to look a hundred times as closely.

    Returns
    -------
    Radians; infinite where no state shows a crossing.

    Raises ValueError where the game's motion does not exist between two of its angles.
    """
    top = pattern.top()
    angles = np.linspace(0.0, top, steps + 1)[1:]
    step = top / steps
    for angle in within:
        angles = np.concatenate([angles, np.linspace(max(angle - step, 1e-6), min(angle + step, top), 201)])
    angles = np.unique(angles[angles > 0.0])
    while angles[0] < _FLAT and not _reaches(pattern, angles[:1]):
        angles = angles[1:]
    motion = pattern.game.motion(pattern.actions, angles, {})
    bad = seen(motion) | passed(motion)
    return float(angles[int(np.argmax(bad))]) if bad.any() else math.inf
