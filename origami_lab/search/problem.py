"""The problem a searcher works on: a game, an objective, and a budget counted in one place.

A searcher plays on *positions*, pairs of a game state and the evaluator's notes on it, through the methods here: that
is how every interaction is counted, the best design kept, and progress reported.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import branch, copy_to, legal_of, play_uniform, step
from origami_lab.game.kernels.state import RUNNING, States
from origami_lab.objectives.compiled_score import CompiledScore
from origami_lab.objectives.objective import Evaluator, Memos, Score, bind
from origami_lab.search.checkpoints import Arrays, Checkpoints, pack, unpack
from origami_lab.search.dense_check import certified_reach
from origami_lab.search.random_stream import Draws

Actions = NDArray[np.int32]

PROGRESS_SECONDS = 0.25
MOST_VETTED = 20
"""Designs that are vetted in a search before the next one that reaches the goal ends it unasked."""
_SAVED = ("interactions", "episodes", "rejected", "vetted", "places_evaluated", "best_value")


@dataclass(frozen=True)
class Improvement:
    """A new best design: after how many interactions, its return, its driving angle's index, its actions."""

    interaction: int
    value: float
    angle: int
    actions: tuple[int, ...]


@dataclass(frozen=True)
class Outcome:
    """The result of a search."""

    value: float
    """The best return; −inf if no episode succeeded."""
    angle: int
    """Index of its driving angle among the game's; −1 if no episode succeeded."""
    actions: tuple[int, ...]
    """Legal actions that replay it; the start pattern's if no episode succeeded."""
    interactions: int
    interactions_to_best: int
    improvements: tuple[Improvement, ...]
    succeeded: bool
    episodes: int
    rejected: int
    """Improvements refused because their dense motion collides."""
    places_evaluated: int = 0
    """Places whose closed form alone told that they may or may not be played; they are no interactions."""


class SearchEnded(Exception):  # noqa: N818 - an end, not an error
    """Play went on after ``problem.done``. The runner takes it as the end of the search."""


class Searcher(Protocol):
    """A search method."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        """Play until ``problem.done``; the problem keeps the best design.

        All randomness comes from ``rng``, so that one seed gives one result, bit for bit.
        """
        ...


SearcherState = Mapping[str, NDArray[Any]]
"""What a searcher saves, by names of its own: arrays of numbers or text."""


@runtime_checkable
class LastingSearcher(Searcher, Protocol):
    """A searcher that can go on where another one of its kind has ended."""

    def save(self) -> Mapping[str, ArrayLike]:
        """Its state after ``search`` has ended, wherever that was: arrays of numbers or text."""
        ...

    def load(self, state: SearcherState) -> None:
        """Take up a saved state, before ``search``, which then goes on."""
        ...


@dataclass(eq=False)
class Positions:
    """An array of game states with the evaluator's notes on each; :meth:`Problem.grow` makes room for more."""

    states: States
    memos: Memos

    def __len__(self) -> int:
        return len(self.states)


class Problem:
    """A game, an objective and a budget of interactions.

    Parameters
    ----------
    game, objective
        Any object with ``score(sheet)`` serves as objective; see :mod:`origami_lab.objectives.objective`.
    budget
        Interactions that may be played in all.
    certify
        Whether an improvement counts only if its motion is free of collisions at ten sub-steps between each pair of
        driving angles up to its best one.
    on_progress
        Called a few times a second while the search runs.
    should_stop
        Asked as often; once it says yes the search ends with what it has.
    goal
        A return that is good enough: the search ends once it is reached.
    vets
        Asked about the actions and the driving angle of a design that reaches the goal: one that it refuses is no
        improvement, and the search goes on.
    time_is_up
        Asked as often as ``should_stop``; once it says yes the search has come to its end, too.
    begun
        What was found before, where a search goes on: its interactions count, and its best is to be exceeded.
    checkpoints
        Where a searcher may save itself on the way (:meth:`save`), and finds what it saved when it was killed.
    """

    def __init__(
        self,
        game: Game,
        objective: Any,
        budget: int,
        *,
        certify: bool = True,
        on_progress: Callable[[Problem], None] | None = None,
        should_stop: Callable[[], bool] | None = None,
        goal: float = math.inf,
        vets: Callable[[Sequence[int], int], bool] | None = None,
        time_is_up: Callable[[], bool] | None = None,
        begun: Outcome | None = None,
        checkpoints: Checkpoints | None = None,
    ) -> None:
        self.game, self.objective, self.budget, self.certify = game, objective, budget, certify
        self.goal = goal
        self.evaluator: Evaluator = bind(objective, game)
        self._exact_value = getattr(self.evaluator, "exact_value", None)
        self.interactions = 0
        self.episodes = 0
        self.rejected = 0
        self.vetted = 0
        self.places_evaluated = 0
        """Counted by searchers that look at places before they play them."""
        self.best_value = -math.inf
        self.improvements: list[Improvement] = []
        if begun is not None:
            self.interactions, self.episodes, self.rejected = begun.interactions, begun.episodes, begun.rejected
            self.places_evaluated, self.best_value = begun.places_evaluated, begun.value
            self.improvements += begun.improvements
        self._vets = vets
        self._on_progress, self._should_stop, self._time_is_up = on_progress, should_stop, time_is_up
        self._checkpoints = checkpoints
        self._stopped = self._late = False
        self._next_check = 0
        self._check_every = 1
        self._last_check = time.monotonic()
        self._legal = np.empty(game.rules.max_legal, dtype=np.int32)
        self._scratch = self.new_positions(1)

    @property
    def compiled_score(self) -> CompiledScore | None:
        """What kernels ask for the return of an episode, see :mod:`origami_lab.objectives.compiled_score`.

        None where only :meth:`finish` can tell. With it Python need hear of those episodes only that may be the best;
        whoever plays others in a kernel counts them in ``episodes``.
        """
        return getattr(self.evaluator, "compiled_score", None)

    # --- the budget --------------------------------------------------------------------------------------------------

    @property
    def done(self) -> bool:
        """Whether the budget is spent, the goal reached, the time up, or the search was asked to stop."""
        return self._stopped or self._late or self.interactions >= self.budget or self.best_value >= self.goal

    @property
    def stopped(self) -> bool:
        """Whether the search was asked to stop, and has heard it."""
        return self._stopped

    @property
    def is_late(self) -> bool:
        """Whether the time is up, and the search has heard it."""
        return self._late

    @property
    def remaining(self) -> int:
        return self.budget - self.interactions

    def spend(self, interactions: int) -> None:
        """Count interactions; whoever plays on after the end is told so by :class:`SearchEnded`."""
        if self.done:
            raise SearchEnded("the search has ended: ask problem.done before playing on")
        self.interactions += interactions
        if self.interactions >= self._next_check:
            self._look_up()

    def _look_up(self) -> None:
        """Report progress and ask whether to stop, about four times a second whatever the pace."""
        now = time.monotonic()
        pace = self._check_every / max(now - self._last_check, 1e-6)
        self._check_every = int(min(max(pace * PROGRESS_SECONDS, 1), 2 * self._check_every + 16))
        self._last_check = now
        self._next_check = self.interactions + self._check_every
        if self._on_progress is not None:
            self._on_progress(self)
        if self._should_stop is not None and self._should_stop():
            self._stopped = True
        if self._time_is_up is not None and self._time_is_up():
            self._late = True

    # --- playing -----------------------------------------------------------------------------------------------------

    def new_positions(self, count: int) -> Positions:
        """Positions where episodes begin."""
        return Positions(self.game.new_states(count), self.evaluator.new_memos(count))

    def grow(self, positions: Positions) -> None:
        """Make room for twice as many positions, keeping those there are."""
        count = len(positions)
        more = self.new_positions(2 * count)
        more.states[:count], more.memos[:count] = positions.states, positions.memos
        positions.states, positions.memos = more.states, more.memos

    def clear(self, positions: Positions, i: int) -> Actions:
        """Go back to where episodes begin; returns the legal actions."""
        self.game.clear(positions.states, i)
        self.evaluator.clear(positions.memos, i)
        return self._legal[: legal_of(positions.states, i, self.game.rules.record, self._legal)]

    def play(self, positions: Positions, i: int, action: int, *, count: bool = True) -> Actions:
        """Play a legal action, one interaction; returns the actions legal afterwards, none if the episode has ended.

        They are valid until the next call. ``count=False`` plays again what was counted before.
        """
        if count:
            self.spend(1)
        n = step(positions.states, i, self.game.rules.record, action, self._legal)
        return self._legal[:n]

    def branch(self, positions: Positions, i: int, j: int, action: int, *, count: bool = True) -> tuple[Actions, bool]:
        """Make position i the one that a legal action leads to from position j: copy and play in one.

        Returns the actions legal there, none if the episode has ended, and whether the move is complete: only then has
        the sheet changed. ``count=False`` comes back to a position whose interaction was counted before.
        """
        if count:
            self.spend(1)
        n, complete = branch(positions.states, i, j, self.game.rules.record, action, self._legal)
        positions.memos[i] = positions.memos[j]
        return self._legal[:n], complete

    def play_uniform(self, positions: Positions, i: int, draws: Draws) -> bool:
        """Play uniformly random actions to the end of the episode; False if the budget ended it first."""
        states, rules = positions.states, self.game.rules.record
        while True:
            limit = min(self.remaining, draws.available)
            played = play_uniform(states, i, rules, draws.block, draws.used, limit, self._legal)
            draws.use(played)
            self.spend(played)
            if states["status"][i] != RUNNING:
                return True
            if self.done:
                return False

    def bound(self, positions: Positions, i: int) -> float:
        """A bound that no continuation can exceed; any value not above the best return where none can."""
        return self.evaluator.bound(positions.states, positions.memos, i, self.best_value)

    def finish(self, positions: Positions, i: int, *, above: float | None = None) -> float:
        """The return of an episode that has ended; a new best is checked, kept and reported.

        Returns not above ``above`` (by default the best return so far) may be given as −inf. A new best that the dense
        check refuses gets the return of the part of its motion that is free, the penalty if there is none.
        """
        self.episodes += 1
        game, states = self.game, positions.states
        if game.is_penalised(states, i):
            return game.penalty
        limit = self.best_value if above is None else above
        if limit == -math.inf and self._exact_value is not None:
            value = float(self._exact_value(states, positions.memos, i))
            if value <= self.best_value:
                return value
        score = self.evaluator.score(states, positions.memos, i, limit)
        if score.angle >= 0 and score.value > self.best_value:
            return self._consider(positions, i, score, limit)
        return score.value

    def trim(self, positions: Positions, i: int) -> bool:
        """Cut a position's reach to what a dense check of its motion certifies; whether that changed it.

        Every continuation inherits the cut, so it pays where continuations keep being refused.
        """
        actions = self.game.finished_actions(positions.states, i)
        reach = int(positions.states["reach"][i])
        certified = certified_reach(self.game, actions, reach, scratch=self._scratch.states)
        positions.states["reach"][i] = certified
        return certified < reach

    def _consider(self, positions: Positions, i: int, score: Score, limit: float) -> float:
        actions = self.game.finished_actions(positions.states, i)
        if self.certify:
            reach = certified_reach(self.game, actions, score.angle + 1, scratch=self._scratch.states)
            if reach <= score.angle:
                self.rejected += 1
                if reach <= self.game.first_angle:
                    return self.game.penalty
                # the part of the motion that is free may still be an improvement
                trial = self._scratch
                copy_to(trial.states, 0, positions.states, i)
                self.evaluator.clear(trial.memos, 0)
                trial.states["reach"][0] = reach
                score = self.evaluator.score(trial.states, trial.memos, 0, limit)
                if score.angle < 0 or not score.value > self.best_value:
                    return score.value
        if score.value >= self.goal and not self._may_end_with(actions, score.angle):
            self.rejected += 1
            return self.game.penalty
        self.best_value = score.value
        self.improvements.append(Improvement(self.interactions, score.value, score.angle, actions))
        return score.value

    def _may_end_with(self, actions: tuple[int, ...], angle: int) -> bool:
        """Whether the search may end with a design that reaches the goal; a few are vetted, as that takes a second."""
        if self._vets is None or self.vetted >= MOST_VETTED:
            return True
        self.vetted += 1
        return self._vets(actions, angle)

    # --- saving ------------------------------------------------------------------------------------------------------

    def checkpoint(self, arrays: Callable[[], Arrays]) -> None:
        """Save the search if it is time to, about twice a minute: the problem, and arrays of numbers of the searcher's.

        They must be all that its further course depends on, so that it comes to the same, bit for bit, gone on with or
        not. A search that is to be saved is long, and asks often.
        """
        if self._checkpoints is not None and self._checkpoints.due:
            facts: dict[str, Any] = {name: getattr(self, name) for name in _SAVED}
            facts["improvements"] = [astuple(each) for each in self.improvements]
            self._checkpoints.write(pack(facts, arrays()))

    def last_checkpoint(self) -> dict[str, NDArray[Any]] | None:
        """The arrays that were saved last, and the problem as it was then; None if nothing was."""
        content = None if self._checkpoints is None else self._checkpoints.read()
        found = None if content is None else unpack(content)
        if found is None:
            return None
        facts, arrays = found
        self.improvements = [
            Improvement(at, value, angle, tuple(actions)) for at, value, angle, actions in facts["improvements"]
        ]
        for name in _SAVED:
            setattr(self, name, facts.get(name, 0))  # not all are in checkpoints of before
        return arrays

    # --- the result --------------------------------------------------------------------------------------------------

    def outcome(self) -> Outcome:
        """The best design so far; the start pattern if no episode succeeded."""
        if self.improvements:
            best = self.improvements[-1]
            value, angle, actions, to_best = best.value, best.angle, best.actions, best.interaction
        else:
            value, angle, actions, to_best = -math.inf, -1, self.game.bare_start(), 0
        return Outcome(
            value=value,
            angle=angle,
            actions=actions,
            interactions=self.interactions,
            interactions_to_best=to_best,
            improvements=tuple(self.improvements),
            succeeded=bool(self.improvements),
            episodes=self.episodes,
            rejected=self.rejected,
            places_evaluated=self.places_evaluated,
        )
