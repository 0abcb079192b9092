"""The walk of DFTS and BFTS over the game tree, compiled.

One state is played on and back (:mod:`origami_lab.game.kernels.undo`); a node is the position at a depth, with its
sampled children. The walk stops whenever there is something that only the caller can do, and goes on from there: an
episode whose score is not compiled, or may be the best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import play_action, settle
from origami_lab.game.kernels.state import FIRST, RUNNING, SELECTION, Record, States, is_penalised
from origami_lab.game.kernels.undo import Notes, play_noted, restore, write_note
from origami_lab.jit import bare, inlined
from origami_lab.objectives.compiled_score import CompiledScore, best_in_kernel, bound_in_kernel
from origami_lab.objectives.inside_moves import stray_inside
from origami_lab.objectives.known_places import Surface
from origami_lab.objectives.objective import Memos
from origami_lab.objectives.shape_kernels import stray
from origami_lab.search.random_stream import Actions, sample_distinct

# why the walk stopped
EXHAUSTED, PAUSED, ENDED, UNBOUNDED = 0, 1, 2, 3

# how it begins or goes on
START, CONTINUE, TAKE_BACK, GIVEN = 0, 1, 2, 3

COUNT, TRIED, ENTERED = 0, 1, 2
"""Columns of a node's counters: its children, how many were tried, and how many BFTS has gone into since."""


@bare
def open_node(node: NDArray[np.int64], children: Actions, legal: Actions, draws: NDArray[np.float64], used: int) -> int:
    """Sample the children of a node; returns the number of draws used in all."""
    count = min(legal.shape[0], children.shape[0])
    sample_distinct(legal, draws, used, children[:count])
    node[COUNT], node[TRIED], node[ENTERED] = count, 0, 0
    return used + count


@bare
def sort_children(children: Actions, bounds: NDArray[np.float64], count: int) -> None:
    """Order children by falling bounds; equal ones keep their order."""
    for i in range(1, count):
        child, bound = children[i], bounds[i]
        j = i
        while j > 0 and bounds[j - 1] < bound:
            children[j], bounds[j] = children[j - 1], bounds[j - 1]
            j -= 1
        children[j], bounds[j] = child, bound


@inlined
def try_child(s: Record, r: Record, action: int, note: Record, legal: Actions, only_tried: bool) -> int:
    """Play an action so that it can be taken back; returns how many are legal then.

    At least 1 for any number, and ``legal`` is not written, where the child is only tried and can end the episode.
    """
    write_note(s, r, action, note)
    play_action(s, r, action)
    if only_tried and s.phase == SELECTION and s.status == RUNNING and s.n_extensions > 0:
        return 1
    return settle(s, r, legal)


@bare
def is_no_better(
    states: States, rules: States, memos: Memos, depth: int, score: CompiledScore | None, best: float
) -> bool:
    """Whether the episode that has ended on the first state is known to have no return above the best one.

    Its notes are at ``depth``.
    """
    if score is None:
        return False
    return is_penalised(states[0], rules[0]) or best_in_kernel(states, 0, rules, memos, depth, score, best)[1] < 0


@bare
def walk(
    states: States,
    rules: States,
    notes: Notes,
    memos: Memos,
    legal: Actions,
    counters: NDArray[np.int64],
    children: Actions,
    bounds: NDArray[np.float64],
    best_first: bool,
    target: Surface | None,
    inside_moves: bool,
    score: CompiledScore | None,
    draws: NDArray[np.float64],
    used: int,
    depth: int,
    how: int,
    given: float,
    best: float,
    limit: int,
) -> tuple[int, int, int, int, int]:
    """Walk on until there is something to be done elsewhere.

    Parameters
    ----------
    states, notes, memos
        The state walked on, what its actions overwrote, and the evaluator's memo at each depth.
    counters, children, bounds
        (D, 3), (D, C), (D, C + 1) the nodes: :data:`COUNT` and so on, sampled children, the children's bounds and,
        last, the node's own.
    best_first
        BFTS: try every child before the most promising one is entered. DFTS enters a child at once.
    target
        What positions are bounded with; None for ``score``, and without that to ask the caller.
    inside_moves
        Whether the places of chosen outer children bound an extension that is not complete; not without ``target``.
    score
        What says that an ended episode is no better than ``best``, the best return so far; None to ask the caller.
    draws, used
        Random numbers, and how many of them are used up.
    depth, how, given
        Where the last call stopped, and how to go on: START from the state as it is; CONTINUE; TAKE_BACK the child that
        ENDED; with the bound GIVEN for the child that was UNBOUNDED.
    best
        Bounds not above this are not worth entering.
    limit
        Interactions that may be played.

    Returns
    -------
    why
        EXHAUSTED: the tree is searched. PAUSED: the limit is reached, or more draws or room for more depth are needed.
        ENDED, UNBOUNDED: a child of the node at ``depth`` is on the board, and its episode has ended, or it has
        completed a move.
    depth, used, played, ended
        Depth of the node, draws used, interactions played, episodes that have ended and are no better.
    """
    s, r = states[0], rules[0]
    width = children.shape[1]
    played = ended = 0
    if how == START:
        n = settle(s, r, legal)
        depth = 0
        bounds[0, width] = np.inf
        used = open_node(counters[0], children[0], legal[:n], draws, used)
    elif how == TAKE_BACK:
        restore(s, notes[depth])
    while True:
        node, own = counters[depth], bounds[depth, width]
        if how == GIVEN:
            how = CONTINUE
            n, bound = settle(s, r, legal), given
            child, enter = node[TRIED] - 1, not best_first
        elif played >= limit or draws.shape[0] - used < width or depth + 2 >= memos.shape[0]:
            return PAUSED, depth, used, played, ended
        elif own > best and node[TRIED] < node[COUNT]:
            child, enter = node[TRIED], not best_first
            node[TRIED] += 1
            played += 1
            n = try_child(s, r, children[depth, child], notes[depth], legal, best_first)
            memos[depth + 1] = memos[depth]
            bound = own
            if n == 0:
                bounds[depth, child] = -np.inf
                if is_no_better(states, rules, memos, depth + 1, score, best):
                    ended += 1
                    restore(s, notes[depth])
                    continue
                return ENDED, depth, used, played, ended
            if s.phase == SELECTION:
                if target is not None:
                    bound = -stray(s, r, memos[depth + 1], target, -best)
                elif score is not None:
                    if played >= limit:
                        return UNBOUNDED, depth, used, played, ended  # as without it: no draws for a tree that ends
                    bound = bound_in_kernel(states, 0, rules, memos, depth + 1, score, best)
                else:
                    return UNBOUNDED, depth, used, played, ended
            elif inside_moves and s.phase > FIRST:
                if target is not None:
                    bound = min(own, -stray_inside(s, r, memos[depth + 1], target, -best))
        elif own > best and best_first and node[ENTERED] < node[COUNT]:
            if node[ENTERED] == 0:
                sort_children(children[depth], bounds[depth], node[COUNT])
            child, enter = node[ENTERED], True
            node[ENTERED] += 1
            bound = min(bounds[depth, child], own)
            if bound <= best:
                node[ENTERED] = node[COUNT]  # nor are the bounds of those after it
                continue
            n = play_noted(s, r, children[depth, child], notes[depth], legal)
            memos[depth + 1] = memos[depth]
        elif depth > 0:
            depth -= 1
            restore(s, notes[depth])
            continue
        else:
            return EXHAUSTED, depth, used, played, ended
        if enter and bound > best:
            depth += 1
            bounds[depth, width] = bound
            used = open_node(counters[depth], children[depth], legal[:n], draws, used)
        else:
            bounds[depth, child] = bound
            restore(s, notes[depth])
