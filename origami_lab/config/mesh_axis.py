"""Which axis of a mesh file points up, in configurations: resolved before a run, and as it was in runs made before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from origami_lab.config.node import Node
from origami_lab.targets.mesh_reader import axis_up


def with_resolved_up(values: Node) -> dict[str, Any]:
    """A whole configuration with the axis that is up in its mesh, instead of ``auto``."""
    return with_target(values, resolved_up)


def resolved_up(target: Node) -> Node:
    """A target's configuration, if it is a mesh file with the axis that is up instead of ``auto``."""
    if not is_mesh(target) or target.get("up") != "auto" or not isinstance(target.get("path"), str):
        return target
    return {**target, "up": axis_up(target["path"])}


def as_it_was(target: Node) -> Node:
    """A target's configuration with what it does not say, because version 0.1.0 did not ask: read as it was then."""
    return {**target, "up": None} if is_mesh(target) and "up" not in target else target


def is_mesh(part: Any) -> bool:
    """Whether a part of the configuration is our target from a mesh file."""
    name = str(part.get("_target_")) if isinstance(part, Mapping) else ""
    return name.startswith("origami_lab.") and name.endswith(".mesh")


def without_up(target: Node) -> Node:
    """A target's configuration that does not say which axis is up."""
    return {key: value for key, value in target.items() if key != "up"}


def with_target(values: Node, change: Callable[[Node], Node]) -> dict[str, Any]:
    """A whole configuration with a changed target, also where the objective has it, resolved."""
    found = dict(values)
    if isinstance(found.get("target"), Mapping):
        found["target"] = change(found["target"])
    if isinstance(found["objective"].get("target"), Mapping):
        found["objective"] = {**found["objective"], "target": change(found["objective"]["target"])}
    return found
