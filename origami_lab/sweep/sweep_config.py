"""What a sweep's YAML file declares: the task, the space that is searched, how trials are chosen and judged."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from origami_lab.config.checked_values import Reader, check_own
from origami_lab.config.compose import compose_settings
from origami_lab.config.node import Node
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.machine import usable_cores
from origami_lab.runs.run_folder import RESULTS
from origami_lab.sweep.search_space import Parameter, grid_size, read_space

KEYS = (
    *("study", "task", "searcher", "budget", "seeds", "space", "trials", "sampler", "pruner", "held_out"),
    *("workers", "storage", "output", "tracking", "config_dir"),
)
ON_THE_COMMAND_LINE = ("sampler", "pruner", "held_out", "tracking")
"""Keys with keys of their own, which the command line takes as KEY.KEY=VALUE, too."""
SAMPLERS = ("tpe", "cmaes", "random", "grid")
LEARNING = ("tpe", "cmaes")
"""Samplers that learn from the trials before."""
PRUNERS = ("median", "wilcoxon", "none")
MOST_TRIALS = 100_000
FEWEST_FOR_WILCOXON = 5
"""Seeds a trial: signs alone of n differences have a probability of 2^-n, and Optuna's test asks for less than 0.1."""


@dataclass(frozen=True)
class Sampler:
    """How the parameters of a trial are chosen."""

    name: str
    seed: int
    startup: int
    """Trials with random parameters before it learns."""


@dataclass(frozen=True)
class Pruner:
    """When a trial is given up before its last seed."""

    name: str
    startup: int
    """Finished trials before any is given up."""
    warmup: int
    """Seeds that every trial plays."""


@dataclass(frozen=True)
class HeldOut:
    """What the best is compared on: seeds that no trial played."""

    seeds: tuple[int, ...]
    budget: int
    against: Mapping[str, tuple[str, ...]]
    """Names of settings to compare with, beside the searcher's defaults, and their overrides."""


@dataclass(frozen=True)
class Declaration:
    """A sweep as declared."""

    study: str
    task: tuple[str, ...]
    """Overrides, as on the command line."""
    searcher: str
    budget: int
    """Interactions a seed."""
    seeds: tuple[int, ...]
    """Those of each trial; its value is the mean return."""
    space: tuple[Parameter, ...]
    trials: int
    sampler: Sampler
    pruner: Pruner
    held_out: HeldOut
    workers: int
    storage: str | None
    """A URL of a database or a journal file; None for a journal in the folder."""
    output: Path | None
    tracking: Node
    config_dir: Path | None
    """A folder with options of the user's own, like --config-dir."""

    @property
    def folder(self) -> Path:
        return self.output if self.output is not None else RESULTS / "sweeps" / self.study

    @property
    def base(self) -> list[str]:
        """The overrides of every trial."""
        return self.base_with(self.budget)

    def base_with(self, budget: int) -> list[str]:
        """The same with another budget."""
        return [*self.task, f"search={self.searcher}", f"budget={budget}"]

    def compose(self, overrides: Sequence[str]) -> Settings:
        """The settings of one experiment; raises InputError in the words of the command."""
        return compose_settings(overrides, self.config_dir)

    @cached_property
    def fixed(self) -> dict[str, Any]:
        """What cannot change while a study goes on: all that decides what a trial finds and which are played."""
        return {
            "task": list(self.task),
            "searcher": self.searcher,
            "budget": self.budget,
            "seeds": format_seeds(self.seeds),
            "space": {parameter.name: parameter.plain() for parameter in self.space},
            "sampler": vars(self.sampler),
            "pruner": vars(self.pruner),
        }


def read_declaration(file: Path, changes: Sequence[str] = ()) -> Declaration:
    """Read a sweep's file.

    Parameters
    ----------
    file
        The YAML file.
    changes
        Values from the command line that win over the file's, e.g. ``trials=10``, ``sampler.seed=1``.

    Raises
    ------
    InputError
        If a key is unknown or missing, or a value is not what it must be; it names the key.
    """
    values = _changed(_load(file), changes)
    read = Reader(values)
    read.only(KEYS)
    for key, example in (
        ("task", "[target=bowl]"),
        ("searcher", "evo"),
        ("space", "{search.elite: {choices: [0, 1]}}"),
    ):
        if values.get(key) is None:
            raise read.refuse(key, f"must be given, e.g. {key}: {example}")
    budget = read.whole("budget", 1, default=100_000)
    seeds = read.seeds("seeds", "0..4")
    space = read_space(read.below("space"))
    sampler = _sampler(read.below("sampler", "name"))
    return Declaration(
        study=_study(read, file),
        task=_task(read),
        searcher=read.word("searcher"),
        budget=budget,
        seeds=seeds,
        space=space,
        trials=_trials(read, sampler, space),
        sampler=sampler,
        pruner=_pruner(read.below("pruner", "name"), len(seeds)),
        held_out=_held_out(read.below("held_out"), seeds, budget),
        workers=usable_cores() if values.get("workers") == "auto" else read.whole("workers", 1, 1024, default=1),
        storage=read.text("storage"),
        output=None if (output := read.text("output")) is None else expanded(output),
        tracking=_tracking(read.below("tracking", "kind")),
        config_dir=_config_dir(read),
    )


def _load(file: Path) -> dict[str, Any]:
    if not file.is_file():
        raise InputError("sweep", file, "must be a file" if file.exists() else "there is no such file")
    try:
        values = OmegaConf.to_container(OmegaConf.create(file.read_text(encoding="utf-8")), resolve=True)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, OmegaConfBaseException) as error:
        mark, lines = getattr(error, "problem_mark", None), str(error).splitlines()
        what = getattr(error, "problem", None) or (lines[0] if lines else type(error).__name__)
        raise InputError(
            "sweep", file, f"cannot be read: {what}" + (f" in line {mark.line + 1}" if mark else "")
        ) from None
    if not isinstance(values, dict) or not values:
        raise InputError("sweep", file, f"must hold keys and values: {', '.join(KEYS)}")
    return {str(key): value for key, value in values.items()}


def _changed(values: dict[str, Any], changes: Sequence[str]) -> dict[str, Any]:
    for change in changes:
        key, equals, text = change.partition("=")
        above, dot, below = key.partition(".")
        if not equals:
            raise InputError("sweep", change, "must be KEY=VALUE, e.g. workers=2")
        if above not in KEYS or (dot and above not in ON_THE_COMMAND_LINE):
            known = ", ".join(name for name in KEYS if name != "space")
            raise InputError(key, text, f"there is no such key of a sweep; must be one of {known}")
        try:
            value = OmegaConf.to_container(OmegaConf.from_dotlist([f"value={text}"]))["value"]  # type: ignore[call-overload, index]
        except Exception:
            raise InputError(key, text, "cannot be read as a value") from None
        if dot:
            now = values.get(above)
            now = {"name" if above != "tracking" else "kind": now} if isinstance(now, str) else now
            values[above] = {**(now if isinstance(now, dict) else {}), below: value}
        else:
            values[key] = value
    return values


def _trials(read: Reader, sampler: Sampler, space: Sequence[Parameter]) -> int:
    if sampler.name != "grid":
        return read.whole("trials", 1, MOST_TRIALS, default=40)
    points = grid_size(space, MOST_TRIALS)
    if points > MOST_TRIALS:
        raise InputError("sampler", "grid", f"the grid must have at most {MOST_TRIALS} points")
    if read.values.get("trials") is None:
        return points
    trials = read.whole("trials", 1, MOST_TRIALS)
    if trials > points:
        raise read.refuse("trials", f"must be at most {points}, the points of the grid")
    return trials


def _study(read: Reader, file: Path) -> str:
    if "study" in read.values:
        return read.word("study")
    try:
        return read.word("study", file.stem)
    except InputError as error:
        raise InputError("sweep", file, f"has a name that cannot be the study's, which {error.expected}") from None


def _task(read: Reader) -> tuple[str, ...]:
    task = read.overrides("task")
    for setting in task:
        check_own("task", setting)
    return task


def _sampler(read: Reader) -> Sampler:
    read.only(("name", "seed", "startup"))
    name = read.choice("name", SAMPLERS, "tpe")
    return Sampler(name, read.whole("seed", 0, 2**32 - 1, default=0), read.whole("startup", 1, 10_000, default=10))


def _pruner(read: Reader, seeds: int) -> Pruner:
    read.only(("name", "startup", "warmup"))
    name = read.choice("name", PRUNERS, "median")
    if name == "wilcoxon" and seeds < FEWEST_FOR_WILCOXON:
        expected = f"must be at least {FEWEST_FOR_WILCOXON} for the pruner wilcoxon: with fewer its test cannot tell"
        raise InputError("seeds", f"{seeds} of them", expected)
    return Pruner(name, read.whole("startup", 1, 10_000, default=5), read.whole("warmup", 1, 10_000, default=1))


def _held_out(read: Reader, played: Sequence[int], budget: int) -> HeldOut:
    read.only(("seeds", "budget", "against"))
    seeds = read.seeds("seeds", "1000..1019")
    both = sorted(set(seeds) & set(played))
    if both:
        raise read.refuse("seeds", f"must hold no seed that trials play ({', '.join(map(str, both[:5]))})")
    if len(seeds) < 2:
        raise read.refuse("seeds", "must hold at least two seeds; twenty or more tell something")
    against = read.below("against")
    for name in against.values:
        if not re.fullmatch(r"[a-z]\w{,29}", str(name)) or name in ("best", "defaults"):
            raise against.refuse(name, "must have a name of letters and digits, other than best and defaults")
    others = {str(name): against.overrides(name) for name in against.values}
    for name, settings in others.items():
        for setting in settings:
            check_own(against.prefix + name, setting, allowed=("search",))
    return HeldOut(seeds, read.whole("budget", 1, default=budget), others)


def _config_dir(read: Reader) -> Path | None:
    text = read.text("config_dir")
    if text is not None and not expanded(text).is_dir():
        raise read.refuse("config_dir", "there is no such folder")
    return None if text is None else expanded(text)


def _tracking(read: Reader) -> Node:
    read.only(("kind", "uri", "experiment"))
    kind = read.choice("kind", ("mlflow", "none"), "mlflow")
    return {"kind": kind, "uri": read.text("uri"), "experiment": read.text("experiment")}
