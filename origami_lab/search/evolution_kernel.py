"""A generation of EVO, compiled: its agents play and are judged one after another, until one may be the best.

What an agent plays is told from what others played by 126 bits of its actions, so that two different episodes of a
search are taken for one with a probability below 10⁻²⁰.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import Actions, play_greedy
from origami_lab.game.kernels.state import RUNNING, Record, States, copy_state, is_penalised
from origami_lab.jit import bare, inlined
from origami_lab.objectives.compiled_score import CompiledScore, best_in_kernel, value_in_kernel
from origami_lab.objectives.objective import Memos
from origami_lab.search.neighbourhood.known_strays import mixed

# why play stopped: all have played, the limit came first, an agent has ended that may be the best of all
ALL, PAUSED, CANDIDATE = 0, 1, 2

AGENT, IS_PLAYING, N_RANKED = 0, 1, 2
"""Counters: the agent whose turn it is, whether it is in the middle of its episode, returns that would make parents."""

FIRST_PRIME, SECOND_PRIME, BASE = 2147483647, 2147483629, 1000003


class PlayedEpisodes(NamedTuple):
    """Episodes by what was played, in a table with open addressing and room for twice as many.

    Attributes
    ----------
    keys
        (n, 2) int64 of an episode's actions, see :func:`key_of`; the second is 0 where there is none. n is a power of
        2.
    values
        (n,) returns of those that were good enough for a parent, NaN for the others.
    """

    keys: NDArray[np.int64]
    values: NDArray[np.float64]


class Generation(NamedTuple):
    """A generation at play.

    Attributes
    ----------
    counters
        (3,) int64: :data:`AGENT` and so on.
    returns
        (population,) of each agent; −inf where it cannot be enough to become a parent.
    ranked
        (parents,) the returns that would make parents so far, falling.
    seen
        What was played in this generation.
    known
        What was played in the one before: what has a return there is not scored again.
    """

    counters: NDArray[np.int64]
    returns: NDArray[np.float64]
    ranked: NDArray[np.float64]
    seen: PlayedEpisodes
    known: PlayedEpisodes


def no_episodes(agents: int) -> PlayedEpisodes:
    """An empty table for the episodes of so many agents."""
    size = 1 << (2 * agents).bit_length()
    return PlayedEpisodes(np.zeros((size, 2), dtype=np.int64), np.full(size, np.nan))


@inlined
def key_of(s: Record) -> tuple[np.int64, np.int64]:
    """126 bits of a state's actions: a xorshift generator fed with them, and their polynomials modulo two primes."""
    shifted, first, second = np.int64(88172645463325252), np.int64(1), np.int64(1)
    for i in range(s.n_actions):
        action = np.int64(s.actions[i]) + 1
        shifted = mixed(shifted, action)
        first, second = (first * BASE + action) % FIRST_PRIME, (second * BASE + action) % SECOND_PRIME
    return shifted, (np.int64(1) << 62) | (first << 31) | second


@inlined
def slot_of(episodes: PlayedEpisodes, key: tuple[np.int64, np.int64]) -> int:
    """Where an episode is in a table, or would be."""
    last = episodes.values.shape[0] - 1
    i = key[0] & last
    while episodes.keys[i, 1] != 0 and (episodes.keys[i, 0] != key[0] or episodes.keys[i, 1] != key[1]):
        i = (i + 1) & last
    return int(i)


@bare
def rank(generation: Generation, agent: int, slot: int, value: float) -> None:
    """Note what the agent whose turn it is has achieved with the episode in a slot of those seen."""
    counters, ranked = generation.counters, generation.ranked
    n, most = counters[N_RANKED], ranked.shape[0]
    worst = ranked[n - 1] if n == most else -np.inf
    if not (value >= worst and value > -np.inf):
        return
    generation.returns[agent] = value
    generation.seen.values[slot] = value
    i = n if n < most else n - 1
    while i > 0 and ranked[i - 1] < value:
        ranked[i] = ranked[i - 1]
        i -= 1
    ranked[i] = value
    counters[N_RANKED] = min(n + 1, most)


@bare
def play_generation(
    states: States,
    origin: States,
    rules: States,
    memos: Memos,
    score: CompiledScore,
    agents: NDArray[np.float64],
    slots: NDArray[np.int32],
    generation: Generation,
    penalty: float,
    best: float,
    given: float,
    limit: int,
    legal: Actions,
) -> tuple[int, int, int, float]:
    """Let agents play on the first state, each from where episodes begin, until one is better than ``best``.

    Parameters
    ----------
    states, origin, memos
        What is played on, where episodes begin, and the evaluator's notes: of the first state, and clear ones.
    agents, slots
        (population, m) value vectors, and where in them actions stand: see :func:`~.evolution.value_slots`.
    penalty
        The return of an episode that is penalised.
    given
        After CANDIDATE, what its return is; else NaN.
    limit
        Actions that may be played.

    Returns
    -------
    why
        ALL, PAUSED or CANDIDATE: the agent on the state may be the best of all; its notes are clear.
    played, ended
        Actions played, and episodes that have ended; that of a candidate is not counted.
    below
        A candidate's return need not be known if it is not above this.
    """
    s, r = states[0], rules[0]
    counters, ranked, seen, known = generation.counters, generation.ranked, generation.seen, generation.known
    played = ended = 0
    while counters[AGENT] < agents.shape[0]:
        agent = counters[AGENT]
        if np.isnan(given):
            if counters[IS_PLAYING] == 0:
                copy_state(s, origin[0])
                memos[0] = memos[1]
                counters[IS_PLAYING] = 1
            played += play_greedy(states, 0, rules, agents[agent], slots, limit - played, legal)
            if s.status == RUNNING:
                return PAUSED, played, ended, 0.0
            counters[IS_PLAYING] = 0
        key = key_of(s)
        slot, before = slot_of(seen, key), slot_of(known, key)
        is_new = seen.keys[slot, 1] == 0
        seen.keys[slot, 0], seen.keys[slot, 1] = key
        value = -np.inf
        if not np.isnan(given):
            value, given = given, np.nan
        elif not is_new:
            ended += 1
        elif not np.isnan(known.values[before]):
            ended += 1
            value = known.values[before]
        elif is_penalised(s, r):
            ended += 1
            value = penalty
        else:
            # one that equals the worst of the best may become a parent, too
            n = counters[N_RANKED]
            below = best
            if n < ranked.shape[0]:
                below = -np.inf
            elif ranked[n - 1] <= best:
                below = np.nextafter(ranked[n - 1], -np.inf)
            if below == -np.inf:
                value = value_in_kernel(states, 0, rules, memos, 0, score)
            else:
                value = best_in_kernel(states, 0, rules, memos, 0, score, below)[0]
            if value > best:
                memos[0] = memos[1]
                return CANDIDATE, played, ended, below
            ended += 1
        rank(generation, agent, slot, value)
        counters[AGENT] = agent + 1
    return ALL, played, ended, 0.0
