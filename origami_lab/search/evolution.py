"""EVO (paper, appendix A): a population of value vectors, each of which plays one episode greedily in its values.

A value vector has 4d entries as in the paper, where d is the size of the playable area: the values of selecting each
point in mode −1 and in mode +1, then those of each location while mode −1 and while mode +1 is extended. The actions
that the paper's vector leaves out follow, one value each: terminate, the four sources, the placements.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from origami_lab.checks import Flag, Number, Whole, checked_arguments
from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import play_greedy
from origami_lab.game.kernels.state import RUNNING
from origami_lab.search.evolution_kernel import ALL, CANDIDATE, Generation, no_episodes, play_generation
from origami_lab.search.problem import Problem, SearcherState

Values = NDArray[np.float64]

_PACE = 4096
"""Interactions that are played at most between two looks at the clock."""


class EvolutionarySearch:
    """Selection and mutation of value vectors.

    A generation is evaluated in this order: the parents, mutated by ``sigma_1``; a copy of each, mutated by ``sigma_2``
    once more; another, by ``sigma_3``; newcomers. An agent that plays the same actions as one before it in its
    generation is worth −∞. The best become the parents of the next; which of equal ones is left to chance, or the same
    agents would stay in place, mutated least: returns are plateaus, as one point of the sheet or the target decides.

    Parameters
    ----------
    population
        Agents in a generation.
    parents
        The part of them that reproduces, at most a third.
    sigma_1, sigma_2, sigma_3
        Standard deviations of the mutations.
    elite
        So many of the best parents stay as they are (the paper: none).
    rescale
        Bring the parents' values to mean 0 and standard deviation 1 before they mutate (the paper: no). They play as
        they did, and mutations keep their strength: otherwise values grow from generation to generation.
    """

    @checked_arguments("search")
    def __init__(
        self,
        population: Annotated[int, Whole(3, 100_000)] = 128,
        parents: Annotated[float, Number(0, 1)] = 0.25,
        sigma_1: Annotated[float, Number(0, 1e6)] = 0.1,
        sigma_2: Annotated[float, Number(0, 1e6)] = 0.5,
        sigma_3: Annotated[float, Number(0, 1e6)] = 1.0,
        elite: Annotated[int, Whole(0, 100_000)] = 0,
        rescale: Annotated[bool, Flag()] = True,
    ) -> None:
        self.population, self.parents, most = population, round(parents * population), population // 3
        if not 1 <= self.parents <= most:
            raise InputError(
                "search.parents", parents, f"must make 1 to {most} parents of the population of {population}"
            )
        if elite > self.parents:
            raise InputError("search.elite", elite, f"must be a whole number from 0 to {self.parents}")
        self.sigmas, self.elite, self.rescale = (sigma_1, sigma_2, sigma_3), elite, rescale
        self._loaded: Values | None = None
        self._chosen: Values | None = None
        """The value vectors that the present generation came of; None for the first one, which is drawn."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        slots = value_slots(problem.game)
        arena = Tournament(problem, slots, self.parents)
        self._chosen, self._loaded = self._loaded, None
        if self._chosen is None:
            agents = rng.standard_normal((self.population, int(slots.max()) + 1))
        else:
            agents = self.offspring(self._chosen, rng)
        while True:
            returns = arena.evaluate(agents)
            if problem.done:
                return
            self._chosen = self.select(agents, returns, rng)
            agents = self.offspring(self._chosen, rng)

    def save(self) -> Mapping[str, ArrayLike]:
        """The parents of the generation that the end of the search cut off; nothing in the first one."""
        return {} if self._chosen is None else {"parents": self._chosen.astype(np.float32)}

    def load(self, state: SearcherState) -> None:
        """Take up saved parents, whose next generation is another one."""
        if "parents" in state:
            self._loaded = state["parents"].astype(np.float64)

    def next_generation(self, agents: Values, returns: Values, rng: np.random.Generator) -> Values:
        """The population that follows.

        Parameters
        ----------
        agents
            (population, m) value vectors.
        returns
            (population,) what each agent achieved.
        """
        return self.offspring(self.select(agents, returns, rng), rng)

    def select(self, agents: Values, returns: Values, rng: np.random.Generator) -> Values:
        """The best agents, which become parents, not mutated yet."""
        order = np.lexsort((rng.random(len(returns)), -returns))  # of equal returns at random
        chosen: Values = agents[order[: self.parents]]
        if self.rescale:
            chosen = chosen - chosen.mean(axis=1, keepdims=True)
            chosen /= chosen.std(axis=1, keepdims=True)
        return chosen

    def offspring(self, chosen: Values, rng: np.random.Generator) -> Values:
        """The population that those who were selected bring forth, themselves mutated first."""
        m, (sigma_1, sigma_2, sigma_3) = chosen.shape[1], self.sigmas
        parents = chosen.copy()
        parents[self.elite :] += sigma_1 * rng.standard_normal((self.parents - self.elite, m))
        return np.concatenate(
            [
                parents,
                parents + sigma_2 * rng.standard_normal(parents.shape),
                parents + sigma_3 * rng.standard_normal(parents.shape),
                rng.standard_normal((self.population - 3 * self.parents, m)),
            ]
        )


class Tournament:
    """Where agents play."""

    def __init__(self, problem: Problem, slots: NDArray[np.int32], parents: int) -> None:
        self.problem, self.slots, self.parents = problem, slots, parents
        self.positions = problem.new_positions(1)
        self.legal = np.empty(problem.game.rules.max_legal, dtype=np.int32)
        self.known: dict[bytes, float] = {}
        """Returns of the last generation's better action sequences, so that those played again are not scored again."""
        self.score = problem.compiled_score
        if self.score is not None:
            self.origin = problem.game.new_states(1)
            self.memos = problem.evaluator.new_memos(2)
            self.positions.memos = self.memos[:1]
            self.seen = no_episodes(0)
            """Those of the last generation."""

    def evaluate(self, agents: Values) -> Values:
        """The return of each agent; −inf where it cannot be enough to become a parent."""
        return self._evaluate(agents) if self.score is None else self._evaluate_compiled(agents)

    def _evaluate_compiled(self, agents: Values) -> Values:
        """The same where the score is compiled: a generation in a call, but for those that may be the best of all."""
        problem, game = self.problem, self.problem.game
        count = len(agents)
        generation = Generation(
            counters=np.zeros(3, dtype=np.int64),
            returns=np.full(count, -math.inf),
            ranked=np.full(self.parents, -math.inf),
            seen=no_episodes(count),
            known=self.seen,
        )
        self.seen = generation.seen
        given = math.nan
        while not problem.done:
            why, played, ended, below = play_generation(
                self.positions.states,
                self.origin,
                game.rules.record,
                self.memos,
                self.score,
                agents,
                self.slots,
                generation,
                game.penalty,
                problem.best_value,
                given,
                min(problem.remaining, _PACE),
                self.legal,
            )
            given = math.nan
            problem.episodes += ended
            problem.spend(played)
            if why == ALL:
                break
            if why == CANDIDATE:
                given = problem.finish(self.positions, 0, above=below)
        return generation.returns

    def _evaluate(self, agents: Values) -> Values:
        problem = self.problem
        returns = np.full(len(agents), -math.inf)
        seen: set[bytes] = set()
        found: dict[bytes, float] = {}
        best: list[float] = []  # the returns that would make parents, falling
        for agent, values in enumerate(agents):
            actions = self.play(values)
            if actions is None:
                break
            worst = best[-1] if len(best) == self.parents else -math.inf
            if actions in seen or actions in self.known:
                problem.episodes += 1
                value = -math.inf if actions in seen else self.known[actions]
            else:
                # one that equals the worst of the best may become a parent, too
                below = min(np.nextafter(worst, -math.inf), problem.best_value)
                value = problem.finish(self.positions, 0, above=below)
            seen.add(actions)
            if value >= worst and value > -math.inf:
                returns[agent] = found[actions] = value
                best = sorted([*best, value], reverse=True)[: self.parents]
            if problem.done:
                break
        self.known = found
        return returns

    def play(self, values: Values) -> bytes | None:
        """One episode, greedy in an agent's values; returns its actions, None if the budget ended it first."""
        problem, states = self.problem, self.positions.states
        problem.clear(self.positions, 0)
        while states["status"][0] == RUNNING:
            if problem.done:
                return None
            limit = min(problem.remaining, _PACE)
            problem.spend(play_greedy(states, 0, problem.game.rules.record, values, self.slots, limit, self.legal))
        return bytes(states["actions"][0][: states["n_actions"][0]].tobytes())


def value_slots(game: Game) -> NDArray[np.int32]:
    """(2, n_actions) where an agent keeps the value of each action, in mode −1 and in mode +1.

    The mode is that of the leaf being extended; only the values of locations depend on it. −1: never legal.
    """
    n, playable = game.rules.points, game.rules.playable_points
    d = int(playable.sum())
    of_point = np.where(playable, np.cumsum(playable) - 1, -1)
    slots = np.full((2, game.rules.n_actions), -1, dtype=np.int32)
    for block, (rows, start) in enumerate([((0, 1), 0), ((0, 1), n), ((0,), 2 * n), ((1,), 2 * n)]):
        for row in rows:
            slots[row, start : start + n] = np.where(playable, of_point + block * d, -1)
    slots[:, 3 * n :] = 4 * d + np.arange(game.rules.n_actions - 3 * n)
    return slots
