"""The episodes of PPO as an environment of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from origami_lab.game.observation import possible_actions
from origami_lab.search.rl_episodes import Episodes


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
