"""PPO as arrays of numbers: what its policy has learned, and all that its further course depends on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback

from origami_lab.search.ppo_learner import MaskedLearner
from origami_lab.search.problem import Problem
from origami_lab.search.rl_episodes import Episodes

_MOMENTS = ("step", "exp_avg", "exp_avg_sq")


class Saving(BaseCallback):
    """Saves the search before a batch is played, when it is time to."""

    def __init__(self, problem: Problem, episodes: Episodes) -> None:
        super().__init__()
        self.problem, self.episodes = problem, episodes

    def _on_rollout_start(self) -> None:
        self.problem.checkpoint(lambda: arrays_of(self.model, self.episodes))

    def _on_step(self) -> bool:
        return True


def arrays_of(model: MaskedLearner, episodes: Episodes) -> dict[str, NDArray[Any]]:
    """The policy, its optimiser, the episodes that run, and the generators of random numbers."""
    _, keys, place, has_gauss, gauss = np.random.get_state()  # noqa: NPY002
    numbers = [model.num_timesteps, place, has_gauss]
    arrays = {
        "numbers": np.array(numbers, dtype=np.int64),
        "gauss": np.array(gauss),
        "numpy": keys,
        "torch": torch.get_rng_state().numpy(),
        "episode_starts": np.asarray(model._last_episode_starts),
        "episodes": np.frombuffer(json.dumps(episodes.actions).encode(), dtype=np.uint8),
    }
    return policy_arrays(model) | arrays


def policy_arrays(model: MaskedLearner) -> dict[str, NDArray[Any]]:
    """What was learned: the policy and its optimiser."""
    policy = model.policy
    state = policy.optimizer.state.get(policy.networks.weights, {})  # none before the first update
    learned = {"seen": policy.networks.seen.copy(), "weights": policy.networks.weights.detach().numpy().copy()}
    return learned | {moment: numbers.numpy().copy() for moment, numbers in state.items()}


def restore(model: MaskedLearner, episodes: Episodes, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Make a new model, which was made of the same seed and settings, and its episodes what they were when saved."""
    restore_policy(model, arrays)
    episodes.go_back(json.loads(arrays["episodes"].tobytes()))
    model._last_obs = episodes.observations.copy()
    model._last_episode_starts = arrays["episode_starts"]
    timesteps, place, has_gauss = arrays["numbers"].tolist()
    model.num_timesteps = timesteps
    np.random.set_state(("MT19937", arrays["numpy"], place, has_gauss, float(arrays["gauss"])))  # noqa: NPY002
    torch.set_rng_state(torch.from_numpy(arrays["torch"]))


def restore_policy(model: MaskedLearner, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Give a new model of the same settings what another one has learned."""
    policy = model.policy
    policy.see(arrays["seen"])
    weights = policy.networks.weights
    with torch.no_grad():
        weights.copy_(torch.from_numpy(arrays["weights"]))
    if "step" in arrays:
        policy.optimizer.state[weights] = {moment: torch.from_numpy(arrays[moment]) for moment in _MOMENTS}
