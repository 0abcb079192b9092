"""Many games at a time on one array of states, for Gymnasium."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from origami_lab.env.render import picture
from origami_lab.env.shared import (
    RENDER_MODES,
    action_space,
    check_render_mode,
    ending,
    make_episodes,
    observation_space,
    seen,
)
from origami_lab.game.game import Game

Step = tuple[NDArray[Any], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class RigidOrigamiVectorEnv(VectorEnv[NDArray[Any], NDArray[np.int64], NDArray[Any]]):
    """``num_envs`` games side by side, each as :class:`~origami_lab.env.environment.RigidOrigamiEnv` plays it.

    It behaves as Gymnasium's ``SyncVectorEnv`` of single environments does, infos included; but ``np_random``, which
    nothing draws from, is one for all.

    Parameters
    ----------
    num_envs
        Games side by side, at least 1.
    autoreset_mode
        What follows the end of an episode, as Gymnasium names it: ``NextStep`` (the next step begins a new one and
        ignores the action), ``SameStep`` (the same step does; ``final_obs`` and ``final_info`` tell of the old one) or
        ``Disabled`` (``reset(options={"reset_mask": ...})`` does). It stands in ``metadata["autoreset_mode"]``.
    overrides, game, objective, observation, vertices, config_dir, render_mode, **settings
        As of the single environment.

    Raises
    ------
    InputError
        For wrong settings, in the words of the command.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 2, "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        overrides: Sequence[str] = (),
        *,
        game: Game | None = None,
        objective: Any = None,
        observation: str = "compact",
        vertices: int | None = None,
        config_dir: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **settings: object,
    ) -> None:
        self.render_mode = check_render_mode(render_mode)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.num_envs = num_envs
        self._episodes = make_episodes(
            num_envs, overrides, settings, game, objective, config_dir, observation, vertices
        )
        self.problem = self._episodes.problem
        self.game = self.problem.game
        self.single_observation_space = observation_space(self._episodes.view)
        self.single_action_space = action_space(self.game)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._ended = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begin an episode in every game, or in those that ``options["reset_mask"]``, (num_envs,) of bool, marks.

        Raises
        ------
        ValueError
            If there is not one seed for each game in a list of them, or not one truth value in ``reset_mask``.
        """
        seeds = [seed] * self.num_envs if seed is None or isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed must be one number, or a list of {self.num_envs}, one for each game")
        for each in reversed(seeds):  # Gymnasium refuses a wrong one; the first stays
            super().reset(seed=each)
        marked = np.ones(self.num_envs, dtype=np.bool_)
        if options is not None and "reset_mask" in options:
            marked = np.asarray(options["reset_mask"])
            if marked.shape != (self.num_envs,) or marked.dtype != np.bool_:
                raise ValueError(f"options['reset_mask'] must be {self.num_envs} truth values, one for each game")
        for i in np.flatnonzero(marked):
            self._episodes.reset(int(i))
        self._ended[marked] = False
        return self._episodes.observations.copy(), {}

    def step(self, actions: NDArray[np.int64]) -> Step:
        """Play (num_envs,) actions, one in each game.

        Raises
        ------
        ValueError
            If there is not one action for each game, a whole number; none is played then.
        gymnasium.error.ResetNeeded
            If a game has not begun, or has ended and nothing begins it anew (``Disabled``); none is played then.
        """
        if np.shape(actions) != (self.num_envs,):
            raise ValueError(f"must be {self.num_envs} actions, one for each game; the shape is {np.shape(actions)}")
        if np.asarray(actions).dtype.kind not in "iu":
            raise ValueError(f"actions must be whole numbers, not {np.asarray(actions).dtype}")
        episodes, before = self._episodes, self._ended
        idle = ~episodes.masks.any(axis=1)
        if self.autoreset_mode == AutoresetMode.NEXT_STEP:
            idle &= ~before
        if idle.any():
            raise ResetNeeded(f"games {np.flatnonzero(idle).tolist()} have ended or have not begun: reset them first")
        rewards, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=np.bool_)
        infos: dict[str, Any] = {}
        for i, action in enumerate(actions):
            if before[i]:
                episodes.reset(i)
                continue
            rewards[i], ended[i] = episodes.step(i, int(action))
            if not ended[i]:
                continue
            info = ending(episodes, i)
            if self.autoreset_mode == AutoresetMode.SAME_STEP:
                info = {"final_obs": seen(episodes, i), "final_info": info}
                episodes.reset(i)
            infos = self._add_info(infos, info, i)
        self._ended = ended & (self.autoreset_mode != AutoresetMode.SAME_STEP)
        return episodes.observations.copy(), rewards, ended, np.zeros(self.num_envs, dtype=np.bool_), infos

    def action_masks(self) -> NDArray[np.bool_]:
        """(num_envs, n_actions) which actions are legal in each game; none in one that has ended."""
        return self._episodes.masks.copy()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """The picture of each sheet as it stands."""
        if self.render_mode is None:
            return None
        return tuple(picture(self.problem, self._episodes.positions, i) for i in range(self.num_envs))
