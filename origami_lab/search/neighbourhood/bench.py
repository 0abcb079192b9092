"""The workbench of the runs: the states that designs are laid on, grown and compared, and what that costs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.undo import note_dtype
from origami_lab.game.move_table import ACTIONS, table_of
from origami_lab.search.neighbourhood.changes import Change
from origami_lab.search.neighbourhood.ground import DEPTHS, PLACE_DRAWS, WORK, Ground, Room, place_start
from origami_lab.search.neighbourhood.known_strays import nothing_known
from origami_lab.search.neighbourhood.one_run import RunDesign
from origami_lab.search.neighbourhood.relaying import relay
from origami_lab.search.neighbourhood.threshold import Aim
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

_NOTHING = np.empty(0, dtype=np.int32)


class Bench:
    """States at one driving angle.

    Motions are followed up to that angle only: kinematics, collisions and scores touch no larger one, and what does
    not reach it does not fold. Scores are the game's own.
    """

    def __init__(self, problem: Problem, draws: Draws) -> None:
        game = problem.game
        self.problem, self.draws = problem, draws
        self.positions = problem.new_positions(3)
        self.origin = game.new_states(1)
        self.rules, self.plain = game.rules.record.copy(), game.rules.record.copy()
        self.plain["collisions"] = 0
        self.angle = game.first_angle
        self.own = int(self.origin["n_vertices"][0])
        longest = float(game.rules.record["max_length_sq"][0]) ** 0.5
        across = 2 * int(min(longest, game.board_size)) + 1
        places = min(game.rules.points, across * across)
        self.room = Room(
            np.empty(ACTIONS, dtype=note_dtype(len(game.angles))),
            np.empty(game.rules.max_legal, dtype=np.int32),
            np.empty((DEPTHS, places), dtype=np.int32),
            nothing_known(),
        )
        self.ground = Ground(self.positions.states, self.origin, self.rules, self.plain, self.room)

    @property
    def angles(self) -> range:
        """Indices of the driving angles that runs can have: usable, and reached by the start pattern."""
        return range(self.problem.game.first_angle, int(self.origin["reach"][0]))

    def begin(self, angle: int, i: int = WORK) -> None:
        """Go back to where episodes begin, to fold to a driving angle."""
        problem, states = self.problem, self.positions.states
        problem.game.clear(states, i)
        problem.evaluator.clear(self.positions.memos, i)
        states["reach"][i] = min(int(states["reach"][i]), angle + 1)
        self.fold_to(angle)

    def fold_to(self, angle: int) -> None:
        """What does not fold to this driving angle is refused from now on."""
        self.angle = angle
        self.rules["min_reach"] = self.plain["min_reach"] = angle + 1

    def place(self, angle: int) -> bool:
        """Begin with a random start pattern; False if it cost the last interaction."""
        problem, draws = self.problem, self.draws
        self.begin(angle)
        draws.reserve(PLACE_DRAWS)
        played = int(place_start(self.ground, draws.block, draws.used, problem.remaining))
        if played > 0:
            draws.use(played)
            self.own = int(self.positions.states["n_vertices"][WORK])
            self.spend(played)
        return not problem.done

    def lay(self, change: Change, aim: Aim | None, angle: int, *, recheck: bool = False) -> None:
        """Lay a changed design (:func:`~.relaying.relay`), and count what that costs."""
        self.begin(angle)
        design = change.design
        sheet = self.positions.states, WORK, self.rules, self.plain
        table = design.moves, design.points, change.goes, change.first
        self.spend(relay(*sheet, aim, *table, recheck, self.room.notes))

    def spend(self, interactions: int) -> None:
        """Count interactions, as far as the budget goes: a relay may have been longer."""
        interactions = min(interactions, self.problem.remaining)
        if interactions > 0 and not self.problem.done:
            self.problem.spend(interactions)

    def copy(self, target: int, source: int) -> None:
        """Make a position the same as another."""
        copy_to(self.positions.states, target, self.positions.states, source)
        self.positions.memos[target] = self.positions.memos[source]

    def read(self, i: int, uncovered: NDArray[np.int32] = _NOTHING) -> RunDesign:
        """The design on a state."""
        states = self.positions.states
        moves, points = table_of(states, self.rules, self.origin, i)
        places = states["position"][i][: len(points), self.angle].copy()
        return RunDesign(moves, points, places, self.own, uncovered)

    def bound(self, i: int, above: float) -> float:
        """What no continuation of a state can exceed; any value not above ``above`` if that is so."""
        return self.problem.evaluator.bound(self.positions.states, self.positions.memos, i, above)

    def score(self, i: int, above: float = -math.inf) -> float:
        """The return of ending an episode on a state, which costs an interaction; −inf will do if not ``above``."""
        self.problem.spend(1)
        return self.problem.finish(self.positions, i, above=above)
