"""A saved design with all that it was made in and for: the game, the objective, and where its files are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from omegaconf import DictConfig, OmegaConf

from origami_lab.config.compose import compose_settings
from origami_lab.config.dotted_path import locate
from origami_lab.config.earlier_versions import game_of_today
from origami_lab.config.instantiate import build_game, build_objective
from origami_lab.config.physical_size import thickness_in_cells
from origami_lab.config.settings import Settings, read_settings
from origami_lab.drawing.scene import TargetSurface
from origami_lab.errors import InputError
from origami_lab.file_names import ACTIONS, BEST, CONFIG, SEED, trial_folder
from origami_lab.files import expanded, read_json, require_no_link
from origami_lab.fold_format.reader import read_fold
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import NO_DESIGN

if TYPE_CHECKING:
    from origami_lab.game.game import Game
    from origami_lab.targets.target import Target

SAME_ANGLE = 1e-6
"""Degrees within which a driving angle that a file names is one of the game's."""


@dataclass(frozen=True, eq=False)
class SavedDesign:
    """A design that can be worked on."""

    game: Game
    objective: Any
    target: Target | None
    actions: tuple[int, ...]
    angle: int
    """Index of its driving angle among the game's."""
    facts: Mapping[str, object]
    """What its file says of it: task, search, seed, return …"""
    file: Path
    """Its FOLD file."""
    run: Path | None = None
    """The folder of the run whose trial's best design it is; None for any other file."""
    thickness: float = 0.0
    """Of what is folded, as its run says, in board cells."""
    settings: Settings | None = None
    """Those that its game and objective were made from, where they were read here."""

    @property
    def seed(self) -> int:
        """The seed of its trial."""
        return int(self.file.parent.name.removeprefix(SEED))

    @property
    def surface(self) -> TargetSurface | None:
        """The target, for pictures."""
        return None if self.target is None else TargetSurface(self.target.vertices, self.target.faces)

    def stem(self, what: str) -> str:
        """How the names of files about it begin: ``what`` for a trial's best design, else with the name of its file
        before."""
        return what if self.file.name == BEST else f"{self.file.name.removesuffix('.fold')}.{what}"


def saved_designs(path: Path, overrides: Sequence[str] = (), best: int = 1) -> list[Path]:
    """The designs that a path means: the FOLD file itself, a trial's, or the best few of a run, best first.

    Raises
    ------
    InputError
        If there is none, or ``best`` is not at least 1.
    """
    if isinstance(best, bool) or not isinstance(best, int) or best < 1:
        raise InputError("best", best, "must be a whole number from 1: how many of a run's designs")
    path = expanded(path)
    if path.is_dir() and (path / CONFIG).is_file():
        if _trusted(overrides)[0]:
            raise InputError("settings", " ".join(overrides), "are the run's own; only a FOLD file can be given some")
        rows = [row for row in RunFolder(path).rows().values() if row.outcome != NO_DESIGN and row.return_ is not None]
        ranked = sorted(rows, key=lambda row: (-row["return"], row.seed))
        found = [trial_folder(path, row.seed) / BEST for row in ranked[:best]]
        if not found:
            raise InputError("path", path, "no trial of this run has found a design")
        for file in found:
            try:
                require_no_link(path, file.relative_to(path))
            except OSError as error:
                raise InputError("path", path, f"cannot be used: {error.strerror}") from error
        return found
    if path.is_dir():
        path = path / BEST
    elif path.name == ACTIONS:
        path = path.with_name(BEST)
    if not path.is_file():
        raise InputError("path", path, "must be the folder of a run or of a trial (seed=N), or a FOLD file of ours")
    return [path]


def read_saved(file: Path, overrides: Sequence[str] = ()) -> SavedDesign:
    """A saved design from its FOLD file.

    Parameters
    ----------
    file
        A trial's ``best.fold``, or any FOLD file that has our actions in it.
    overrides
        Settings of the game and the objective, such as ``target=bowl``, for a file that is in no run folder; without
        any, those of its task.

    Raises
    ------
    InputError
        If it is not one of ours, or the game does not allow its actions.
    """
    trial = (file.parent / ACTIONS).is_file() and (file.parent.parent / CONFIG).is_file()
    if file.name == BEST and trial:
        others, trust = _trusted(overrides)
        if others:
            raise InputError("settings", " ".join(others), "are the run's own; only a FOLD file can be given some")
        return _of_trial(file, trust)
    fold = read_fold(file)
    if not fold.actions:
        raise InputError(str(file), "no actions", "must be a FOLD file of a search, which says how it was played")
    task = str(fold.metadata.get("task", ""))
    settings = _settings_for(file, task, overrides)
    game = build_game(settings)
    target, objective = build_objective(settings)
    board = fold.metadata.get("board", game.board_fact)
    if board != game.board_fact:
        sides = board if isinstance(board, list) and len(board) == 2 else [board, board]
        for key, side, own in zip(("board.width", "board.height"), game.board, sides, strict=True):
            if side != own:
                key = key if isinstance(board, list) else "board.size"
                raise InputError(key, side, f"must be {own}, as {file.name} says")
    _check_playable(game, fold.actions, file)
    angle = _angle_of(game, fold.metadata, file)
    return SavedDesign(game, objective, target, fold.actions, angle, fold.metadata, file, settings=settings)


def _trusted(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """Settings but for the one that names packages to trust, and that one, which a run's own do not have."""
    trust = [text for text in overrides if text.startswith("trust=")]
    return [text for text in overrides if text not in trust], trust


def _of_trial(file: Path, trust: Sequence[str]) -> SavedDesign:
    from origami_lab.game.game import Game

    trial = file.parent
    run = RunFolder(trial.parent)
    config = OmegaConf.merge(OmegaConf.create(run.config()), OmegaConf.from_dotlist(list(trust)))
    assert isinstance(config, DictConfig)
    settings = read_settings(config)
    target, objective = build_objective(settings)
    if target is not None:
        run.check_target(target)
    with _readable(trial / ACTIONS):
        saved = read_json(trial / ACTIONS)
        given, start = game_of_today(saved["game"]), dict(saved["game"]["start"])
        given["start"] = locate("start", start.pop("_target_"), settings.trust)(**start)
        game = Game(**given)
    thickness = thickness_in_cells(settings, target)
    return replace(saved_in(trial, game, objective, target), thickness=thickness, settings=settings)


def saved_in(trial: Path, game: Game, objective: Any, target: Target | None) -> SavedDesign:
    """The best design in a trial's folder, which was made in a game and for an objective that are there already.

    Raises
    ------
    InputError
        If its files cannot be read, the trial has found none, or the game does not allow its actions.
    """
    file = trial / BEST
    with _readable(trial / ACTIONS):
        saved = read_json(trial / ACTIONS)
        actions, angle = tuple(int(action) for action in saved["actions"]), int(saved["angle"])
        run = trial.parent if trial_folder(trial.parent, int(saved["seed"])) == trial else None
    if angle < 0:
        raise InputError("design", str(trial), "this trial has found none")
    _check_playable(game, actions, file)
    return SavedDesign(game, objective, target, actions, angle, read_fold(file).metadata, file, run)


@contextmanager
def _readable(file: Path) -> Iterator[None]:
    try:
        yield
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(str(file), type(error).__name__, f"cannot be read: {error}") from error


def _settings_for(file: Path, task: str, overrides: Sequence[str]) -> Settings:
    others, trust = _trusted(overrides)
    if others:
        return compose_settings(overrides)
    hint = "which game and objective is it from? Give its settings, such as target=bowl"
    for guess in (f"+experiment=paper/{task}", f"target={task}"):
        try:
            return compose_settings([guess, *trust])
        except InputError:
            continue
    raise InputError(str(file), f"task {task or 'unknown'}", hint)


def _angle_of(game: Game, facts: Mapping[str, object], file: Path) -> int:
    named = facts.get("driving_angle")
    if isinstance(named, int | float):
        angles = np.degrees(game.angles)
        nearest = int(np.argmin(np.abs(angles - named)))
        if math.isclose(angles[nearest], named, abs_tol=SAME_ANGLE):
            return nearest
    raise InputError(str(file), f"driving angle {named}", "must be one of the game's driving angles, in degrees")


def _check_playable(game: Game, actions: tuple[int, ...], file: Path) -> None:
    try:
        game.replay(actions)
    except ValueError as error:
        raise InputError(str(file), "its actions", f"cannot be played in this game: {error}") from error
