"""The searchers as partners: a design continued, improved, repaired in a region, or its best next moves.

All of them are the package's own searches on a game that begins where the design stands (a start pattern of moves) or,
for an improvement, where the game does. What is found is reported as moves, which the board plays one by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.game.edits import without_vertices
from origami_lab.game.game import Game
from origami_lab.game.moves import Move, Point, Terminate
from origami_lab.game.start_file import CREASE_FIRST, SQUARE_FIRST
from origami_lab.game.start_from_moves import FromMoves
from origami_lab.game.start_patterns import Crease
from origami_lab.search.neighbourhood.given_design import state_of_design
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.problem import Improvement, Outcome, Problem, SearchEnded, Searcher

ROUNDING = 1e-9
LOOKS, MOST_SUGGESTIONS = 6, 5
"""Short searches behind suggestions, and how many moves are suggested."""


@dataclass(frozen=True)
class FoundDesign:
    """A design that a search has come to."""

    value: float
    angle: int
    moves: tuple[Move, ...]


@dataclass(frozen=True)
class SearchProgress:
    """How far a search is."""

    interactions: int
    best: float | None


Report = Callable[[SearchProgress | FoundDesign], None]


def without_end(moves: Sequence[Move]) -> tuple[Move, ...]:
    """Moves without the one that ends the game."""
    return tuple(move for move in moves if not isinstance(move, Terminate))


def game_from(game: Game, settings: Settings, moves: Sequence[Move]) -> Game:
    """The game in which moves are the start pattern; the game itself where there are none to begin with."""
    if len(moves) <= len(game.start_moves):
        return game
    first = getattr(game.start, "first", CREASE_FIRST if isinstance(game.start, Crease) else SQUARE_FIRST)
    rules = {**vars(settings.game), "driving_angle_fixed": game.driving_angle_fixed}
    return Game(start=FromMoves(tuple(moves), first, game.symmetry.name), **rules)


class Partner:
    """A searcher at work on a design of a game.

    Parameters
    ----------
    report
        Told of progress and of each design that is better than all before.
    should_stop
        Asked often.
    """

    def __init__(
        self, settings: Settings, game: Game, objective: Any, report: Report, should_stop: Callable[[], bool]
    ) -> None:
        self.settings, self.game, self.objective = settings, game, objective
        self.report, self.should_stop = report, should_stop
        self.interactions = 0

    def finish(
        self, actions: tuple[int, ...], worth: tuple[float, int] | None, make: Make, budget: int, seed: int
    ) -> None:
        """Go on from a design: all that is there stays."""
        self._search(game_from(self.game, self.settings, self._moves(actions)), worth, make(), budget, seed)

    def improve(
        self, actions: tuple[int, ...], worth: tuple[float, int] | None, make: Make, budget: int, seed: int
    ) -> None:
        """Look for a better design from the start pattern on; ``lns`` changes the present one first."""
        searcher, value = make(), worth
        # the log in the game's own start pattern, without an end
        own = self.game.finished_actions(self.game.replay_moves(self._moves(actions)))
        extended = int(self.game.replay(own)["n_extensions"][0]) > 0
        if isinstance(searcher, NeighbourhoodSearch) and value is not None and extended:
            state = state_of_design(searcher, self.game, own, value[1], value[0], budget)
            searcher.load({name: np.asarray(array) for name, array in state.items()})
        self._search(self.game, worth, searcher, budget, seed)

    def repair(
        self,
        actions: tuple[int, ...],
        worth: tuple[float, int] | None,
        make: Make,
        budget: int,
        seed: int,
        region: Sequence[Point],
    ) -> None:
        """Cut the vertices of a region off, with all that grew from them, and grow anew what is left."""
        own = self.game.finished_actions(self.game.replay_moves(self._moves(actions)))
        left = without_vertices(self.game, own, _extended(self.game, own, region))
        self._search(game_from(self.game, self.settings, self._moves(left)), worth, make(), budget, seed)

    def suggest(
        self, actions: tuple[int, ...], make: Make, budget: int, seed: int
    ) -> list[tuple[Move, float, FoundDesign]]:
        """The best next moves: those with which the designs of a few short searches go on, the best design's first."""
        moves = self._moves(actions)
        game, found = game_from(self.game, self.settings, moves), dict[Move, tuple[Move, float, FoundDesign]]()
        for look in range(LOOKS):
            if self.should_stop():
                break
            best = self._search(game, None, make(), max(1, budget // LOOKS), seed + look, quiet=True)
            if best is None:
                continue
            for move in self._playable_now(moves, best.moves):
                if move not in found or best.value > found[move][1]:
                    found[move] = move, best.value, best
        ranked = sorted(found.values(), key=lambda entry: -entry[1])
        return ranked[:MOST_SUGGESTIONS]

    def _playable_now(self, moves: tuple[Move, ...], whole: tuple[Move, ...]) -> Iterator[Move]:
        """The moves of a continuation that are legal at once."""
        states = self.game.replay_moves(moves)
        for move in without_end(whole)[len(moves) :]:
            trial = states.copy()
            with suppress(ValueError):
                for action in self.game.encode(move, trial):
                    self.game.play(trial, action)
                if self.game.moves(self.game.finished_actions(trial))[len(moves) :] == [move]:
                    yield move

    def _moves(self, actions: tuple[int, ...]) -> tuple[Move, ...]:
        return without_end(self.game.moves(actions))

    def _search(
        self,
        game: Game,
        worth: tuple[float, int] | None,
        searcher: Searcher,
        budget: int,
        seed: int,
        *,
        quiet: bool = False,
    ) -> FoundDesign | None:
        """One search in a game; what exceeds the present worth is reported, and the best returned."""
        before, told = self.interactions, 0
        present = shown = -math.inf if worth is None else worth[0]

        def look(problem: Problem) -> None:
            nonlocal told, shown
            self.interactions = before + problem.interactions
            best = problem.best_value
            self.report(SearchProgress(self.interactions, best if math.isfinite(best) else None))
            if len(problem.improvements) > told and not quiet:
                told = len(problem.improvements)
                if _is_better(best, shown):
                    shown = best
                    last = problem.improvements[-1]
                    self.report(FoundDesign(last.value, last.angle, without_end(game.moves(last.actions))))

        problem = Problem(
            game,
            self.objective,
            budget,
            certify=self.settings.certify,
            on_progress=look,
            should_stop=self.should_stop,
            begun=None if worth is None else _begun(game, worth),
        )
        told = len(problem.improvements)
        if getattr(searcher, "check_game", None) is not None:
            searcher.check_game(game)  # type: ignore[attr-defined]
        with suppress(SearchEnded):
            searcher.search(problem, np.random.default_rng(seed))
        look(problem)
        outcome = problem.outcome()
        if not outcome.succeeded or not _is_better(outcome.value, present):
            return None
        return FoundDesign(outcome.value, outcome.angle, without_end(game.moves(outcome.actions)))


def _is_better(value: float, present: float) -> bool:
    """Whether a return is above another one by more than rounding, by which a design and its mirror image differ."""
    return value > present and (math.isinf(present) or value - present > ROUNDING * max(1.0, abs(present)))


Make = Callable[[], Searcher]
"""Makes a fresh searcher."""


def _begun(game: Game, worth: tuple[float, int]) -> Outcome:
    """What a search that is to exceed a present design begins with."""
    value, angle = worth
    actions = game.bare_start()
    first = Improvement(0, value, angle, actions)
    return Outcome(value, angle, actions, 0, 0, (first,), succeeded=True, episodes=0, rejected=0)


def _extended(game: Game, actions: tuple[int, ...], region: Sequence[Point]) -> list[Point]:
    """The vertices of a region that can be cut off; raises InputError where there is none."""
    found = []
    for point in region:
        with suppress(InputError):
            without_vertices(game, actions, [point])
            found.append(point)
    if not found:
        raise InputError("region", f"{len(region)} points", "select vertices that grew from the start pattern first")
    return found
