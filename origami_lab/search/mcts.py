"""MCTS (paper, appendix A): simulations from the position that is really played decide its next action.

Every action that is played is an interaction: on the way down the tree, in the rollouts, and for real.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from origami_lab.checks import Flag, Number, Whole, checked_arguments
from origami_lab.game.kernels.play import step
from origami_lab.search.mcts_kernel import (
    CUT,
    ENDED,
    HIGH,
    KNOWN,
    LOW,
    NODE,
    RESCALED,
    Nodes,
    back_up,
    plant,
    see,
    simulate,
    simulate_many,
)
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws

_NODES = 1 << 12
"""Nodes that a tree has room for at first."""
_PACE = 4096
"""Interactions that are played at most between two looks at the clock, and the rest of a simulation."""
_MOST_NODES = 1 << 24
"""A tree that has grown to this takes no more simulations (512 MB); play goes on with what it knows."""


class MonteCarloTreeSearch:
    """Monte Carlo tree search with PUCT and uniform rollouts.

    An episode begins with an empty tree, which is kept from one real action to the next.

    Parameters
    ----------
    simulations
        Full episodes simulated for each real action.
    exploration
        c of PUCT.
    epsilon, alpha
        Priors are (1 − ε)·uniform + ε·Dir(α).
    unvisited
        Normalised return that is assumed of a child without visits, from −1 to 1; None for its parent's mean.
    greedy
        The real action is the most visited child. If false it is drawn with probabilities ∝ visits^temperature.
    temperature
        See ``greedy``.
    """

    @checked_arguments("search")
    def __init__(
        self,
        simulations: Annotated[int, Whole(2, 100_000)] = 100,
        exploration: Annotated[float, Number(0, 1e6)] = 1.0,
        epsilon: Annotated[float, Number(0, 1)] = 0.25,
        alpha: Annotated[float, Number(1e-3, 1e6)] = 0.03,
        unvisited: Annotated[float | None, Number(-1, 1)] = None,
        greedy: Annotated[bool, Flag()] = True,
        temperature: Annotated[float, Number(0, 1e3)] = 1.5,
    ) -> None:
        self.simulations, self.exploration = simulations, exploration
        self.epsilon, self.alpha = epsilon, alpha
        self.unvisited, self.greedy, self.temperature = unvisited, greedy, temperature

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        tree = Tree(problem, rng, self)
        while not problem.done:
            tree.play_episode()


class ReturnRange:
    """The returns that stand for −1 and 1.

    At first those of shape approximation: the penalty r_min and 0. Once an episode scores outside of that, the lowest
    and the highest score seen so far. A penalised episode counts as the lowest.
    """

    def __init__(self, penalty: float) -> None:
        self.scale = np.array([penalty, 0.0, math.inf, -math.inf, 0.0])
        """The same for kernels, see :data:`~.mcts_kernel.Scale`."""

    @property
    def low(self) -> float:
        return float(self.scale[LOW])

    @property
    def high(self) -> float:
        return float(self.scale[HIGH])

    def see(self, value: float) -> bool:
        """Take note of the return of an episode that was not penalised.

        Returns whether it was the first one outside: what was clipped before then lies off the new scale.
        """
        return bool(see(self.scale, value))

    def clip(self, value: float) -> float:
        """The return, not below the lowest: the penalty, and −inf for a worthless design, are the lowest."""
        return min(max(value, self.low), self.high)


class Tree:
    """The tree of one episode after another, and the position at its root."""

    def __init__(self, problem: Problem, rng: np.random.Generator, settings: MonteCarloTreeSearch) -> None:
        game = problem.game
        self.problem, self.settings, self.rng = problem, settings, rng
        self.draws, self.noise = Draws(rng), Draws(rng, self._log_gammas)
        self.returns = ReturnRange(game.penalty)
        self.positions = problem.new_positions(2)  # the real one, and the one that simulations play in
        self.longest = len(self.positions.states["actions"][0])
        self.path = np.zeros(self.longest + 1, dtype=np.int32)
        self.legal = np.empty(game.rules.max_legal, dtype=np.int32)
        self.nodes: Nodes = np.zeros(max(_NODES, 2 * game.rules.max_legal), dtype=NODE)
        self.size, self.root = 1, 0
        self.score = problem.compiled_score
        self.unvisited = math.nan if settings.unvisited is None else settings.unvisited
        self.rescaled = False
        """Whether the returns in the tree are no longer on one scale, so that a new one has to be planted."""

    def play_episode(self) -> None:
        """Play one episode for real, from the empty board."""
        problem, evaluator = self.problem, self.problem.evaluator
        problem.clear(self.positions, 0)
        plant(self.nodes)
        self.size, self.root = 1, 0
        while True:
            left = self.settings.simulations
            while left > 0:
                simulated = self.simulate() if self.score is None else self.simulate_compiled(left)
                if simulated < 0:
                    return
                if self.rescaled:
                    self.rescaled = False
                    return
                if self.size >= _MOST_NODES:
                    break
                left -= simulated
            child = self.choose()
            if child < 0 or problem.done:
                return
            problem.spend(1)
            step(self.positions.states, 0, problem.game.rules.record, int(self.nodes["action"][child]), self.legal)
            self.root = child
            if int(self.nodes["count"][child]) == 0:
                return  # the episode has ended, and was scored when it first did
            # what does not change in the simulations from here on is measured once
            evaluator.bound(self.positions.states, self.positions.memos, 0)

    def reserve(self) -> None:
        """See to it that there are nodes and random numbers for one more simulation."""
        if self.size + len(self.legal) > len(self.nodes):
            self.nodes = np.concatenate([self.nodes, np.zeros_like(self.nodes)])
        self.draws.reserve(self.longest)
        if self.settings.epsilon > 0:
            self.noise.reserve(len(self.legal))

    def simulate_compiled(self, count: int) -> int:
        """Up to so many simulations where the score is compiled; how many, −1 if the search ended in one of them."""
        problem, settings, positions = self.problem, self.settings, self.positions
        if problem.done:
            return -1
        self.reserve()
        why, depth, self.size, self.noise.used, self.draws.used, played, simulated, ended = simulate_many(
            positions.states,
            problem.game.rules.record,
            positions.memos,
            self.score,
            self.nodes,
            self.size,
            self.root,
            settings.exploration,
            self.returns.scale,
            self.unvisited,
            settings.epsilon,
            self.noise.block,
            self.noise.used,
            self.draws.block,
            self.draws.used,
            self.path,
            self.legal,
            problem.game.penalty,
            problem.best_value,
            count,
            problem.remaining,
            _PACE,
            _MOST_NODES,
        )
        problem.spend(played)
        problem.episodes += ended
        if why == CUT:
            return -1
        if why == ENDED:
            back_up(self.nodes, self.path, depth, self.returns.clip(self._finish()))
            simulated += 1
        self.rescaled = self.rescaled or why == RESCALED
        return int(simulated)

    def _finish(self) -> float:
        """The return of the episode that has ended in a simulation."""
        problem, positions = self.problem, self.positions
        positions.memos[1] = positions.memos[0]
        value = problem.finish(positions, 1, above=-math.inf)
        if not problem.game.is_penalised(positions.states, 1):
            self.rescaled = self.returns.see(value)
        return value

    def simulate(self) -> int:
        """One simulation: 1, or −1 if the search ended it before it was finished."""
        problem, settings, positions = self.problem, self.settings, self.positions
        if problem.done:
            return -1
        self.reserve()
        before = self.size
        why, depth, self.size, self.draws.used, played = simulate(
            *(positions.states, problem.game.rules.record, self.nodes, before, self.root),
            *(settings.exploration, self.returns.low, self.returns.high, self.unvisited, settings.epsilon),
            *(self.noise.block, self.noise.used, self.draws.block, self.draws.used),
            *(self.path, self.legal, problem.remaining),
        )
        self.noise.use(self.size - before)
        problem.spend(played)
        if why == CUT:
            return -1
        if why == KNOWN:
            node = self.nodes[self.path[depth]]
            problem.episodes += 1
            value = float(node["total"]) / int(node["visits"])
        else:
            value = self._finish()
        back_up(self.nodes, self.path, depth, self.returns.clip(value))
        return 1

    def choose(self) -> int:
        """The child of the root to be played for real; −1 if there is none, or none was visited."""
        first, count = int(self.nodes["first"][self.root]), int(self.nodes["count"][self.root])
        if count <= 0:
            return -1
        visits = self.nodes["visits"][first : first + count]
        most = int(visits.max())
        if most == 0:
            return -1
        if self.settings.greedy:
            return first + int(np.argmax(visits))
        weights = np.where(visits > 0, (visits / most) ** self.settings.temperature, 0.0)
        self.draws.reserve(1)
        draw = self.draws.block[self.draws.used]
        self.draws.use(1)
        sums = np.cumsum(weights)
        return first + int(np.searchsorted(sums, draw * sums[-1], side="right"))

    def _log_gammas(self, count: int) -> NDArray[np.float64]:
        """Logarithms of gamma variates of shape α: those themselves underflow where α is small."""
        alpha = self.settings.alpha
        uniform = 1.0 - self.rng.random(count)
        return np.asarray(np.log(self.rng.standard_gamma(alpha + 1.0, count)) + np.log(uniform) / alpha)
