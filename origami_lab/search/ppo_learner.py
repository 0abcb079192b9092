"""The learner of PPO, and the episodes as its environment; imported by ``search/ppo.py`` when a search begins."""

from __future__ import annotations

import random
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from stable_baselines3.common.vec_env import VecEnv

from origami_lab.game.observation import possible_actions
from origami_lab.search.rl_episodes import Episodes


@contextmanager
def isolated(seed: int) -> Iterator[None]:
    """Global generators seeded, one thread; all as it was afterwards.

    Stable-Baselines3 draws from the global generators of NumPy and torch. More threads would add up numbers in another
    order, and take the cores of the other trials.
    """
    before = random.getstate(), np.random.get_state(), torch.get_rng_state(), torch.get_num_threads()  # noqa: NPY002
    try:
        random.seed(seed)
        np.random.seed(seed)  # noqa: NPY002
        torch.manual_seed(seed)
        torch.set_num_threads(1)
        with warnings.catch_warnings():
            # the paper's batch is no multiple of its minibatch
            warnings.filterwarnings("ignore", message="You have specified a mini-batch size")
            yield
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002
        torch.set_rng_state(before[2])
        torch.set_num_threads(before[3])


def learner(
    episodes: Episodes,
    *,
    layers: list[int],
    batch: int,
    games: int,
    epochs: int,
    minibatch: int,
    entropy: float,
    learning_rate: float,
    clip: float,
    gamma: float,
    gae_lambda: float,
) -> Any:
    """A MaskablePPO that learns by playing the episodes; to be made and used inside :func:`isolated`.

    The parameters are those of :class:`~origami_lab.search.ProximalPolicyOptimization`.
    """
    return MaskablePPO(
        "MlpPolicy",
        EpisodeVecEnv(episodes),
        learning_rate=learning_rate,
        n_steps=batch // games,
        batch_size=minibatch,
        n_epochs=epochs,
        gamma=gamma,
        gae_lambda=gae_lambda,
        clip_range=clip,
        ent_coef=entropy,
        policy_kwargs={"net_arch": layers},
        device="cpu",
    )


class EpisodeVecEnv(VecEnv):
    """Episodes as Stable-Baselines3 wants them: an episode that has ended is begun anew in the same step.

    Of the game's actions only those are offered that can ever be legal: under ``xyd`` a sixth of them.
    """

    render_mode = None

    def __init__(self, episodes: Episodes) -> None:
        view, self.episodes = episodes.view, episodes
        self.actions = possible_actions(episodes.problem.game)
        self.chosen: NDArray[np.int64] = self.actions[:0]
        super().__init__(
            len(episodes.positions),
            spaces.Box(-1, 1, view.shape, view.dtype.type),
            spaces.Discrete(len(self.actions)),
        )

    def reset(self) -> NDArray[Any]:
        for i in range(self.num_envs):
            self.episodes.reset(i)
        return self.episodes.observations.copy()

    def step_async(self, actions: NDArray[np.int64]) -> None:
        self.chosen = self.actions[actions]

    def step_wait(self) -> tuple[NDArray[Any], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Play one action in each episode; raises SearchEnded once the budget is spent."""
        rewards, ended = np.zeros(self.num_envs, dtype=np.float32), np.zeros(self.num_envs, dtype=np.bool_)
        for i, action in enumerate(self.chosen):
            rewards[i], ended[i] = self.episodes.step(i, int(action))
            if ended[i]:
                self.episodes.reset(i)
        return self.episodes.observations.copy(), rewards, ended, [{} for _ in range(self.num_envs)]

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """``action_masks`` of each episode: the one method that the learner calls."""
        if method_name != "action_masks":
            raise AttributeError(method_name)
        return list(self.episodes.masks[:, self.actions])

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        if attr_name == "action_masks":  # asked for to see whether there are masks
            return [self.env_method] * self.num_envs
        return [getattr(self, attr_name)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise AttributeError(attr_name)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * self.num_envs

    def close(self) -> None:
        """There is nothing to close."""
