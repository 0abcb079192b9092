"""Settings that may be left open, ``auto``: settled before a run, and kept by a run that goes on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from origami_lab.config.mesh_axis import is_mesh
from origami_lab.config.node import Node

DISTANCE = "objective.distance"


def settle_distance(values: Node) -> tuple[dict[str, Any], tuple[str, ...]]:
    """A whole configuration with the distance that suits the target, and the keys that were open.

    What counts for a part is its surface: a panel may stand out where no vertex shows it.
    """
    objective = values.get("objective")
    if not isinstance(objective, Mapping) or not _is_ours(objective) or objective.get("distance") != "auto":
        return dict(values), ()
    distance = "surface" if is_mesh(values.get("target")) else "vertex"
    return with_distance(values, distance), (DISTANCE,)


def with_distance(values: Node, distance: object) -> dict[str, Any]:
    """A whole configuration with another distance."""
    return {**values, "objective": {**values["objective"], "distance": distance}}


def _is_ours(objective: Node) -> bool:
    return str(objective.get("_target_")).startswith("origami_lab.")
