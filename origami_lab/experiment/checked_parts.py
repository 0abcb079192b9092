"""What a run keeps and says of its parts. The first worker makes and checks them: the parent needs no game for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from origami_lab.config.instantiate import Parts
    from origami_lab.config.node import Node
    from origami_lab.config.settings import Settings


@dataclass(frozen=True)
class KeptTarget:
    """A target's surface alone, (V, 3) and (F, 3), in board units."""

    vertices: np.ndarray[Any, Any]
    faces: np.ndarray[Any, Any]
    units_per_cell: float | None


@dataclass(frozen=True)
class CheckedParts:
    """What is known of parts that were made and refused by nothing."""

    target: KeptTarget | None
    start: Node | None
    """The start pattern as a run folder keeps it; None where placing it is an action of the game."""
    remarks: tuple[str, ...]
    """Lines on what is not wrong but good to know."""


def look_at(settings: Settings, parts: Parts) -> CheckedParts:
    """What a run keeps and says of the parts that were made of its settings."""
    from origami_lab.config.warnings import remarks

    made = parts.target
    target = None if made is None else KeptTarget(made.vertices, made.faces, made.units_per_cell)
    return CheckedParts(target, parts.start_to_keep(settings), tuple(remarks(settings, parts)))
