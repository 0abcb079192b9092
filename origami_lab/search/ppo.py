"""PPO (paper, appendix A): a policy network learns from the rewards of its own play.

The learner is sb3-contrib's MaskablePPO; it is imported when a search begins, and nothing else imports it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from typing import Annotated

import numpy as np

from origami_lab.checks import Choice, ListOf, Number, Whole, checked_arguments
from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.observation import View, view_of
from origami_lab.search.problem import Problem, SearchEnded, SearcherState
from origami_lab.search.rl_episodes import Episodes

NEEDED = ("gymnasium", "sb3_contrib", "stable_baselines3", "torch")
MOST_BYTES = 2**31
"""Most bytes that the learner may take for the first layers and one batch of observations."""


_WIDTHS = "must be a list of widths from 1 to 100000, such as [256,256]"


class ProximalPolicyOptimization:
    """Proximal policy optimisation with masked actions, a multilayer perceptron, and shaped rewards.

    Parameters
    ----------
    observation
        ``compact`` or ``tensor`` (:mod:`origami_lab.game.observation`).
    vertices
        Cap on the vertex axis of the tensor, at most the points of the board; None for all of them, the paper's.
    layers
        Widths of the hidden layers, of the policy and of the value function each.
    batch
        Interactions between two updates.
    games
        Games that play them side by side; a divisor of ``batch``.
    epochs, minibatch
        How often an update goes over its batch, and in pieces of what size.
    entropy
        Weight of the policy's entropy in the loss.
    learning_rate, clip, gamma, gae_lambda
        Adam's step, PPO's clipping range, the discount, λ of the advantage estimator.

    Raises
    ------
    InputError
        If the extra ``ppo`` is not installed, or for a wrong number.
    """

    @checked_arguments("search")
    def __init__(
        self,
        observation: Annotated[str, Choice(("compact", "tensor"))] = "compact",
        vertices: Annotated[int | None, Whole(1, 100_000)] = 64,
        layers: Annotated[Sequence[int], ListOf(Whole(1, 100_000), _WIDTHS)] = (
            256,
            256,
        ),
        batch: Annotated[int, Whole(2, 10**7)] = 2050,
        games: Annotated[int, Whole(1, 10**7, "must be a whole number from 1 to search.batch")] = 10,
        epochs: Annotated[int, Whole(1, 10_000)] = 10,
        minibatch: Annotated[int, Whole(2, 10**7, "must be a whole number from 2 to search.batch")] = 64,
        entropy: Annotated[float, Number(0, 1e6)] = 0.01,
        learning_rate: Annotated[float, Number(1e-12, 1e3)] = 3e-4,
        clip: Annotated[float, Number(1e-6, 1e3)] = 0.2,
        gamma: Annotated[float, Number(0, 1)] = 0.99,
        gae_lambda: Annotated[float, Number(0, 1)] = 0.95,
    ) -> None:
        missing = [name for name in NEEDED if find_spec(name) is None]
        if missing:
            raise InputError("search", "ppo", f"needs {', '.join(missing)}: pip install 'origami-lab[ppo]'")
        if batch % games:
            raise InputError("search.games", games, f"must divide search.batch={batch}")
        if minibatch > batch:
            raise InputError("search.minibatch", minibatch, f"must be a whole number from 2 to search.batch={batch}")
        self.observation, self.vertices, self.layers = observation, vertices, list(layers)
        self.batch, self.games, self.epochs, self.minibatch = batch, games, epochs, minibatch
        self.entropy, self.learning_rate, self.clip = entropy, learning_rate, clip
        self.gamma, self.gae_lambda = gamma, gae_lambda
        self._learned: SearcherState = {}
        self._loaded: SearcherState = {}

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        from origami_lab.search.ppo_learner import isolated, learner
        from origami_lab.search.ppo_state import Saving, policy_arrays, restore, restore_policy

        self.check_game(problem.game)
        episodes = Episodes(problem, self.games, self._view(problem.game))
        with isolated(int(rng.integers(2**31))), suppress(SearchEnded):
            model = learner(
                episodes,
                layers=self.layers,
                batch=self.batch,
                games=self.games,
                epochs=self.epochs,
                minibatch=self.minibatch,
                entropy=self.entropy,
                learning_rate=self.learning_rate,
                clip=self.clip,
                gamma=self.gamma,
                gae_lambda=self.gae_lambda,
            )
            loaded, self._loaded = self._loaded, {}
            if loaded:
                restore_policy(model, loaded)
            if (arrays := problem.last_checkpoint()) is not None:
                restore(model, episodes, arrays)
            try:
                model.learn(problem.budget, callback=Saving(problem, episodes), reset_num_timesteps=arrays is None)
            finally:
                self._learned = policy_arrays(model)

    def save(self) -> SearcherState:
        """What the policy has learned."""
        return self._learned

    def load(self, state: SearcherState) -> None:
        """Go on learning from there."""
        self._loaded = state

    def check_game(self, game: Game) -> None:
        """Refuse observations so large that the first layers and a batch need too much memory; raises InputError."""
        view = self._view(game)
        numbers = math.prod(view.shape)
        # weights of policy and value function, their gradients and Adam's two moments, four bytes each
        needed = numbers * (2 * 4 * 4 * self.layers[0] + self.batch * view.dtype.itemsize)
        if needed > MOST_BYTES:
            expected = (
                f"{numbers:,} numbers an observation take {needed / 2**30:.1f} GB, at most {MOST_BYTES / 2**30:.0f} is "
                "allowed: use search.observation=compact, search.vertices=64, or a smaller board"
            )
            raise InputError("search.observation", self.observation, expected)

    def _view(self, game: Game) -> View:
        return view_of(game, self.observation, None if self.vertices is None else min(self.vertices, game.rules.points))
