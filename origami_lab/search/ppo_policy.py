"""The policy of PPO as Stable-Baselines3 wants it: with the same beginnings as its own and the same mathematics."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from torch import Tensor, nn

from origami_lab.search.ppo_kernels import chances_of
from origami_lab.search.ppo_networks import Rows, SeenInputsNetworks


class SeenInputsPolicy(MaskableActorCriticPolicy):
    """Masked policy and value function, two multilayer perceptrons, on the inputs seen so far."""

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)  # draws the first weights, as it always does
        sides = ((self.mlp_extractor.policy_net, self.action_net), (self.mlp_extractor.value_net, self.value_net))
        self.networks = SeenInputsNetworks(
            *([*(layer for layer in hidden if isinstance(layer, nn.Linear)), last] for hidden, last in sides)
        )
        del self.mlp_extractor, self.action_net, self.value_net
        self.optimizer = self.optimizer_class([self.networks.weights], lr=lr_schedule(1), **self.optimizer_kwargs)

    def look(self, observations: NDArray[Any]) -> Rows:
        """What the networks are given of (n, …) observations; inputs that are new are added first."""
        rows = Rows.of(observations)
        if len(inputs := self.networks.unseen(rows.columns)):
            self.see(inputs)
        return replace(rows, columns=self.networks.places(rows.columns))

    def see(self, inputs: NDArray[np.int64]) -> None:
        """Add inputs to those seen, for the optimiser, too: their gradients were 0 so far."""
        old = self.networks.weights
        self.networks.see(inputs)
        new = self.networks.weights
        if new is old:
            return
        self.optimizer.param_groups[0]["params"] = [new]
        if (state := self.optimizer.state.pop(old, None)) is not None:
            rest = torch.zeros(len(new) - len(old))
            moments = {name: torch.cat([state[name], rest]) for name in ("exp_avg", "exp_avg_sq")}
            self.optimizer.state[new] = {**state, **moments}

    def forward(
        self, obs: Tensor, deterministic: bool = False, action_masks: NDArray[np.bool_] | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Actions drawn for observations, the values of the states, the logarithms of the actions' probabilities."""
        masks = np.asarray(action_masks)
        inputs, legal = self.look(obs.numpy()), Rows.of(masks)
        run = self.networks.run(inputs, legal, np.arange(len(obs)))
        # among all actions, for the sake of the random numbers: so Stable-Baselines3 draws
        chances = torch.zeros(masks.shape)
        chances_of(legal.starts, legal.columns, run.logits.numpy(), chances.numpy())
        actions = torch.multinomial(chances, 1)
        return actions.flatten(), run.values, chances.gather(1, actions).flatten().log()

    def predict_values(self, obs: Tensor) -> Tensor:
        """(n,) values of the states in observations."""
        nothing = Rows.of(np.zeros((len(obs), 1), dtype=np.bool_))
        return self.networks.run(self.look(obs.numpy()), nothing, np.arange(len(obs))).values
