"""origami_lab/config/checked_values.py."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from origami_lab.config.node import Node, flatten
from origami_lab.config.seeds import parse_seeds
from origami_lab.errors import InputError
from origami_lab.text import nearest


def _is_above(value: object, high: int) -> bool:
    return isinstance(value, int) and value > high


class _Reader:
    """Checked access to the values by their dotted key, as the user writes it."""

    def __init__(self, values: Node) -> None:
        self.values = values

    def get(self, key: str) -> Any:
        value: Any = self.values
        for name in key.split("."):
            if not isinstance(value, Mapping) or name not in value:
                raise InputError(key, "(nothing)", "is missing from the configuration")
            value = value[name]
        return value

    def integer(self, key: str, low: int, high: int, expected: str | None = None) -> int:
        value = self.get(key)
        # 1e6 is a float to YAML, and what people write for a budget
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            limit = f"from {low}" if high >= 10**9 and not _is_above(value, high) else f"from {low} to {high}"
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
        if not isinstance(value, str) or not re.fullmatch(r"\w[\w.+-]{,99}", value):
            raise InputError(key, value, "must be a word of at most 100 letters, digits, '.', '_', '+' and '-'")
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
            expected = "must be one of its options, or name a class by _target_"
            if isinstance(value, Mapping) and key in value:  # the option's keys ended up below the group's
                expected += "; the first line of its file must be # @package _global_"
            raise InputError(key, value, expected)
        return {str(name): item for name, item in value.items()}


Value = None | bool | int | float | str
"""What a setting may be set to by a sweep."""


OWN = {
    **{"search": "searcher", "budget": "budget", "seed": "seeds", "output": "output", "workers": "workers"},
    **{"tracking": "tracking", "resume": "", "files": "", "verbosity": ""},
}
"""Settings of a run that a sweep makes itself, and its keys for them."""


class Reader:
    """One mapping of the file.

    Parameters
    ----------
    values
        The mapping, plain Python values.
    prefix
        What stands before its keys in messages, e.g. ``held_out.``.
    """

    def __init__(self, values: Mapping[str, Any], prefix: str = "") -> None:
        self.values, self.prefix = values, prefix

    def refuse(self, key: str, expected: str) -> InputError:
        """The error that a value is not what was expected."""
        return InputError(self.prefix + key, self.values.get(key, "(nothing)"), expected)

    def only(self, known: Sequence[str]) -> None:
        """Refuse keys that mean nothing here."""
        for key in self.values:
            if key not in known:
                expected = f"there is no such key{nearest(str(key), known)}; must be one of {', '.join(known)}"
                raise self.refuse(key, expected)

    def whole(self, key: str, low: int, high: int = 10**12, default: int | None = None) -> int:
        value = self.values.get(key, default)
        if isinstance(value, float) and value.is_integer():  # 1e6
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            limit = f"from {low}" if high >= 10**9 else f"from {low} to {high}"
            raise self.refuse(key, f"must be a whole number {limit}")
        return value

    def number(self, key: str) -> int | float:
        value = self.values.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.refuse(key, "must be a number")
        return value

    def flag(self, key: str, default: bool) -> bool:
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            raise self.refuse(key, "must be true or false")
        return value

    def word(self, key: str, default: str | None = None) -> str:
        """A word that is also fit to be the name of a folder."""
        value = self.values.get(key, default)
        if not isinstance(value, str) or not re.fullmatch(r"\w[\w.+-]{,99}", value):
            raise self.refuse(key, "must be a word of at most 100 letters, digits, '.', '_', '+' and '-'")
        return value

    def text(self, key: str) -> str | None:
        """A text, None where there is none."""
        value = self.values.get(key)
        if isinstance(value, int | float) and not isinstance(value, bool):  # a number is a name, too: output=5
            value = str(value)
        if value is not None and (not isinstance(value, str) or not value.strip() or "\0" in value):
            raise self.refuse(key, "must be a text, or null")
        return value

    def choice(self, key: str, options: Sequence[str], default: str) -> str:
        value = self.values.get(key, default)
        if value not in options:
            raise self.refuse(key, f"must be one of {', '.join(options)}{nearest(str(value), options)}")
        return str(value)

    def seeds(self, key: str, default: str) -> tuple[int, ...]:
        try:
            return parse_seeds(self.values.get(key, default))
        except InputError as error:
            raise InputError(self.prefix + key, error.value, error.expected) from error

    def below(self, key: str, short: str | None = None) -> Reader:
        """The mapping at a key; empty where there is none. ``name`` alone may stand for ``{short: name}``."""
        value = self.values.get(key)
        if value is None:
            value = {}
        if short is not None and isinstance(value, str):
            value = {short: value}
        if not isinstance(value, Mapping):
            expected = "must be a mapping of keys to values" + (
                "" if short is None else f", or one word for its {short}"
            )
            raise self.refuse(key, expected)
        return Reader(value, f"{self.prefix}{key}.")

    def overrides(self, key: str) -> tuple[str, ...]:
        """Settings as on the command line: a list of texts like target=bowl, or a mapping of keys to values."""
        value = self.values.get(key)
        if isinstance(value, str):
            return tuple(value.split())
        if isinstance(value, Mapping):
            return tuple(override(name, item) for name, item in flatten(value).items())
        if isinstance(value, Sequence) and all(isinstance(item, str) for item in value):
            return tuple(value)
        raise self.refuse(key, "must be settings like target=bowl: a list of them, or a mapping of keys to values")


def check_own(field: str, name: str, allowed: Sequence[str] = ()) -> None:
    """Refuse a setting that the sweep makes itself.

    Parameters
    ----------
    field
        The key of the file where it stands.
    name
        The setting, e.g. ``search.sigma_1``, also with a value behind it.
    allowed
        Those that may stand there nevertheless.
    """
    setting = name.partition("=")[0].lstrip("+~")
    root = "tracking" if setting.startswith("tracking.") else setting
    if root in OWN and root not in allowed:
        expected = f"is what the sweep's own key {OWN[root]} says" if OWN[root] else "is the sweep's own affair"
        raise InputError(field, name, f"must not be set here: {setting} {expected}")


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
