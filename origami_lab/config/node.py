"""A part of the configuration as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from origami_lab.errors import InputError
from origami_lab.file_names import FOLDER_FORMAT

Node = Mapping[str, Any]
"""A part of the configuration as plain Python values."""

FREE_TO_CHANGE = (
    *("seed", "workers", "files", "objective_seconds", "tracking", "output", "resume", "verbosity"),
    *("folder_format", "report_order", "trust", "polish", "polish_seconds", "polish_simplify", "open"),
)
"""Keys that may differ between a run and its resumption: they do not change what a trial finds."""
OF_STAGES = ("budget", "target_return", "minutes", "stages")
"""Keys that say how far a run goes, and went: it may go on, and its record names them."""


def flatten(node: Node, prefix: str = "") -> dict[str, Any]:
    """Nested keys as dotted ones; an empty mapping stays a value."""
    flat: dict[str, Any] = {}
    for key, value in node.items():
        if isinstance(value, Mapping) and value:
            flat.update(flatten(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def check_format(config: Node) -> None:
    """Raise InputError if a run's configuration was written by a version that keeps its folders otherwise."""
    version = config.get("folder_format", 1)
    if isinstance(version, bool) or not isinstance(version, int) or not 1 <= version <= FOLDER_FORMAT:
        expected = f"was made by a newer origami-lab; this one reads folders of format 1 to {FOLDER_FORMAT}"
        raise InputError("folder_format", version, expected)
