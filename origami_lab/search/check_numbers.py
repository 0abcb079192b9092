"""Checks of a searcher's own numbers."""

from __future__ import annotations

import math

from origami_lab.errors import InputError


def check_whole(name: str, value: object, low: int, high: int) -> int:
    """The whole number; raises InputError unless ``search.name`` is one, from low to high."""
    # 1e3 is a float to YAML
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise InputError(f"search.{name}", value, f"must be a whole number from {low} to {high}")
    return value


def check_number(name: str, value: object, low: float, high: float) -> None:
    """Raise InputError unless ``search.name`` is a finite number from low to high."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high or math.isinf(value):
        raise InputError(f"search.{name}", value, f"must be a number from {low:g} to {high:g}")


def check_flag(name: str, value: object) -> None:
    """Raise InputError unless ``search.name`` is true or false."""
    if not isinstance(value, bool):
        raise InputError(f"search.{name}", value, "must be true or false")
