"""Episodes as reinforcement learning plays them: side by side, masked, observed, with shaped rewards.

**Rewards** (paper, section 3.6) are the changes of a potential Φ: the objective's bound while an episode runs, 0 before
it begins, its return when it has ended. So they sum to the return, whatever the bound is. Where the objective knows no
bound Φ stays 0 until the end. The bound can only fall, so no reward after the first bounded state is positive.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import SELECTION
from origami_lab.game.observation import View
from origami_lab.search.problem import Problem


class Episodes:
    """Episodes of a problem on one array of positions, each at its own pace.

    Parameters
    ----------
    problem
        Counts the interactions and keeps the best design. Without ``certify`` rewards depend on nothing but the actions
        of the episode; with it, a new best that the dense check refuses is worth the free part of its motion.
    count
        Episodes side by side.
    view
        How states are observed.
    """

    def __init__(self, problem: Problem, count: int, view: View) -> None:
        self.problem, self.view = problem, view
        self.positions = problem.new_positions(count)
        self.observations: NDArray[Any] = np.zeros((count, *view.shape), dtype=view.dtype)
        """(count, …) what is seen of each; kept up to date."""
        self.masks = np.zeros((count, problem.game.rules.n_actions), dtype=np.bool_)
        """(count, n_actions) the legal actions of each, none once it has ended; kept up to date."""
        self.returns = np.zeros(count)
        """(count,) the rewards of each so far; the return once it has ended."""
        self.actions: list[list[int]] = [[] for _ in range(count)]
        """What was played in each so far."""

    def reset(self, i: int) -> None:
        """Begin episode i anew."""
        self.returns[i] = 0.0
        self.actions[i] = []
        self._show(i, self.problem.clear(self.positions, i))

    def go_back(self, actions: list[list[int]]) -> None:
        """Play again what was played in each episode before, without an interaction; none of them has ended."""
        for i, played in enumerate(actions):
            self.reset(i)
            for action in played:
                self.step(i, action, count=False)

    def step(self, i: int, action: int, *, count: bool = True) -> tuple[float, bool]:
        """Play an action in episode i, one interaction: the reward, and whether the episode has ended.

        An action that is not legal, or not one of the game's, ends the episode with the penalty. ``count=False`` is for
        what was counted before.

        Raises
        ------
        SearchEnded
            If the problem's budget is spent.
        """
        problem, game = self.problem, self.problem.game
        # −1 would be the last action to NumPy, and nothing to the kernels
        if not (0 <= action < game.rules.n_actions and self.masks[i, action]):
            problem.spend(1)
            self.masks[i] = False
            return self._move_to(i, game.penalty), True
        legal = problem.play(self.positions, i, action, count=count)
        self.actions[i].append(action)
        self._show(i, legal)
        if not len(legal):
            value = problem.finish(self.positions, i, above=-math.inf)
            return self._move_to(i, value if math.isfinite(value) else game.penalty), True
        if int(self.positions.states["phase"][i]) != SELECTION:
            return 0.0, False  # the sheet has not changed
        return self._move_to(i, self._potential(i)), False

    def _potential(self, i: int) -> float:
        bound = self.problem.evaluator.bound(self.positions.states, self.positions.memos, i)
        if math.isfinite(bound):
            return bound
        return 0.0 if bound > 0 else self.problem.game.penalty

    def _move_to(self, i: int, potential: float) -> float:
        reward = float(potential - self.returns[i])
        self.returns[i] = potential
        return reward

    def _show(self, i: int, legal: NDArray[np.int32]) -> None:
        self.masks[i] = False
        self.masks[i, legal] = True
        self.view.write(self.positions.states, i, self.observations[i])
