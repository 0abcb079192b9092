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
def chances_of(starts: Wholes, actions: Wholes, logits: Floats, chances: Floats) -> None:
    """The probabilities of the legal actions, by the logits of all; ``chances`` comes as zeros."""
    for i in range(logits.shape[0]):
        legal = actions[starts[i] : starts[i + 1]]
        highest = -np.inf
        for action in legal:
            highest = max(highest, logits[i, action])
        total = 0.0
        for action in legal:
            total += np.exp(logits[i, action] - highest)
        for action in legal:
            chances[i, action] = np.exp(logits[i, action] - highest) / total


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
        (k,) which of the n interactions.
    starts, legal
        Their legal actions, as sparse rows.
    played, log_chances
        (n,) the actions played, and the logarithms of the probabilities they were played with.
    advantages, returns
        (n,)
    logits, values
        (k, actions) and (k,) of the picked ones, now.
    clip
        How far P/P′ may be from 1 for the better.
    entropy, value
        Weights in the loss.
    by_logits, by_values
        (k, actions), which comes as zeros, and (k,): the gradients.
    """
    k = picked.shape[0]
    mean, deviation = 0.0, 0.0
    for i in range(k):
        mean += advantages[picked[i]] / k
    for i in range(k):
        deviation += (advantages[picked[i]] - mean) ** 2
    # of one interaction there is no deviation: its advantage stays as it is
    deviation = np.sqrt(deviation / (k - 1)) + 1e-8 if k > 1 else 1.0
    mean = mean if k > 1 else 0.0
    for i in range(k):
        at = picked[i]
        by_values[i] = 2 * value * (values[i] - returns[at]) / k
        actions = legal[starts[at] : starts[at + 1]]
        highest = -np.inf
        for action in actions:
            highest = max(highest, logits[i, action])
        total = 0.0
        for action in actions:
            total += np.exp(logits[i, action] - highest)
        shift = highest + np.log(total)
        mixed = 0.0
        for action in actions:
            log_chance = logits[i, action] - shift
            mixed += np.exp(log_chance) * log_chance
        ratio = np.exp(logits[i, played[at]] - shift - log_chances[at])
        gain = (advantages[at] - mean) / deviation * ratio
        if (gain > 0 and ratio > 1 + clip) or (gain < 0 and ratio < 1 - clip):
            gain = 0.0
        for action in actions:
            log_chance = logits[i, action] - shift
            chance = np.exp(log_chance)
            by_logits[i, action] = chance * (gain + entropy * (log_chance - mixed)) / k
        by_logits[i, played[at]] -= gain / k
