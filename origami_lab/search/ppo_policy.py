"""The policy of PPO: that of Stable-Baselines3, with the same beginnings and the same mathematics, in fewer steps.

An observation is nearly all zeros, and most of its numbers stay 0 for a whole search: on the face's board it has 4,880,
of which 28 are other than 0 at a time and some 1,600 ever. A weight whose input has always been 0 has had no gradient,
and Adam leaves it as it began. So the first layers hold the weights of those inputs only that have been seen to be
other than 0 (:class:`SeenInputs`); that is exact. They are one for policy and value function, as both see the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from torch import Tensor, nn

from origami_lab.search.ppo_kernels import (
    chances_of,
    legal_logits,
    legal_logits_gradient,
    linear,
    linear_gradient,
    sparse_rows,
)


@dataclass(frozen=True)
class Rows:
    """Observations, whose columns are inputs by their numbers among those seen, or masks, whose columns are actions."""

    starts: NDArray[np.int64]
    columns: NDArray[np.int64]
    numbers: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.starts) - 1

    @classmethod
    def of(cls, dense: NDArray[Any]) -> Rows:
        """Those of a (n, …) array."""
        return cls(*sparse_rows(dense.reshape(len(dense), -1)))

    def count(self, picked: NDArray[np.int64]) -> int:
        """How many numbers the picked rows have."""
        return int((self.starts[picked + 1] - self.starts[picked]).sum())


class SparseLinear(torch.autograd.Function):
    """A linear layer, bias and (inputs, outputs) weights, on the picked rows of sparse inputs."""

    @staticmethod
    def forward(context: Any, weight: Tensor, bias: Tensor, inputs: Rows, picked: NDArray[np.int64]) -> Tensor:
        context.inputs, context.picked, context.shape = inputs, picked, weight.shape
        out = bias.detach().repeat(len(picked), 1)
        numbers = weight.detach().numpy()
        linear(picked, inputs.starts, inputs.columns, inputs.numbers, numbers, out.numpy())
        return out

    @staticmethod
    def backward(context: Any, gradient: Tensor) -> tuple[Tensor, Tensor, None, None]:
        inputs, by_weight = context.inputs, torch.zeros(context.shape)
        numbers = gradient.contiguous().numpy()
        linear_gradient(context.picked, inputs.starts, inputs.columns, inputs.numbers, numbers, by_weight.numpy())
        return by_weight, gradient.sum(0), None, None


class LegalLogits(torch.autograd.Function):
    """A linear layer, bias and (actions, inputs) weights, of which only the outputs of legal actions are computed."""

    @staticmethod
    def forward(
        context: Any, hidden: Tensor, weight: Tensor, bias: Tensor, legal: Rows, picked: NDArray[np.int64]
    ) -> Tensor:
        context.legal, context.picked = legal, picked
        context.save_for_backward(hidden, weight)
        out = torch.empty(legal.count(picked))
        inputs, weights, biases = (each.detach().numpy() for each in (hidden, weight, bias))
        legal_logits(picked, legal.starts, legal.columns, inputs, weights, biases, out.numpy())
        return out

    @staticmethod
    def backward(context: Any, gradient: Tensor) -> tuple[Tensor, Tensor, Tensor, None, None]:
        hidden, weight = context.saved_tensors
        by_hidden, by_weight, by_bias = torch.zeros_like(hidden), torch.zeros_like(weight), torch.zeros(len(weight))
        given = (each.detach().numpy() for each in (hidden, weight, gradient.contiguous()))
        found = (each.numpy() for each in (by_hidden, by_weight, by_bias))
        legal_logits_gradient(context.picked, context.legal.starts, context.legal.columns, *given, *found)
        return by_hidden, by_weight, by_bias, None, None


class SeenInputs(nn.Module):
    """Linear layers side by side on the same inputs, without those inputs that have never been other than 0.

    Parameters
    ----------
    layers
        Those that it takes the place of; it begins with their weights.
    """

    def __init__(self, layers: Sequence[nn.Linear]) -> None:
        super().__init__()
        with torch.no_grad():
            self.beginning = torch.cat([layer.weight for layer in layers]).T.contiguous()
            """(inputs, outputs) weights of all inputs before the first update."""
            self.bias = nn.Parameter(torch.cat([layer.bias for layer in layers]))
            self.weight = nn.Parameter(self.beginning[:0].clone())
            """(seen inputs, outputs)"""
        self.seen = np.zeros(0, dtype=np.int64)
        """(seen inputs,) which they are, in the order of their first appearance."""
        self.places = np.full(len(self.beginning), -1)
        """(inputs,) the place of each among those seen, −1 of the others."""

    def see(self, inputs: NDArray[np.int64]) -> None:
        """Add inputs to those seen; they begin with the weights they always had."""
        self.places[inputs] = len(self.seen) + np.arange(len(inputs))
        self.seen = np.concatenate([self.seen, inputs])
        with torch.no_grad():
            self.weight = nn.Parameter(torch.cat([self.weight, self.beginning[inputs]]))

    def forward(self, inputs: Rows, picked: NDArray[np.int64]) -> Tensor:
        return SparseLinear.apply(self.weight, self.bias, inputs, picked)


class SeenInputsPolicy(MaskableActorCriticPolicy):
    """Masked policy and value function, two multilayer perceptrons, on the inputs seen so far."""

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)  # draws the first weights, as it always does
        mlp = self.mlp_extractor
        self.first = SeenInputs([mlp.policy_net[0], mlp.value_net[0]])
        self.policy_layers, self.value_layers = mlp.policy_net[1:], mlp.value_net[1:]
        del self.mlp_extractor
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)

    def look(self, observations: NDArray[Any]) -> Rows:
        """What the networks are given of (n, …) observations; inputs that are new are added first."""
        rows = Rows.of(observations)
        places = self.first.places[rows.columns]
        if len(places) and places.min() < 0:
            self.see(np.unique(rows.columns[places < 0]))
            places = self.first.places[rows.columns]
        return replace(rows, columns=places)

    def see(self, inputs: NDArray[np.int64]) -> None:
        """Add inputs to those seen, for the optimiser, too: their gradients were 0 so far."""
        old = self.first.weight
        self.first.see(inputs)
        [group] = self.optimizer.param_groups
        group["params"] = [self.first.weight if each is old else each for each in group["params"]]
        if (state := self.optimizer.state.pop(old, None)) is not None:
            rest = torch.zeros(len(inputs), old.shape[1])
            moments = {name: torch.cat([state[name], rest]) for name in ("exp_avg", "exp_avg_sq")}
            self.optimizer.state[self.first.weight] = {**state, **moments}

    def networks(self, inputs: Rows, legal: Rows, picked: NDArray[np.int64]) -> tuple[Tensor, Tensor]:
        """The logits of the legal actions of the picked states, one after the other, and (picked,) their values."""
        policy, value = self.first(inputs, picked).chunk(2, dim=1)
        output = self.action_net
        logits = LegalLogits.apply(self.policy_layers(policy), output.weight, output.bias, legal, picked)
        return logits, self.value_net(self.value_layers(value)).flatten()

    def forward(
        self, obs: Tensor, deterministic: bool = False, action_masks: NDArray[np.bool_] | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Actions drawn for observations, the values of the states, the logarithms of the actions' probabilities."""
        masks = np.asarray(action_masks)
        legal = Rows.of(masks)
        logits, values = self.networks(self.look(obs.numpy()), legal, np.arange(len(obs)))
        chances = torch.zeros(masks.shape)
        chances_of(legal.starts, legal.columns, logits.numpy(), chances.numpy())
        actions = torch.multinomial(chances, 1)
        return actions.flatten(), values, chances.gather(1, actions).flatten().log()

    def predict_values(self, obs: Tensor) -> Tensor:
        """(n,) values of the states in observations."""
        value = self.first(self.look(obs.numpy()), np.arange(len(obs))).chunk(2, dim=1)[1]
        return self.value_net(self.value_layers(value)).flatten()
