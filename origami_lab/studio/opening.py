"""What the studio is opened with: settings of a run, a saved design, or a part, as objects."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.compose import compose_settings, working_directory_importable
from origami_lab.config.instantiate import build_game, build_objective
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.experiment.saved_design import read_saved, saved_designs
from origami_lab.files import expanded

if TYPE_CHECKING:
    from origami_lab.game.game import Game
    from origami_lab.targets.target import Target

MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf")


@dataclass(frozen=True, eq=False)
class Opened:
    """A game with its objective, and a design to begin with."""

    settings: Settings
    game: Game
    objective: Any
    target: Target | None
    actions: tuple[int, ...] | None = None
    """Of a saved design; None where nothing has been played."""
    title: str = ""
    """What it was opened from."""
    own: Path | None = None
    """The folder with options of the user's own."""


def open_design(words: Sequence[str], own: Path | None = None) -> Opened:
    """Open what the command's words mean.

    What exists on disk is a path: the folder of a run (its best design) or of a trial, a FOLD file of ours, or a mesh.
    All else is settings of a run, with the options of the folder ``own`` as with a run's ``--config-dir``.

    Raises
    ------
    InputError
        In one line, as a run with these words would say it.
    """
    paths = [word for word in words if _is_path(word)]
    overrides = [word for word in words if word not in paths]
    for word in overrides:
        if "=" not in word and not word.startswith(("+", "~")):
            raise InputError("studio", word, "must be settings like target=bowl, or a file or folder that exists")
    if len(paths) > 1:
        raise InputError("studio", paths[1], f"is one too many: {paths[0]} is opened already")
    with working_directory_importable():
        if not paths:
            return open_settings(overrides, own)
        path = expanded(paths[0])
        if path.suffix.lower() in MESHES and path.is_file():
            return replace(open_settings(["target=mesh", f"target.path={path}", *overrides], own), title=path.name)
        return replace(_open_saved(path, overrides), own=own)


def open_settings(overrides: Sequence[str], own: Path | None = None) -> Opened:
    """Open a game in which nothing has been played; raises InputError."""
    settings = compose_settings(overrides, own)
    game = build_game(settings)
    target, objective = build_objective(settings)
    return Opened(settings, game, objective, target, title=settings.task, own=own)


def _open_saved(path: Path, overrides: Sequence[str]) -> Opened:
    [file] = saved_designs(path, overrides)
    saved = read_saved(file, overrides)
    assert saved.settings is not None
    settings = replace(saved.settings, output=None, resume=False)
    return Opened(
        settings, saved.game, saved.objective, saved.target, saved.actions, title=os.path.relpath(file.parent)
    )


def _is_path(word: str) -> bool:
    """Whether a word names something on disk; of settings such as target=bowl that would be an odd file."""
    return not word.startswith(("+", "~")) and expanded(word).exists()
