"""One game at a time, for Gymnasium (paper, sections 3.3 and 3.6; appendix A, PPO)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from operator import index
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
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


class RigidOrigamiEnv(gymnasium.Env[NDArray[Any], np.int64]):
    """The origami game with one objective.

    An action is an integer of the game (:mod:`origami_lab.game.kernels.state`); :meth:`action_masks` says which are
    legal, and one that is not ends the episode with the game's penalty. Rewards sum to the episode's return, see
    :mod:`origami_lab.search.rl_episodes`. The game is deterministic, so a seed changes nothing but ``np_random``.

    At the end of an episode ``info`` has its ``return``, its ``status`` (why it ended) and the ``actions`` that lead to
    its sheet, which ``game.design`` and ``game.replay`` take. ``problem.outcome()`` is the best episode so far.

    Parameters
    ----------
    overrides
        What to play, in the words of the command: ``["target=bowl", "start.size=2"]``. What is about the search
        (``search``, ``budget``, ``seed``, ``certify`` …) plays no part. Nothing: ``target=pyramid``.
    game, objective
        What to play, instead of settings. An objective's name is a setting: ``objective="table"``.
    observation
        ``compact`` or ``tensor`` (:mod:`origami_lab.game.observation`).
    vertices
        Cap on the vertex axis of the tensor; None for the paper's, all points of the board.
    config_dir
        A folder with options of the user's own.
    render_mode
        ``rgb_array``: crease pattern and folded sheet side by side, (h, 2h, 3).
    **settings
        More settings of a single word: ``target="bowl", symmetry="y"``.

    Raises
    ------
    InputError
        For wrong settings, in the words of the command.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 2}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self,
        overrides: Sequence[str] = (),
        *,
        game: Game | None = None,
        objective: Any = None,
        observation: str = "compact",
        vertices: int | None = None,
        config_dir: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        **settings: object,
    ) -> None:
        self.render_mode = check_render_mode(render_mode)
        self._episodes = make_episodes(1, overrides, settings, game, objective, config_dir, observation, vertices)
        self.problem = self._episodes.problem
        self.game = self.problem.game
        self.observation_space = observation_space(self._episodes.view)
        self.action_space = action_space(self.game)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begin an episode."""
        super().reset(seed=seed)
        self._episodes.reset(0)
        return seen(self._episodes, 0), {}

    def step(self, action: np.int64) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Play an action.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first episode, and after the end of one.
        TypeError
            For an action that is no whole number.
        """
        if not self._episodes.masks.any():
            raise ResetNeeded("the episode has ended or has not begun: call reset() before step()")
        reward, ended = self._episodes.step(0, index(action))
        return seen(self._episodes, 0), reward, ended, False, ending(self._episodes, 0) if ended else {}

    def action_masks(self) -> NDArray[np.bool_]:
        """(n_actions,) which actions are legal; the name is sb3-contrib's."""
        return np.array(self._episodes.masks[0])

    def render(self) -> NDArray[np.uint8] | None:
        """The picture of the sheet as it stands, at the driving angle that is best so far."""
        return None if self.render_mode is None else picture(self.problem, self._episodes.positions, 0)
