"""PPO saved between two batches: all that its further course depends on, as arrays of numbers."""

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
        self.problem.save(lambda: arrays_of(self.model, self.episodes))

    def _on_step(self) -> bool:
        return True


def arrays_of(model: MaskedLearner, episodes: Episodes) -> dict[str, NDArray[Any]]:
    """The policy, its optimiser, the episodes that run, and the generators of random numbers."""
    policy = model.policy
    _, keys, place, has_gauss, gauss = np.random.get_state()  # noqa: NPY002
    numbers = [model.num_timesteps, place, has_gauss]
    arrays = {
        "seen": policy.networks.seen,
        "weights": policy.networks.weights.detach().numpy(),
        "numbers": np.array(numbers, dtype=np.int64),
        "gauss": np.array(gauss),
        "numpy": keys,
        "torch": torch.get_rng_state().numpy(),
        "episode_starts": np.asarray(model._last_episode_starts),
        "episodes": np.frombuffer(json.dumps(episodes.actions).encode(), dtype=np.uint8),
    }
    state = policy.optimizer.state.get(policy.networks.weights, {})  # none before the first update
    return arrays | {moment: numbers.numpy() for moment, numbers in state.items()}


def restore(model: MaskedLearner, episodes: Episodes, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Make a new model, which was made of the same seed and settings, and its episodes what they were when saved."""
    policy = model.policy
    policy.see(arrays["seen"])
    weights = policy.networks.weights
    with torch.no_grad():
        weights.copy_(torch.from_numpy(arrays["weights"]))
    if "step" in arrays:
        policy.optimizer.state[weights] = {moment: torch.from_numpy(arrays[moment]) for moment in _MOMENTS}
    episodes.go_back(json.loads(arrays["episodes"].tobytes()))
    model._last_obs = episodes.observations.copy()
    model._last_episode_starts = arrays["episode_starts"]
    timesteps, place, has_gauss = arrays["numbers"].tolist()
    model.num_timesteps = timesteps
    np.random.set_state(("MT19937", arrays["numpy"], place, has_gauss, float(arrays["gauss"])))  # noqa: NPY002
    torch.set_rng_state(torch.from_numpy(arrays["torch"]))
