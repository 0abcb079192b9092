"""The networks of PPO: two multilayer perceptrons on sparse observations, and the gradient by all their weights.

An observation is nearly all zeros, and most of its numbers stay 0 for a whole search: on the face's board it has 4,880,
of which 28 are other than 0 at a time and some 1,600 ever. A weight whose input has always been 0 has had no gradient,
and Adam leaves it as it began. So the first layer holds the weights of those inputs only that have been seen to be
other than 0; that is exact. It is one for both networks, as both see the same. Of the last layer of the policy only the
logits of legal actions are computed. All weights are one vector and so is their gradient: what is done to all of them
at once, and that is most of the work of an update, is done in one step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from origami_lab.search.ppo_kernels import legal_logits, legal_logits_gradient, linear, linear_gradient, sparse_rows

ROOM = 64
"""The first layer grows by so many inputs at once: to copy all weights for each would take longer than to learn."""

Picked = NDArray[np.int64]
Layer = tuple[Tensor, Tensor]


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

    def count(self, picked: Picked) -> int:
        """How many numbers the picked rows have."""
        return int((self.starts[picked + 1] - self.starts[picked]).sum())


@dataclass(frozen=True)
class WeightViews:
    """A vector of all weights, or their gradient, as the layers that they belong to: views of it."""

    bias: Tensor
    """(2 · width,) of the first layer."""
    policy: list[Layer]
    """(outputs, inputs) weights and (outputs,) bias of each further layer of the policy; the last gives its logits."""
    value: list[Layer]
    weight: Tensor
    """(seen inputs, 2 · width) of the first layer, and zeros for some that may be seen later."""


@dataclass(frozen=True)
class Activations:
    """What each layer but the last gave on some states, and what the networks say of these."""

    policy: list[Tensor]
    value: list[Tensor]
    logits: Tensor
    """Of the legal actions of the states, one after the other."""
    values: Tensor
    """(states,)"""


class SeenInputsNetworks:
    """Policy and value function on the inputs that have been seen to be other than 0.

    Parameters
    ----------
    policy, value
        Their layers, from the first to the last, between which are hyperbolic tangents; it begins with their weights.
    """

    def __init__(self, policy: Sequence[nn.Linear], value: Sequence[nn.Linear]) -> None:
        firsts = (policy[0], value[0])
        rest = [torch.cat([layer.bias for layer in firsts])]
        rest += [part for layers in (policy, value) for layer in layers[1:] for part in (layer.weight, layer.bias)]
        self.beginning = torch.cat([layer.weight for layer in firsts]).detach().T.contiguous()
        """(inputs, 2 · width) weights of the first layer before the first update."""
        self.weights = nn.Parameter(torch.cat([part.detach().flatten() for part in rest]))
        """Those of all layers; those of the first one last. Its ``grad`` is the gradient."""
        self.seen = np.zeros(0, dtype=np.int64)
        """(seen inputs,) which they are, in the order of their first appearance."""
        self._places = np.full(len(self.beginning), -1)
        self._shapes, self._outputs = [part.shape for part in rest], self.beginning.shape[1]
        self._point()

    def see(self, inputs: NDArray[np.int64]) -> None:
        """Add inputs to those seen; they begin with the weights they always had."""
        places = len(self.seen) + np.arange(len(inputs))
        self._places[inputs] = places
        self.seen = np.concatenate([self.seen, inputs])
        lacking = -(-len(self.seen) // ROOM) * ROOM - len(self.parts.weight)
        if lacking:
            self.weights = nn.Parameter(torch.cat([self.weights.detach(), torch.zeros(lacking * self._outputs)]))
            self._point()
        self.parts.weight[places] = self.beginning[inputs]

    def _point(self) -> None:
        self.weights.grad = torch.zeros_like(self.weights)
        self.parts, self.gradient = self._parts(self.weights.detach()), self._parts(self.weights.grad)

    def _parts(self, vector: Tensor) -> WeightViews:
        sizes = [shape.numel() for shape in self._shapes]
        bias, *rest, first = vector.split([*sizes, len(vector) - sum(sizes)])
        views = [part.view(shape) for part, shape in zip(rest, self._shapes[1:], strict=True)]
        layers = list(zip(views[::2], views[1::2], strict=True))
        half = len(layers) // 2
        return WeightViews(bias, layers[:half], layers[half:], first.view(-1, self._outputs))

    def unseen(self, columns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Those of the inputs that have not been seen yet."""
        return np.unique(columns[self._places[columns] < 0])

    def places(self, columns: NDArray[np.int64]) -> NDArray[np.int64]:
        """The numbers of inputs among those seen."""
        return self._places[columns]

    def run(self, inputs: Rows, legal: Rows, picked: Picked) -> Activations:
        """The networks on the picked states."""
        parts = self.parts
        first = parts.bias.repeat(len(picked), 1)
        linear(picked, inputs.starts, inputs.columns, inputs.numbers, parts.weight.numpy(), first.numpy())
        policy, value = ([half.contiguous()] for half in first.tanh_().chunk(2, dim=1))
        for hidden, layers in ((policy, parts.policy), (value, parts.value)):
            for weight, bias in layers[:-1]:
                hidden.append(torch.addmm(bias, hidden[-1], weight.T).tanh_())
        weight, bias = parts.policy[-1]
        logits = torch.empty(legal.count(picked))
        legal_logits(
            picked, legal.starts, legal.columns, policy[-1].numpy(), weight.numpy(), bias.numpy(), logits.numpy()
        )
        weight, bias = parts.value[-1]
        return Activations(policy, value, logits, torch.addmm(bias, value[-1], weight.T).flatten())

    def differentiate(
        self, inputs: Rows, legal: Rows, picked: Picked, run: Activations, by_logits: Tensor, by_values: Tensor
    ) -> None:
        """Compute the gradient of what has these gradients by the logits and the values of a run."""
        parts, gradient = self.parts, self.gradient
        # what kernels add to; the rest is overwritten
        for part in (gradient.weight, *gradient.policy[-1]):
            part.zero_()
        by_policy = torch.zeros_like(run.policy[-1])
        legal_logits_gradient(
            picked,
            legal.starts,
            legal.columns,
            run.policy[-1].numpy(),
            parts.policy[-1][0].numpy(),
            by_logits.numpy(),
            by_policy.numpy(),
            *(part.numpy() for part in gradient.policy[-1]),
        )
        by_value = _through(by_values.unsqueeze(1), run.value[-1], parts.value[-1], gradient.value[-1])
        sides = (
            (by_policy, run.policy, parts.policy, gradient.policy),
            (by_value, run.value, parts.value, gradient.value),
        )
        begins = []
        for by_hidden, hidden, layers, into in sides:
            for i in reversed(range(len(layers) - 1)):
                before = torch.ops.aten.tanh_backward(by_hidden, hidden[i + 1])
                by_hidden = _through(before, hidden[i], layers[i], into[i])
            begins.append(torch.ops.aten.tanh_backward(by_hidden, hidden[0]))
        first = torch.cat(begins, dim=1)
        torch.sum(first, 0, out=gradient.bias)
        linear_gradient(picked, inputs.starts, inputs.columns, inputs.numbers, first.numpy(), gradient.weight.numpy())


def _through(by_outputs: Tensor, inputs: Tensor, layer: Layer, gradient: Layer) -> Tensor:
    """The gradient by the inputs of a layer, given that by its outputs; that by its weights is written to its place."""
    torch.mm(by_outputs.T, inputs, out=gradient[0])
    torch.sum(by_outputs, 0, out=gradient[1])
    return by_outputs @ layer[0]
