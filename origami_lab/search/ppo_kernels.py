"""What PPO computes on what is sparse: observations, nearly all of whose numbers are 0, and the few legal actions.

Rows of sparse numbers lie one after the other: row i is ``starts[i]`` to ``starts[i + 1]`` of two arrays, the columns
and the numbers there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import kernel

Floats = NDArray[np.float32]
Wholes = NDArray[np.int64]


@kernel
def sparse_rows(dense: NDArray[Any]) -> tuple[Wholes, Wholes, Floats]:
    """The rows of a (n, m) array without their zeros: (n + 1,) starts, columns and numbers."""
    n, m = dense.shape
    starts = np.zeros(n + 1, np.int64)
    for i in range(n):
        count = 0
        for j in range(m):
            count += dense[i, j] != 0
        starts[i + 1] = starts[i] + count
    columns, numbers = np.empty(starts[n], np.int64), np.empty(starts[n], np.float32)
    for i in range(n):
        k = starts[i]
        for j in range(m):
            if dense[i, j] != 0:
                columns[k], numbers[k] = j, dense[i, j]
                k += 1
    return starts, columns, numbers


@kernel
def linear(picked: Wholes, starts: Wholes, columns: Wholes, numbers: Floats, weight: Floats, out: Floats) -> None:
    """Add the products of the picked sparse rows and (columns, outputs) weights to ``out``, (picked, outputs)."""
    for i in range(picked.shape[0]):
        for k in range(starts[picked[i]], starts[picked[i] + 1]):
            number, row = numbers[k], columns[k]
            for j in range(out.shape[1]):
                out[i, j] += number * weight[row, j]


@kernel
def linear_gradient(
    picked: Wholes, starts: Wholes, columns: Wholes, numbers: Floats, gradient: Floats, out: Floats
) -> None:
    """Add the gradient by the weights of :func:`linear` to ``out``, given that by its result."""
    for i in range(picked.shape[0]):
        for k in range(starts[picked[i]], starts[picked[i] + 1]):
            number, row = numbers[k], columns[k]
            for j in range(out.shape[1]):
                out[row, j] += number * gradient[i, j]


@kernel
def legal_logits(
    picked: Wholes, starts: Wholes, actions: Wholes, hidden: Floats, weight: Floats, bias: Floats, out: Floats
) -> None:
    """The logits of the legal actions of the picked states, one after the other.

    A linear layer of (actions, inputs) weights on (picked, inputs) hidden values, of which only these are computed.
    """
    at = 0
    for i in range(picked.shape[0]):
        for k in range(starts[picked[i]], starts[picked[i] + 1]):
            out[at] = np.dot(weight[actions[k]], hidden[i]) + bias[actions[k]]
            at += 1


@kernel
def legal_logits_gradient(
    picked: Wholes,
    starts: Wholes,
    actions: Wholes,
    hidden: Floats,
    weight: Floats,
    gradient: Floats,
    by_hidden: Floats,
    by_weight: Floats,
    by_bias: Floats,
) -> None:
    """Add the gradients by the arguments of :func:`legal_logits`, given that by its result."""
    at = 0
    for i in range(picked.shape[0]):
        for k in range(starts[picked[i]], starts[picked[i] + 1]):
            action, factor = actions[k], gradient[at]
            by_bias[action] += factor
            for j in range(hidden.shape[1]):
                by_hidden[i, j] += factor * weight[action, j]
                by_weight[action, j] += factor * hidden[i, j]
            at += 1


@kernel
def chances_of(starts: Wholes, actions: Wholes, logits: Floats, chances: Floats) -> None:
    """The probabilities of the legal actions of all states, by their logits; ``chances`` comes as zeros."""
    for i in range(chances.shape[0]):
        highest = logits[starts[i] : starts[i + 1]].max()
        total = 0.0
        for k in range(starts[i], starts[i + 1]):
            total += np.exp(logits[k] - highest)
        for k in range(starts[i], starts[i + 1]):
            chances[i, actions[k]] = np.exp(logits[k] - highest) / total


@kernel
def loss_gradient(
    picked: Wholes,
    starts: Wholes,
    legal: Wholes,
    played: Wholes,
    log_chances: Floats,
    advantages: Floats,
    returns: Floats,
    logits: Floats,
    values: Floats,
    clip: float,
    entropy: float,
    value: float,
    by_logits: Floats,
    by_values: Floats,
) -> None:
    """The gradient of PPO's loss over the picked interactions by the logits of their actions and by their values.

    With the probabilities p of the legal actions, P of the played one now and P′ when it was played, the advantages A
    brought to mean 0 and standard deviation 1, the values V and the returns R the loss is the mean of

        −min(A P/P′, A clipped(P/P′)) + value (V − R)² + entropy Σ p log p

    Parameters
    ----------
    picked
        (n,) which interactions.
    starts, legal
        The legal actions of all, as sparse rows.
    played, log_chances
        (all,) the actions played, and the logarithms of the probabilities they were played with.
    advantages, returns
        (all,)
    logits, values
        Of the picked ones, now: the logits of their legal actions, one after the other, and (n,) values.
    clip
        How far P/P′ may be from 1 for the better.
    entropy, value
        Weights in the loss.
    by_logits, by_values
        The gradients by these two.
    """
    n, begin = picked.shape[0], 0
    mean, deviation = 0.0, 0.0
    for i in range(n):
        mean += advantages[picked[i]] / n
    for i in range(n):
        deviation += (advantages[picked[i]] - mean) ** 2
    # of one interaction there is no deviation: its advantage stays as it is
    deviation = np.sqrt(deviation / (n - 1)) + 1e-8 if n > 1 else 1.0
    mean = mean if n > 1 else 0.0
    for i in range(n):
        at = picked[i]
        by_values[i] = 2 * value * (values[i] - returns[at]) / n
        first = starts[at]
        count = starts[at + 1] - first
        highest = logits[begin : begin + count].max()
        total = 0.0
        for k in range(begin, begin + count):
            total += np.exp(logits[k] - highest)
        shift = highest + np.log(total)
        mixed, log_chance = 0.0, 0.0
        for k in range(begin, begin + count):
            mixed += np.exp(logits[k] - shift) * (logits[k] - shift)
            if legal[first + k - begin] == played[at]:
                log_chance = logits[k] - shift
        ratio = np.exp(log_chance - log_chances[at])
        gain = (advantages[at] - mean) / deviation * ratio
        if (gain > 0 and ratio > 1 + clip) or (gain < 0 and ratio < 1 - clip):
            gain = 0.0
        for k in range(begin, begin + count):
            by_logits[k] = np.exp(logits[k] - shift) * (gain + entropy * (logits[k] - shift - mixed)) / n
            if legal[first + k - begin] == played[at]:
                by_logits[k] -= gain / n
        begin += count
