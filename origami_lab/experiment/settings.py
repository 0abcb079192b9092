"""The settings of an experiment, read from a composed configuration and checked before any work starts."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from origami_lab.errors import InputError
from origami_lab.experiment.seeds import parse_seeds

LARGEST_BOARD = 201
"""Widest board, in points: wider ones cost memory without a use (the paper plays on 9 to 25)."""
SYMMETRIES = ("none", "x", "y", "xy", "xyd")

Node = Mapping[str, Any]
"""A part of the configuration as plain Python values."""


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
    budget: int
    """Interactions a trial."""
    certify: bool
    workers: int
    """Trials at a time."""
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
    values = _plain(config)
    read = _Reader(values)
    half_turn = "must lie between 0 and 180 degrees, both excluded"
    game = {
        "board_size": _board_size(read),
        "symmetry": read.choice("symmetry.name", SYMMETRIES, shown="symmetry"),
        "max_crease_length": read.number(
            "max_crease_length", 0, math.inf, "must be at least 1 (a board cell), or null"
        ),
        "source_action": read.flag("source_action"),
        "driving_angle_max": read.number("driving_angle.max", 0, 180, half_turn, required=True),
        "driving_angle_count": read.integer("driving_angle.count", 1, 100),
        "driving_angle_fixed": read.number("driving_angle.fixed", 0, 180, half_turn + ", or null"),
        "stuck": read.choice("stuck", ("score", "penalise")),
        "capacity": read.optional_integer("capacity", 8, 100_000),
    }
    seeds = parse_seeds(values.get("seed"))
    start, objective, search = (read.part(name) for name in ("start", "objective", "search"))
    if "distance" in objective:
        read.choice("objective.distance", ("vertex", "surface", "sampled"))
    target = values.get("target")
    if target is not None:
        target = read.part("target")
    elif "target" in objective:
        raise InputError(
            "target",
            "none",
            "this objective needs a target: target=bowl, cube, pyramid or mesh target.path=FILE",
        )
    output = values.get("output")
    return Settings(
        task=_task(read.name("task"), target),
        method=read.name("method"),
        game=game,
        start=start,
        target=target,
        objective={key: value for key, value in objective.items() if key != "target"},
        search=search,
        tracking=_tracking(read),
        seeds=seeds,
        budget=read.integer("budget", 1, 10**12),
        certify=read.choice("certify", ("improvements", "none")) == "improvements",
        workers=_workers(values.get("workers"), len(seeds)),
        objective_seconds=read.number("objective_seconds", 0, math.inf, "must be seconds above 0, or null"),
        output=None if output is None else Path(str(output)).expanduser(),
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
        hint = "must be given: target.path=part.stl" if key.endswith("target.path") else "must be given, has no default"
        raise InputError(key, "(nothing)", hint) from error
    except OmegaConfBaseException as error:
        message = str(error).splitlines()[0]
        raise InputError(error.full_key or "configuration", "?", f"cannot be resolved: {message}") from error
    assert isinstance(container, dict)
    return {str(key): value for key, value in container.items()}


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
    return tracking


def _workers(value: object, trials: int) -> int:
    """How many trials run at a time: never more than there are."""
    if value == "auto":
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(cores, trials)
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise InputError("workers", value, "must be auto or a number of processes from 1")
    return min(value, trials)


class _Reader:
    """Checked access to the values by their dotted key, as the user writes it."""

    def __init__(self, values: Node) -> None:
        self.values = values

    def get(self, key: str) -> Any:
        value: Any = self.values
        for name in key.split("."):
            if not isinstance(value, Mapping) or name not in value:
                raise InputError(key, "?", "is missing from the configuration")
            value = value[name]
        return value

    def integer(self, key: str, low: int, high: int, expected: str | None = None) -> int:
        value = self.get(key)
        # 1e6 is a float to YAML, and what people write for a budget
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            limit = f"from {low}" if high >= 10**9 else f"from {low} to {high}"
            raise InputError(key, value, expected or f"must be a whole number {limit}")
        return value

    def optional_integer(self, key: str, low: int, high: int) -> int | None:
        if self.get(key) is None:
            return None
        return self.integer(key, low, high, f"must be a whole number from {low} to {high}, or null")

    def number(self, key: str, low: float, high: float, expected: str, required: bool = False) -> float | None:
        """A number strictly between the bounds; None if it may be left out."""
        value = self.get(key)
        if value is None and not required:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or not low < value < high:
            raise InputError(key, value, expected)
        return float(value)

    def name(self, key: str) -> str:
        """A word that is also fit to be the name of a folder."""
        value = self.get(key)
        if not isinstance(value, str) or not re.fullmatch(r"\w[\w.+-]*", value):
            raise InputError(key, value, "must be a word of letters, digits, '.', '_', '+' and '-'")
        return value

    def flag(self, key: str) -> bool:
        value = self.get(key)
        if not isinstance(value, bool):
            raise InputError(key, value, "must be true or false")
        return value

    def choice(self, key: str, options: tuple[str, ...], shown: str | None = None) -> str:
        value = self.get(key)
        if value not in options:
            raise InputError(shown or key, value, f"must be one of {', '.join(options)}")
        return str(value)

    def part(self, key: str) -> dict[str, Any]:
        value = self.get(key)
        if not isinstance(value, Mapping) or not isinstance(value.get("_target_"), str):
            raise InputError(key, value, "must be one of its options, or name a class by _target_")
        return {str(name): item for name, item in value.items()}
