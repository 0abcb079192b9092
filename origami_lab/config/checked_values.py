"""Kinds of values that only configurations have: parts, seeds, lists of settings, where a run is tracked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from origami_lab.checks import REFUSED, Choice, Kind, Number, Text, wrong
from origami_lab.config.checked_files import check_interpolations
from origami_lab.config.node import flatten
from origami_lab.config.seeds import parse_seeds
from origami_lab.config.trusted_code import is_installed_package
from origami_lab.errors import InputError

Value = None | bool | int | float | str
"""Values that a sweep may give to a setting."""


OWN = {
    **{"search": "searcher", "budget": "budget", "seed": "seeds", "output": "output", "workers": "workers"},
    **{"tracking": "tracking", "resume": "", "files": "", "verbosity": "", "hydra": ""},
    "stages": "",
    **{"trust": "trust, which is given on the command line only,"},
}
"""Settings of a run that a sweep makes itself, and its keys for them."""


@dataclass(frozen=True)
class Tracking:
    """Where a run is tracked."""

    kind: Annotated[str, Choice(("mlflow", "none"))] = "mlflow"
    uri: Annotated[str | None, Text("must be an MLflow URI", numbers=False)] = None
    experiment: Annotated[str | None, Text("must be the name of an MLflow experiment", longest=500)] = None


@dataclass(frozen=True)
class ReportOrder:
    """Places of the task and of the searcher in reports: those with a number come first, others follow by name."""

    task: Annotated[float | None, Number(-math.inf, math.inf, "must be a number")] = None
    method: Annotated[float | None, Number(-math.inf, math.inf, "must be a number")] = None


class Seeds(Kind):
    """Seeds in the grammar of ``seed``."""

    def take(self, value: Any) -> Any:
        try:
            return parse_seeds(value)
        except InputError as error:
            raise wrong(error.expected, error.value) from None


class Packages(Kind):
    """Installed packages, one or a list of them, by the names that pip knows them by."""

    expected = "must be the name of an installed package, as pip knows it, or a list of such names"

    def take(self, value: Any) -> Any:
        names = [value] if isinstance(value, str) else value
        if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
            return REFUSED
        return tuple(names) if all(map(is_installed_package, names)) else REFUSED


class Part(Kind):
    """A part of an experiment: a mapping with the ``_target_`` that makes it.

    Parameters
    ----------
    group
        The group that it is chosen from.
    """

    expected = "must be one of its options, or name a class by _target_"

    def __init__(self, group: str) -> None:
        self.group = group

    def take(self, value: Any) -> Any:
        if isinstance(value, Mapping) and isinstance(value.get("_target_"), str):
            return {str(name): item for name, item in value.items()}
        return REFUSED

    def message(self, value: Any) -> str:
        nested = isinstance(value, Mapping) and self.group in value  # the option's keys ended up below the group's
        return self.expected + "; the first line of its file must be # @package _global_" * nested


class Overrides(Kind):
    """Settings as on the command line: a list of texts like target=bowl, or a mapping of keys to values.

    Parameters
    ----------
    allowed
        Settings that the sweep makes itself and that may stand there nevertheless.
    """

    expected = "must be settings like target=bowl: a list of them, or a mapping of keys to values"

    def __init__(self, *allowed: str) -> None:
        self.allowed = allowed

    def take(self, value: Any) -> Any:
        if isinstance(value, str):
            found = value.split()
        elif isinstance(value, Mapping):
            found = [override(name, item) for name, item in flatten(value).items()]
        elif isinstance(value, Sequence) and all(isinstance(item, str) for item in value):
            found = list(value)
        else:
            return REFUSED
        for setting in found:
            check_own(setting, self.allowed)
        return tuple(found)


def check_own(name: str, allowed: Sequence[str] = ()) -> None:
    """Refuse a setting that the sweep makes itself.

    Parameters
    ----------
    name
        The setting, e.g. ``search.sigma_1``, also with a value behind it.
    allowed
        Settings that may stand there nevertheless.
    """
    setting = name.partition("=")[0].lstrip("+~")
    words = re.split(r"[./@]", setting)
    root = "hydra" if "hydra" in words else "tracking" if words[0] == "tracking" else setting
    if root in OWN and root not in allowed:
        expected = f"is what the sweep's own key {OWN[root]} says" if OWN[root] else "is the sweep's own affair"
        raise wrong(f"must not be set here: {setting} {expected}", name)
    try:
        check_interpolations(setting, name)
    except InputError as error:
        raise wrong(error.expected, name) from None


def shown(value: Any) -> str:
    """A value as it is written in a configuration."""
    if value is None:
        return "null"
    return str(value).lower() if isinstance(value, bool) else str(value)


def override(key: str, value: Any) -> str:
    """A setting as it is typed on the command line."""
    return f"{key}={_typed(value)}"


def _typed(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(_typed, value)) + "]"
    return repr(value) if isinstance(value, float) else shown(value)
