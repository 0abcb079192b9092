"""The learner of PPO: MaskablePPO with an update of its own; imported by ``search/ppo.py`` when a search begins."""

from __future__ import annotations

import random
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from stable_baselines3.common.logger import Logger

from origami_lab.search.ppo_environment import EpisodeVecEnv
from origami_lab.search.ppo_kernels import loss_gradient
from origami_lab.search.ppo_networks import Rows
from origami_lab.search.ppo_policy import SeenInputsPolicy
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


@contextmanager
def vanishing_as_zero() -> Iterator[None]:
    """Numbers below 10⁻³⁸ are zero to this thread.

    The moments of weights whose input is no longer seen halve until they are that small; a processor takes a hundred
    times as long for each, most of a long run's time. What they would change of a weight is far below its last bit.
    """
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)


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
) -> MaskedLearner:
    """A MaskablePPO that learns by playing the episodes; to be made and used inside :func:`isolated`.

    The parameters are those of :class:`~origami_lab.search.ProximalPolicyOptimization`.
    """
    learner = MaskedLearner(
        SeenInputsPolicy,
        EpisodeVecEnv(episodes),
        learning_rate=learning_rate,
        n_steps=batch // games,
        batch_size=minibatch,
        n_epochs=epochs,
        gamma=gamma,
        gae_lambda=gae_lambda,
        clip_range=clip,
        ent_coef=entropy,
        # eps is that of Stable-Baselines3
        policy_kwargs={"net_arch": layers, "optimizer_kwargs": {"eps": 1e-5, "fused": True}},
        device="cpu",
    )
    learner.set_logger(Logger(folder=None, output_formats=[]))  # its own leaves a folder among the temporary files
    return learner


@dataclass(frozen=True)
class Batch:
    """What was played since the last update: n interactions, game by game."""

    inputs: Rows
    legal: Rows
    played: NDArray[np.int64]
    log_chances: NDArray[np.float32]
    """(n,) logarithms of the probabilities with which they were played."""
    advantages: NDArray[np.float32]
    returns: NDArray[np.float32]

    @classmethod
    def of(cls, buffer: Any, policy: SeenInputsPolicy) -> Batch:
        """The content of a rollout buffer."""

        def flat(name: str) -> NDArray[Any]:
            return np.asarray(buffer.swap_and_flatten(getattr(buffer, name)))

        inputs, legal = policy.look(flat("observations")), Rows.of(flat("action_masks"))
        rest = (flat(name).ravel() for name in ("actions", "log_probs", "advantages", "returns"))
        return cls(inputs, legal, *rest)

    def __len__(self) -> int:
        return len(self.played)


class MaskedLearner(MaskablePPO):
    """MaskablePPO, whose update does what its own does but for what that notes and copies on the way."""

    policy: SeenInputsPolicy

    def train(self) -> None:
        """Update the policy by what has been played since the last update."""
        self._update_learning_rate(self.policy.optimizer)
        batch = Batch.of(self.rollout_buffer, self.policy)
        for _ in range(self.n_epochs):
            order = np.random.permutation(len(batch))  # noqa: NPY002
            for begin in range(0, len(batch), self.batch_size):
                self._improve(batch, order[begin : begin + self.batch_size])

    def _improve(self, batch: Batch, picked: NDArray[np.int64]) -> None:
        """One step of the optimiser, along the gradient of the loss over some interactions of a batch."""
        networks = self.policy.networks
        run = networks.run(batch.inputs, batch.legal, picked)
        by_logits, by_values = torch.empty_like(run.logits), torch.empty_like(run.values)
        loss_gradient(
            picked,
            batch.legal.starts,
            batch.legal.columns,
            batch.played,
            batch.log_chances,
            batch.advantages,
            batch.returns,
            run.logits.numpy(),
            run.values.numpy(),
            self.clip_range(self._current_progress_remaining),
            self.ent_coef,
            self.vf_coef,
            by_logits.numpy(),
            by_values.numpy(),
        )
        networks.differentiate(batch.inputs, batch.legal, picked, run, by_logits, by_values)
        gradient = networks.weights.grad
        if (norm := float(torch.linalg.vector_norm(gradient))) > self.max_grad_norm:
            gradient.mul_(self.max_grad_norm / norm)
        with vanishing_as_zero():
            self.policy.optimizer.step()
