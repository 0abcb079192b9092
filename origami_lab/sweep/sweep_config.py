"""A sweep's declaration in YAML: the task, the space that is searched, how trials are chosen and judged."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import yaml  # type: ignore[import-untyped]
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from pydantic import BeforeValidator

from origami_lab.addresses import keep
from origami_lab.checks import REFUSED, Choice, ExistingFolder, Folder, Section, Text, Whole, Word, check, wrong
from origami_lab.config.bounded_yaml import yaml_text
from origami_lab.config.checked_files import check_interpolations
from origami_lab.config.checked_values import Overrides, Packages, Seeds, Tracking
from origami_lab.config.compose import compose_settings
from origami_lab.config.node import Node
from origami_lab.config.seeds import format_seeds, parse_seeds
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.machine import usable_cores
from origami_lab.runs.run_folder import RESULTS
from origami_lab.sweep.search_space import Parameter, Space, grid_size

ON_THE_COMMAND_LINE = ("sampler", "pruner", "held_out", "tracking")
"""Keys with keys of their own, which the command line takes as KEY.KEY=VALUE, too."""
LEARNING = ("tpe", "cmaes")
"""Samplers that learn from the trials before."""
TRACKED = Tracking()
_FILE = Section(hidden=("trust",))
GONE_PRUNER = "wilcoxon"
"""A pruner of version 0.1.0: studies that were begun with it stay readable, and go on without."""
MOST_TRIALS = 100_000


class _PrunerName(Choice):
    def message(self, value: Any) -> str:
        gone = "; studies that were begun with it go on with pruner=none" * (value == GONE_PRUNER)
        return f"{super().message(value)}{gone}"


def _names(value: Any) -> Any:
    """The mapping of names to settings that the best is compared with."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise wrong("must be a mapping of keys to values")
    for name in value:
        if not re.fullmatch(r"[a-z]\w{,29}", str(name)) or name in ("best", "defaults"):
            raise wrong("must have a name of letters and digits, other than best and defaults", value[name], str(name))
    return value


@dataclass(frozen=True)
class Sampler:
    """How the parameters of a trial are chosen."""

    name: Annotated[str, Choice(("tpe", "cmaes", "random", "grid"))] = "tpe"
    seed: Annotated[int, Whole(0, 2**32 - 1)] = 0
    startup: Annotated[int, Whole(1, 10_000)] = 10
    """Trials with random parameters before it learns."""


@dataclass(frozen=True)
class Pruner:
    """When a trial is given up before its last seed."""

    name: Annotated[str, _PrunerName(("median", "none"))] = "median"
    startup: Annotated[int, Whole(1, 10_000)] = 5
    """Finished trials before any is given up."""
    warmup: Annotated[int, Whole(1, 10_000)] = 1
    """Seeds that every trial plays."""


@dataclass(frozen=True)
class HeldOut:
    """The held-out comparison of the best, on seeds that no trial played."""

    seeds: Annotated[tuple[int, ...], Seeds()] = parse_seeds("1000..1019")
    budget: Annotated[int, Whole(1, 10**12)] = 0
    """Interactions a seed; by default as many as trials have."""
    against: Annotated[Mapping[str, Annotated[tuple[str, ...], Overrides("search")]], BeforeValidator(_names)] = field(
        default_factory=dict
    )
    """Names of settings to compare with, beside the searcher's defaults, and their overrides."""


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """A sweep as declared: the keys of its file."""

    study: Annotated[str, Word()]
    task: Annotated[tuple[str, ...], Overrides("files")]
    """Overrides, as on the command line."""
    searcher: Annotated[str, Word()]
    budget: Annotated[int, Whole(1, 10**12)] = 100_000
    """Interactions a seed."""
    seeds: Annotated[tuple[int, ...], Seeds()] = parse_seeds("0..4")
    """Seeds of each trial; its value is their mean return."""
    space: Annotated[tuple[Parameter, ...], Space()]
    trials: Annotated[int, Whole(1, MOST_TRIALS)] = 40
    sampler: Annotated[Sampler, Section("name")] = Sampler()
    pruner: Annotated[Pruner, Section("name")] = Pruner()
    held_out: Annotated[HeldOut, Section()] = HeldOut()
    workers: Annotated[int, Whole(1, 1024)] = 1
    storage: Annotated[str | None, Text()] = None
    """A URL of a database or a journal file; None for a journal in the folder."""
    output: Annotated[Path | None, Folder()] = None
    tracking: Annotated[Tracking, Section("kind")] = TRACKED
    config_dir: Annotated[Path | None, ExistingFolder()] = None
    """A folder with options of the user's own, like --config-dir."""
    trust: Annotated[tuple[str, ...], Packages()] = ()
    """Installed packages whose code a ``_target_`` may name; on the command line only."""

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
        trust = [f"trust=[{','.join(self.trust)}]"] if self.trust else []
        return compose_settings([*overrides, *trust], self.config_dir)

    @cached_property
    def fixed(self) -> dict[str, Any]:
        """Settings that cannot change while a study goes on: all that decides what is played, and what that finds."""
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
    values = _changed(_load(file), [change for change in changes if not change.startswith("trust=")])
    for place, key in ((values, "storage"), (values.get("tracking"), "uri")):
        if isinstance(place, dict) and isinstance(place.get(key), str):
            place[key] = keep(place[key])
    trusted = [change for change in changes if change.startswith("trust=")]
    trust = Packages().take(_changed({}, trusted)["trust"]) if trusted else ()
    if trust is REFUSED:
        raise InputError("trust", trusted[-1].partition("=")[2], Packages.expected)
    for key, example in (
        ("task", "[target=bowl]"),
        ("searcher", "evo"),
        ("space", "{search.elite: {choices: [0, 1]}}"),
    ):
        if values.get(key) is None:
            raise InputError(key, values.get(key, "(nothing)"), f"must be given, e.g. {key}: {example}")
    if "study" not in values and Word().take(file.stem) is REFUSED:
        raise InputError("sweep", file, f"has a name that cannot be the study's, which {Word.expected}")
    if values.get("trials", 0) is None:  # as if not given
        del values["trials"]
    if values.get("workers") == "auto":
        values["workers"] = usable_cores()
    found: Declaration = check(Declaration, {"study": file.stem, **values}, section=_FILE)
    if found.sampler.name == "cmaes" and find_spec("cmaes") is None:
        raise InputError("sampler", "cmaes", "needs the package cmaes: pip install 'origami-lab[cmaes]'")
    trials = _trials(found, "trials" not in values)
    return replace(found, trials=trials, held_out=_held_out(found, values), trust=trust)


def _keys() -> list[str]:
    return [known.name for known in fields(Declaration) if known.name != "trust"]


def _load(file: Path) -> dict[str, Any]:
    if not file.is_file():
        raise InputError("sweep", file, "must be a file" if file.exists() else "there is no such file")
    text = yaml_text("sweep", file)
    try:
        config = OmegaConf.create(text)
        check_interpolations("sweep", OmegaConf.to_container(config, resolve=False))
        values = OmegaConf.to_container(config, resolve=True)
    except InputError:
        raise
    except (yaml.YAMLError, OmegaConfBaseException, ValueError, RecursionError) as error:
        mark, lines = getattr(error, "problem_mark", None), str(error).splitlines()
        what = getattr(error, "problem", None) or (lines[0] if lines else type(error).__name__)
        raise InputError(
            "sweep", file, f"cannot be read: {what}" + (f" in line {mark.line + 1}" if mark else "")
        ) from None
    if not isinstance(values, dict) or not values:
        raise InputError("sweep", file, f"must hold keys and values: {', '.join(_keys())}")
    return {str(key): value for key, value in values.items()}


def _changed(values: dict[str, Any], changes: Sequence[str]) -> dict[str, Any]:
    for change in changes:
        key, equals, text = change.partition("=")
        above, dot, below = key.partition(".")
        if not equals:
            raise InputError("sweep", change, "must be KEY=VALUE, e.g. workers=2")
        if above not in (*_keys(), "trust") or (dot and above not in ON_THE_COMMAND_LINE):
            known = ", ".join(name for name in _keys() if name != "space")
            raise InputError(key, text, f"there is no such key of a sweep; must be one of {known}")
        try:
            value = OmegaConf.to_container(OmegaConf.from_dotlist([f"value={text}"]))["value"]  # type: ignore[call-overload, index]
        except Exception:
            raise InputError(key, text, "cannot be read as a value") from None
        if isinstance(value, dict) and not text.strip().startswith("{"):  # YAML's reading of a : at the end
            value = text
        if dot:
            now = values.get(above)
            now = {"name" if above != "tracking" else "kind": now} if isinstance(now, str) else now
            values[above] = {**(now if isinstance(now, dict) else {}), below: value}
        else:
            values[key] = value
    return values


def _trials(found: Declaration, all_points: bool) -> int:
    """How many trials there are: of a grid, where no number says so, all its points."""
    if found.sampler.name != "grid":
        return found.trials
    points = grid_size(found.space, MOST_TRIALS)
    if points > MOST_TRIALS:
        raise InputError("sampler", "grid", f"the grid must have at most {MOST_TRIALS} points")
    if not all_points and found.trials > points:
        raise InputError("trials", found.trials, f"must be at most {points}, the points of the grid")
    return points if all_points else found.trials


def _held_out(found: Declaration, values: Node) -> HeldOut:
    """The held-out comparison, once the seeds of trials and their budget are known."""
    held_out = found.held_out
    written = (values.get("held_out") or {}).get("seeds", format_seeds(held_out.seeds))
    both = sorted(set(held_out.seeds) & set(found.seeds))
    if both:
        expected = f"must hold no seed that trials play ({', '.join(map(str, both[:5]))})"
        raise InputError("held_out.seeds", written, expected)
    if len(held_out.seeds) < 2:
        raise InputError("held_out.seeds", written, "must hold at least two seeds; twenty or more tell something")
    return replace(held_out, budget=held_out.budget or found.budget)
