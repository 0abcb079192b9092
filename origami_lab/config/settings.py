"""The settings of an experiment, read from a composed configuration and checked before any work starts."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from origami_lab.config.checked_values import _Reader
from origami_lab.config.earlier_versions import as_of_today
from origami_lab.config.mesh_axis import as_it_was, resolved_up, with_resolved_up
from origami_lab.config.node import Node, check_format
from origami_lab.config.seeds import parse_seeds
from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.game.start_file import is_own_pattern
from origami_lab.machine import WORKER_BYTES, physical_memory, usable_cores

LARGEST_BOARD = 201
"""Widest board, in points: wider ones cost memory without a use (the paper plays on 9 to 25)."""
POSITIONS = 8
"""Positions that a tree search begins with, and the scratch ones."""
SYMMETRIES = ("none", "x", "y", "xy", "xyd")


@dataclass(frozen=True)
class Settings:
    """One experiment: what is played, what is searched, how long, and where the results go."""

    task: str
    """Name of the target, or of the objective where there is no target."""
    method: str
    """Name of the searcher."""
    game: Node
    """Keyword arguments of the game but for ``start``."""
    start: Node
    target: Node | None
    objective: Node
    search: Node
    tracking: Node
    """The parts with a ``_target_``, and the tracker's options."""
    seeds: tuple[int, ...]
    seeds_given: bool
    """Whether they were asked for; else a resumed run keeps to its own."""
    budget: int
    """Interactions a trial."""
    certify: bool
    workers: int
    """Trials at a time."""
    files: str
    """``all``, or ``designs``: a trial writes no pictures, motion, viewer or certificate."""
    objective_seconds: float | None
    """Longest that one call of a user's objective may take; None for no limit."""
    output: Path | None
    """The run folder; None for a fresh one below results/."""
    resume: bool
    verbosity: str
    config: Node
    """The whole configuration, resolved, as it is written to config.yaml."""


def read_settings(config: DictConfig) -> Settings:
    """Check a composed configuration and turn it into :class:`Settings`.

    The game, the target and the objective check their own domains when they are built.

    Raises
    ------
    InputError
        If a value is missing, of the wrong kind or out of range; it names the key.
    """
    values = as_of_today(_plain(config))
    check_format(values)
    read = _Reader(values)
    half_turn = "must lie between 0 and 180 degrees, both excluded"
    game = {
        "board_size": _board_size(read),
        "symmetry": read.choice("symmetry.name", SYMMETRIES, shown="symmetry"),
        "max_crease_length": read.number(
            "max_crease_length", 0, 1e6, "must be at least 1 (a board cell), or null for no limit"
        ),
        "source_action": read.flag("source_action"),
        "driving_angle_max": read.number("driving_angle.max", 0, 180, half_turn, required=True),
        "driving_angle_count": read.integer("driving_angle.count", 1, 100),
        "driving_angle_fixed": "start"
        if read.get("driving_angle.fixed") == "start"
        else read.number("driving_angle.fixed", 0, 180, half_turn + ", or be start or null"),
        "stuck": read.choice("stuck", ("score", "penalise")),
        "capacity": read.optional_integer("capacity", 8, 100_000),
    }
    seed = read.get("seed")
    start, objective, search = (read.part(name) for name in ("start", "objective", "search"))
    if "distance" in objective:
        read.choice("objective.distance", ("vertex", "surface", "sampled"))
    values = with_resolved_up(_with_absolute_paths(values))
    target: Node | None = values.get("target")
    if target is not None:
        target = as_it_was(resolved_up(read.part("target")))
    elif "target" in objective:
        raise InputError(
            "target",
            "none",
            "this objective needs a target: target=bowl, cube, face, pyramid or mesh target.path=FILE",
        )
    return Settings(
        task=_task(read.name("task"), target),
        method=read.name("method"),
        game=game,
        start=start,
        target=target,
        objective={key: value for key, value in objective.items() if key != "target"},
        search=search,
        tracking=_tracking(read),
        seeds=parse_seeds(0 if seed is None else seed),
        seeds_given=seed is not None,
        budget=read.integer("budget", 1, 10**12),
        certify=read.choice("certify", ("improvements", "none")) == "improvements",
        workers=_workers(read),
        files=read.choice("files", ("all", "designs")),
        objective_seconds=read.number("objective_seconds", 0, math.inf, "must be seconds above 0, or null"),
        output=_output(read.get("output")),
        resume=read.flag("resume"),
        verbosity=read.choice("verbosity", ("quiet", "normal", "verbose")),
        config=values,
    )


def _task(name: str, target: Any) -> str:
    """Meshes are told apart by the names of their files."""
    path = target.get("path") if isinstance(target, dict) else None
    stem = Path(str(path)).stem if path else ""
    return stem if name == "mesh" and re.fullmatch(r"[\w.-]+", stem) else name


def _plain(config: DictConfig) -> dict[str, Any]:
    """Resolve every interpolation; what cannot be resolved is the user's error."""
    try:
        container = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    except MissingMandatoryValue as error:
        key = str(error.full_key or "configuration")
        examples = {"target": "target.path=part.stl", "start": "start.path=results/bowl/bfts/TIME/seed=3"}
        group = next((group for group in examples if key.endswith(f"{group}.path")), None)
        hint = f"must be given: {examples[group]}" if group else "must be given, has no default"
        raise InputError(key, "(nothing)", hint) from error
    except OmegaConfBaseException as error:
        message = str(error).splitlines()[0]
        raise InputError(error.full_key or "configuration", "?", f"cannot be resolved: {message}") from error
    assert isinstance(container, dict)
    return {str(key): value for key, value in container.items()}


def _with_absolute_paths(values: Node) -> dict[str, Any]:
    """The configuration with files that are found again when config.yaml is run from another folder."""

    def absolute(part: Any) -> Any:
        path = part.get("path") if isinstance(part, Mapping) else None
        # what a path is to a part of the user's own, it alone knows
        ours = isinstance(part, Mapping) and str(part.get("_target_")).startswith("origami_lab.")
        if not ours or not isinstance(path, str) or not path.strip():
            return part
        return {**part, "path": str(expanded(path).absolute())}

    found = {**values, "target": absolute(values.get("target"))}
    if not is_own_pattern(values["start"].get("path")):
        found["start"] = absolute(values["start"])
    if "target" in found["objective"]:  # the same one, resolved
        found["objective"] = {**found["objective"], "target": absolute(found["objective"]["target"])}
    return found


def _board_size(read: _Reader) -> int:
    expected = f"must be an odd number of points from 5 to {LARGEST_BOARD}"
    size = read.integer("board.size", 5, LARGEST_BOARD, expected)
    if size % 2 == 0:
        raise InputError("board.size", size, f"{expected}, e.g. {size - 1} or {size + 1}")
    return size


def _tracking(read: _Reader) -> Node:
    tracking = read.get("tracking")
    if not isinstance(tracking, Mapping) or tracking.get("kind") not in ("mlflow", "none"):
        raise InputError("tracking", tracking, "must be mlflow or none")
    for key, expected in (("uri", "an MLflow URI"), ("experiment", "the name of an MLflow experiment")):
        value = tracking.get(key)
        words = (str,) if key == "uri" else (str, int, float)
        if value is not None and (isinstance(value, bool) or not isinstance(value, words) or not str(value).strip()):
            raise InputError(f"tracking.{key}", value, f"must be {expected}, or null")
    return tracking


def _output(value: object) -> Path | None:
    if value is None:
        return None
    # a number is a name, too: output=5
    if isinstance(value, bool) or not isinstance(value, str | int | float) or not str(value).strip():
        raise InputError("output", value, "must be a folder, or null for a fresh one below results/")
    path = str(value)
    if "\0" in path:
        raise InputError("output", value, "must be a folder; its name must not hold a null character")
    return expanded(path)


def _workers(read: _Reader) -> int:
    """How many trials run at a time, as asked for: one a core, or a number."""
    if read.get("workers") != "auto":
        return read.integer("workers", 1, 10**9, "must be auto or a number of processes from 1")
    return usable_cores()


def fit_workers(settings: Settings) -> Settings:
    """The settings with as many workers as this machine's memory has room for.

    Raises
    ------
    InputError
        If a single one does not fit, or fewer than were asked for by their number.
    """
    game, trials = settings.game, len(settings.seeds)
    memory, each = physical_memory(), WORKER_BYTES + POSITIONS * _state_bytes(game)
    room = memory // each
    if room < 1:
        names = {"capacity": "capacity", "driving_angle_count": "driving_angle.count"}
        given = ", ".join(f"{name}={game[key]}" for key, name in names.items() if game[key] is not None)
        raise InputError(
            "capacity",
            "default" if game["capacity"] is None else game["capacity"],
            f"a search with {given} takes {each / 2**30:.0f} GB and this machine has {memory / 2**30:.0f} GB:"
            " choose a smaller capacity or driving_angle.count",
        )
    if settings.config["workers"] != "auto" and min(settings.workers, trials) > room:
        raise InputError(
            "workers",
            settings.workers,
            f"must be at most {room}: each takes about {each / 2**30:.1f} GB of this machine's {memory / 2**30:.0f} GB",
        )
    return replace(settings, workers=min(settings.workers, room))


def _state_bytes(game: Node) -> int:
    """Bytes of one game state, about: by the vertices it has room for and the driving angles."""
    vertices = 320 if game["capacity"] is None else game["capacity"]
    return int(vertices * (300 + 120 * game["driving_angle_count"]))
