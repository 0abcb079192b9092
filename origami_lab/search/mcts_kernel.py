"""The tree of MCTS, compiled: selection by PUCT, expansion, rollout and backup.

A node holds an action and statistics, never a state: from a copy of the real position the path is played again. The
children of a node stand in one row, in the order of its legal actions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import Actions, play_action, settle
from origami_lab.game.kernels.state import Record, States, copy_state
from origami_lab.jit import inlined, kernel

NODE = np.dtype(
    (
        np.record,
        np.dtype(
            [
                ("first", np.int32),  # the first child
                ("count", np.int32),  # children: 0 where the episode ends, UNKNOWN before the node is expanded
                ("action", np.int32),  # that leads here
                ("visits", np.int32),
                ("total", np.float64),  # of the returns of its visits
                ("prior", np.float64),
            ],
            align=True,
        ),
    )
)
"""A node of the tree."""

Nodes = NDArray[np.void]
"""Array of nodes; a child stands behind its parent."""

UNKNOWN = -1

# how a simulation ended: its episode has ended; at a node where one had ended before; the limit came first
ENDED, KNOWN, CUT = 0, 1, 2


@inlined
def set_node(node: Record, action: int, prior: float) -> None:
    """A node that was not visited yet."""
    node.first, node.count, node.action, node.visits = 0, UNKNOWN, action, 0
    node.total, node.prior = 0.0, prior


@kernel
def plant(nodes: Nodes) -> None:
    """A tree of the root only."""
    set_node(nodes[0], -1, 1.0)


@inlined
def normalised(value: float, low: float, high: float) -> float:
    """A return, or a mean of returns, on the scale from −1 (low) to 1 (high); 0 if there is no scale."""
    return 2.0 * (value - low) / (high - low) - 1.0 if high > low else 0.0


@kernel
def best_child(nodes: Nodes, parent: int, exploration: float, low: float, high: float, unvisited: float) -> int:
    """The child with the highest Q + c·P·√(visits of the parent) / (1 + its visits), the first of equal ones.

    Parameters
    ----------
    exploration
        c.
    low, high
        The returns that are −1 and 1 in Q, the mean of a child's returns.
    unvisited
        Q of a child without visits; NaN for its parent's.
    """
    node = nodes[parent]
    if np.isnan(unvisited):
        unvisited = normalised(node.total / node.visits, low, high)
    width = exploration * np.sqrt(float(node.visits))
    best, highest = -1, -np.inf
    for i in range(node.first, node.first + node.count):
        child = nodes[i]
        q = normalised(child.total / child.visits, low, high) if child.visits > 0 else unvisited
        score = q + width * child.prior / (1 + child.visits)
        if score > highest:
            best, highest = i, score
    return best


@kernel
def expand(nodes: Nodes, size: int, parent: int, legal: Actions, epsilon: float, noise: NDArray[np.float64]) -> None:
    """Give a node its children, from index ``size`` on.

    Their priors are (1 − ε)/n + ε·Dir(α), where ``noise`` holds the logarithms of n gamma variates of shape α.
    """
    n = legal.shape[0]
    nodes[parent].first, nodes[parent].count = size, n
    highest, total = -np.inf, 0.0
    if epsilon > 0.0:
        for i in range(n):
            highest = max(highest, noise[i])
        for i in range(n):
            total += np.exp(noise[i] - highest)
    for i in range(n):
        prior = (1.0 - epsilon) / n
        if epsilon > 0.0:
            prior += epsilon * np.exp(noise[i] - highest) / total
        set_node(nodes[size + i], legal[i], prior)


@kernel
def simulate(
    states: States,
    rules: States,
    nodes: Nodes,
    size: int,
    root: int,
    exploration: float,
    low: float,
    high: float,
    unvisited: float,
    epsilon: float,
    noise: NDArray[np.float64],
    noise_used: int,
    draws: NDArray[np.float64],
    used: int,
    path: NDArray[np.int32],
    legal: Actions,
    limit: int,
) -> tuple[int, int, int, int, int]:
    """One simulation: down the tree to a node without children, which gets some, and at random to the end.

    Parameters
    ----------
    states
        The real position, that of the root, and one to play in.
    nodes, size
        The tree: ``size`` of the nodes are in use, and there is room for as many more as there can be legal actions.
    noise, noise_used, draws, used
        Random numbers for :func:`expand` and for the rollout, enough of both, and how many are used up.
    path
        Receives the nodes on the way, from the root on.
    limit
        Actions that may be played.

    Returns
    -------
    why
        ENDED: the episode has ended and is to be scored. KNOWN: it has ended at a node where others did. CUT: it was
        not finished.
    depth, size, used, played
        Depth of the last node, nodes in use, draws used, actions played in the tree and out of it.
    """
    copy_state(states[1], states[0])
    s, r = states[1], rules[0]
    node, depth, played = root, 0, 0
    path[0] = root
    while nodes[node].count > 0:
        if played == limit:
            return CUT, depth, size, used, played
        node = best_child(nodes, node, exploration, low, high, unvisited)
        play_action(s, r, nodes[node].action)
        played += 1
        depth += 1
        path[depth] = node
    if nodes[node].count == 0:
        return KNOWN, depth, size, used, played
    n = settle(s, r, legal)
    if n == 0:
        nodes[node].count = 0
        return ENDED, depth, size, used, played
    expand(nodes, size, node, legal[:n], epsilon, noise[noise_used : noise_used + n])
    size += n
    while n > 0:
        if played == limit:
            return CUT, depth, size, used, played
        play_action(s, r, legal[int(draws[used] * n)])
        used += 1
        played += 1
        n = settle(s, r, legal)
    return ENDED, depth, size, used, played


@kernel
def back_up(nodes: Nodes, path: NDArray[np.int32], depth: int, value: float) -> None:
    """Add a return to the nodes of a path."""
    for i in range(depth + 1):
        nodes[path[i]].visits += 1
        nodes[path[i]].total += value
