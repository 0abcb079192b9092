"""The common parts of both forms of the environment: a problem without an end, its episodes, the spaces."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from origami_lab.config.compose import check_texts, compose_settings, working_directory_importable
from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import RUNNING, STATUS_NAMES
from origami_lab.game.observation import View, view_of
from origami_lab.search.problem import Problem
from origami_lab.search.rl_episodes import Episodes

RENDER_MODES = ["rgb_array"]
DEFAULT = ("target=pyramid",)
"""Settings of the game where nothing is asked for."""


def make_episodes(
    count: int,
    overrides: Sequence[str],
    settings: Mapping[str, object],
    game: Game | None,
    objective: Any,
    config_dir: str | os.PathLike[str] | None,
    observation: str,
    vertices: int | None,
) -> Episodes:
    """Episodes of the game and objective that the settings name, or of those given.

    Raises
    ------
    InputError
        For wrong settings, in the words of the command, and if ``count`` is not at least 1.
    """
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise InputError("num_envs", count, "must be a whole number, at least 1")
    if isinstance(objective, str):  # also a setting of a single word
        settings, objective = {"objective": objective, **settings}, None
    given = [*check_texts(overrides), *(f"{key}={as_override(value)}" for key, value in settings.items())]
    if (game is None) != (objective is None):
        raise InputError("game", game, "must be given together with an objective")
    if game is None:
        game, objective = _from_settings(given or DEFAULT, config_dir)
    elif given or config_dir is not None:
        raise InputError("overrides", given, "must be left out where a game and an objective are given")
    problem = Problem(game, objective, sys.maxsize, certify=False)
    return Episodes(problem, count, view_of(game, observation, vertices))


def _from_settings(overrides: Sequence[str], config_dir: str | os.PathLike[str] | None) -> tuple[Game, Any]:
    from origami_lab.config.instantiate import build_parts

    own = None if config_dir is None else expanded(config_dir)
    with working_directory_importable():
        parts = build_parts(compose_settings(overrides, own))
    return parts.game, parts.objective


def as_override(value: object) -> str:
    """A Python value as it is typed behind ``key=``."""
    return value if isinstance(value, str) else json.dumps(value)


def observation_space(view: View) -> spaces.Box:
    """The space of a view's observations."""
    return spaces.Box(-1, 1, view.shape, view.dtype.type)


def action_space(game: Game) -> spaces.Discrete:
    """The game's actions, as it numbers them."""
    return spaces.Discrete(game.rules.n_actions)


def ending(episodes: Episodes, i: int) -> dict[str, Any]:
    """Facts of an episode that has ended: its return, why it ended, the actions that lead to its sheet."""
    game, states = episodes.problem.game, episodes.positions.states
    status = int(states["status"][i])
    return {
        "return": float(episodes.returns[i]),
        "status": "illegal action" if status == RUNNING else STATUS_NAMES[status],
        "actions": game.finished_actions(states, i),
    }


def check_render_mode(render_mode: str | None) -> str | None:
    """The render mode; raises InputError if there is no such."""
    if render_mode is not None and render_mode not in RENDER_MODES:
        raise InputError("render_mode", render_mode, f"must be {' or '.join(RENDER_MODES)}, or None")
    return render_mode


def seen(episodes: Episodes, i: int) -> NDArray[Any]:
    """A copy of what is seen of an episode."""
    return np.array(episodes.observations[i])
