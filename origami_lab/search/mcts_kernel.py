"""The tree of MCTS, compiled: selection by PUCT, expansion, rollout and backup.

A node holds an action and statistics, never a state: from a copy of the real position the path is played again. The
children of a node stand in one row, in the order of its legal actions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import Actions, play_action, settle
from origami_lab.game.kernels.state import Record, States, copy_state, is_penalised
from origami_lab.jit import bare, inlined
from origami_lab.objectives.compiled_score import CompiledScore, value_in_kernel
from origami_lab.objectives.objective import Memos

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
# and why there were no more of them
FINISHED, RESCALED, PAUSED = 3, 4, 5

Scale = NDArray[np.float64]
"""(5,) the returns that stand for −1 and 1, the lowest and highest that were seen, and whether one lay outside."""
LOW, HIGH, LOWEST, HIGHEST, IS_LEFT = 0, 1, 2, 3, 4


@inlined
def set_node(node: Record, action: int, prior: float) -> None:
    """A node that was not visited yet."""
    node.first, node.count, node.action, node.visits = 0, UNKNOWN, action, 0
    node.total, node.prior = 0.0, prior


@bare
def plant(nodes: Nodes) -> None:
    """A tree of the root only."""
    set_node(nodes[0], -1, 1.0)


@inlined
def normalised(value: float, low: float, high: float) -> float:
    """A return, or a mean of returns, on the scale from −1 (low) to 1 (high); 0 if there is no scale."""
    return 2.0 * (value - low) / (high - low) - 1.0 if high > low else 0.0


@bare
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


@bare
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


@bare
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


@bare
def see(scale: Scale, value: float) -> bool:
    """Take note of the return of an episode that was not penalised.

    Returns whether it was the first one outside: what was clipped before then lies off the new scale.
    """
    if np.isinf(value):
        return False
    scale[LOWEST], scale[HIGHEST] = min(scale[LOWEST], value), max(scale[HIGHEST], value)
    first = scale[IS_LEFT] == 0.0 and not scale[LOW] <= value <= scale[HIGH]
    if first:
        scale[IS_LEFT] = 1.0
    if scale[IS_LEFT] != 0.0:
        scale[LOW], scale[HIGH] = scale[LOWEST], scale[HIGHEST]
    return bool(first)


@inlined
def clip(scale: Scale, value: float) -> float:
    """The return, not below the lowest: the penalty, and −inf for a worthless design, are the lowest."""
    return float(min(max(value, scale[LOW]), scale[HIGH]))


@bare
def simulate_many(
    states: States,
    rules: States,
    memos: Memos,
    score: CompiledScore,
    nodes: Nodes,
    size: int,
    root: int,
    exploration: float,
    scale: Scale,
    unvisited: float,
    epsilon: float,
    noise: NDArray[np.float64],
    noise_used: int,
    draws: NDArray[np.float64],
    used: int,
    path: NDArray[np.int32],
    legal: Actions,
    penalty: float,
    best: float,
    count: int,
    limit: int,
    pace: int,
    most: int,
) -> tuple[int, int, int, int, int, int, int, int]:
    """``count`` simulations, each as :func:`simulate`, judged and backed up, until one is better than ``best``.

    Parameters
    ----------
    memos
        The evaluator's notes on the two states; those on the second one are overwritten.
    scale
        The returns that are −1 and 1, and what they come from; see :func:`see`.
    penalty
        The return of an episode that is penalised.
    limit, pace
        Actions that may be played, and after which a simulation is the last one.
    most
        Nodes after which a simulation is the last one.

    Returns
    -------
    why
        ENDED: an episode has ended that may be the best; it is not backed up. CUT: the limit came first. FINISHED: as
        many as there shall be. RESCALED: the returns in the tree are no longer on one scale. PAUSED: the pace is
        reached, or more draws, noise or nodes are needed.
    depth, size, noise_used, used, played, simulated, ended
        Depth of the last node, nodes in use, random numbers used, actions played, simulations that are backed up,
        episodes that have ended and are no better.
    """
    played = simulated = ended = depth = 0
    while simulated < count:
        if played >= min(limit, pace) or size + legal.shape[0] > nodes.shape[0]:
            return PAUSED, depth, size, noise_used, used, played, simulated, ended
        if draws.shape[0] - used < path.shape[0] - 1:
            return PAUSED, depth, size, noise_used, used, played, simulated, ended
        if epsilon > 0.0 and noise.shape[0] - noise_used < legal.shape[0]:
            return PAUSED, depth, size, noise_used, used, played, simulated, ended
        before = size
        why, depth, size, used, actions = simulate(
            states,
            rules,
            nodes,
            size,
            root,
            exploration,
            scale[LOW],
            scale[HIGH],
            unvisited,
            epsilon,
            noise,
            noise_used,
            draws,
            used,
            path,
            legal,
            limit - played,
        )
        noise_used += size - before
        played += actions
        if why == CUT:
            return CUT, depth, size, noise_used, used, played, simulated, ended
        is_first_outside = False
        if why == KNOWN:
            node = nodes[path[depth]]
            value = node.total / node.visits
        elif is_penalised(states[1], rules[0]):
            value = penalty
        else:
            memos[1] = memos[0]
            value = value_in_kernel(states, 1, rules, memos, 1, score)
            if value > best:
                return ENDED, depth, size, noise_used, used, played, simulated, ended
            is_first_outside = see(scale, value)
        ended += 1
        simulated += 1
        back_up(nodes, path, depth, clip(scale, value))
        if is_first_outside:
            return RESCALED, depth, size, noise_used, used, played, simulated, ended
        if size >= most:
            break
    return FINISHED, depth, size, noise_used, used, played, simulated, ended


@bare
def back_up(nodes: Nodes, path: NDArray[np.int32], depth: int, value: float) -> None:
    """Add a return to the nodes of a path."""
    for i in range(depth + 1):
        nodes[path[i]].visits += 1
        nodes[path[i]].total += value
