"""The settings of an experiment, read from a composed configuration and checked before any work starts."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from origami_lab.addresses import keep
from origami_lab.checks import Choice, Flag, Folder, Number, Section, Whole, Word, check
from origami_lab.config.amounts import Amount, Millimetres, Paper, Reach
from origami_lab.config.checked_values import Packages, Part, ReportOrder, Seeds, Tracking
from origami_lab.config.earlier_versions import as_of_today
from origami_lab.config.mesh_axis import as_it_was, resolved_up, with_resolved_up
from origami_lab.config.node import Node, check_format, flatten
from origami_lab.config.open_settings import settle_distance
from origami_lab.config.option_files import own_roots, read_options
from origami_lab.config.paper import settle_cell
from origami_lab.config.part_settings import with_part_settings
from origami_lab.config.stages import Budget, Minutes, Stage
from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.game.rule_settings import KEYS as RULE_KEYS
from origami_lab.game.rule_settings import RuleSettings, checked_rules
from origami_lab.game.start_file import is_own_pattern
from origami_lab.machine import WORKER_BYTES, physical_memory, usable_cores
from origami_lab.text import nearest

POSITIONS = 8
"""Positions that a tree search begins with, and the scratch ones."""


@dataclass(frozen=True)
class Settings:
    """One experiment: what is played, what is searched, how long, and where the results go."""

    task: Annotated[str, Word()]
    """Name of the target, or of the objective where there is no target."""
    method: Annotated[str, Word()]
    """Name of the searcher."""
    game: RuleSettings
    start: Annotated[Node, Part("start")]
    target: Annotated[Node | None, Part("target")]
    objective: Annotated[Node, Part("objective")]
    search: Annotated[Node, Part("search")]
    """The parts with a ``_target_``."""
    tracking: Annotated[Tracking, Section()]
    report_order: Annotated[ReportOrder, Section()]
    seeds: Annotated[tuple[int, ...], Seeds()]
    seeds_given: bool
    """Whether they were asked for; else a resumed run keeps to its own."""
    budget: Budget
    """Interactions a trial."""
    certify: Annotated[bool, Choice({"improvements": True, "none": False})]
    workers: Annotated[int, Whole(1, 10**9, "must be auto or a number of processes from 1")]
    """Trials at a time."""
    files: Annotated[str, Choice(("all", "designs"))]
    """``all``, or ``designs``: a trial writes no pictures, motion, viewer or certificate."""
    polish: Annotated[int | None, Whole(0, 10**9, "must be a number of steps, or null")]
    """Designs that the polish of a trial's best design lays; None or 0 for no polish."""
    polish_seconds: Annotated[float | None, Number(0, math.inf, "must be seconds above 0, or null", between=True)]
    """Longest that it may take; None for no limit."""
    polish_simplify: Annotated[float | None, Number(0, math.inf, "must be board cells from 0, or null")]
    """What may be lost for a simpler design at its end; None for nothing to be taken out."""
    objective_seconds: Annotated[float | None, Number(0, math.inf, "must be seconds above 0, or null", between=True)]
    """Longest that one call of a user's objective may take; None for no limit."""
    output: Annotated[Path | None, Folder("must be a folder, or null for a fresh one below results/")]
    """The run folder; None for a fresh one below results/."""
    resume: Annotated[bool, Flag()]
    verbosity: Annotated[str, Choice(("quiet", "normal", "verbose"))]
    config: Node
    """The whole configuration, resolved, as it is written to config.yaml."""
    target_return: Annotated[Amount | None, Reach()] = None
    """A trial ends when it has reached this; None for none."""
    minutes: Minutes = None
    """Longest that the search of a trial may take; None for no limit."""
    stages: tuple[Annotated[Stage, Section()], ...] = ()
    """What a trial was given before, where the run has gone on."""
    cell: Annotated[float | None, Millimetres()] = None
    """Millimetres of a board cell on paper; None where nobody says."""
    sheet: Annotated[tuple[float, float] | None, Paper()] = None
    """Width and height of what is cut from, in millimetres."""
    thickness: Annotated[float | None, Millimetres()] = None
    """Of what is folded, in millimetres."""
    open_page: Annotated[bool, Flag()] = False
    """Whether the run's page is opened in a browser once it begins."""
    trust: Annotated[tuple[str, ...], Packages()] = ()
    """Installed packages whose code a ``_target_`` may name; never in a file."""
    left_open: tuple[str, ...] = ()
    """Settings that were left to us: a run that goes on keeps what they were."""
    part_lines: tuple[str, ...] = ()
    """What is to be said of the part by which settings were chosen, one line each."""

    @property
    def stage(self) -> Stage:
        """The last stage, which is the present one."""
        return Stage(self.budget, self.target_return, self.minutes)


def read_settings(config: DictConfig) -> Settings:
    """Check a composed configuration and turn it into :class:`Settings`.

    The target, the objective and the searcher check their own domains when they are built.

    Raises
    ------
    InputError
        If a value is missing, of the wrong kind or out of range; it names the key.
    """
    values = as_of_today(_plain(config))
    check_format(values)
    _check_keys(values)
    values, part_lines = with_part_settings(_without_secrets(values))
    values, left_open = settle_distance(values)
    game = _rules(values)
    values = settle_cell(values, game, fits_part=bool(part_lines))
    checked = {**values, "game": game, "config": values, "left_open": left_open}
    checked["seeds_given"] = checked.pop("seed", 0) is not None
    if "seed" in values:
        checked["seeds"] = values["seed"] if checked["seeds_given"] else 0
    if values.get("workers") == "auto":  # one a core
        checked["workers"] = usable_cores()
    checked["open_page"] = checked.pop("open", False)
    settings = check(Settings, checked, {"seeds": "seed", "open_page": "open"})
    if settings.target is None and "target" in settings.objective:
        raise InputError("target", "none", f"this objective needs a target: {_targets()}")
    written = with_resolved_up(_with_absolute_paths({key: value for key, value in values.items() if key != "trust"}))
    target = None if settings.target is None else as_it_was(resolved_up(settings.target))
    objective = {key: value for key, value in settings.objective.items() if key != "target"}
    task = task_name(settings.task, settings.target)
    return replace(settings, task=task, target=target, objective=objective, config=written, part_lines=part_lines)


def _without_secrets(values: dict[str, Any]) -> dict[str, Any]:
    """The configuration as it may be written down; the store's whole address is noted for when it is opened."""
    tracking = values.get("tracking")
    if isinstance(tracking, Mapping) and isinstance(tracking.get("uri"), str):
        return {**values, "tracking": {**tracking, "uri": keep(tracking["uri"])}}
    return values


def _check_keys(values: Node) -> None:
    """Raise InputError for a key that is none of ours: nothing would read it."""
    known = own_roots()
    rules = set(RULE_KEYS.values()) | {"symmetry.name"}
    for key, value in values.items():
        if key not in known:
            raise InputError(key, value, "there is no such key" + nearest(key, known))
        if key in ("board", "symmetry", "driving_angle") and isinstance(value, Mapping):
            for inner in flatten(value, f"{key}."):
                if inner not in rules:
                    raise InputError(inner, flatten(values)[inner], "there is no such key" + nearest(inner, rules))


def _rules(values: Node) -> RuleSettings:
    """The settings of the game, from where a configuration has them."""
    symmetry = values.get("symmetry")
    flat = flatten({**values, **({"symmetry": symmetry.get("name")} if isinstance(symmetry, Mapping) else {})})
    return checked_rules({name: flat[key] for name, key in RULE_KEYS.items() if key in flat})


def _targets() -> str:
    """The options of target that make one, with what must be given beside them."""
    found = []
    for name, content in read_options("target").items():
        if content.get("target") is not None:
            missing = [key for key, value in flatten(content).items() if value == "???"]
            found.append(" ".join([name, *(f"{key}={'FILE' if key.endswith('path') else '...'}" for key in missing)]))
    found.sort(key=lambda words: (" " in words, words))
    return "target=" + " or ".join(filter(None, [", ".join(found[:-1]), found[-1]]))


def task_name(name: str, target: Any) -> str:
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
        examples = (
            *("target.path=part.stl", "start.path=results/bowl/bfts/TIME/seed=3"),
            "start.corners=[[2,0],[0,2],[-2,0],[0,-2]]",
        )
        example = next((example for example in examples if key.endswith(example.partition("=")[0])), None)
        hint = f"must be given: {example}" if example else "must be given, has no default"
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
        known = {shown: getattr(game, name) for name, shown in names.items()}
        given = ", ".join(f"{shown}={value}" for shown, value in known.items() if value is not None)
        raise InputError(
            "capacity",
            "default" if game.capacity is None else game.capacity,
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


def _state_bytes(game: RuleSettings) -> int:
    """Bytes of one game state, about: by the vertices it has room for and the driving angles."""
    vertices = 320 if game.capacity is None else game.capacity
    return int(vertices * (300 + 120 * game.driving_angle_count))
