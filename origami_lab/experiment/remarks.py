"""What a person should know before the trials start, although nothing is wrong: one line each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from origami_lab.experiment.build import Parts
from origami_lab.experiment.settings import Settings

if TYPE_CHECKING:
    from origami_lab.objectives.targets import Target

LARGEST_FIRST = ("xyd", "xy", "x", "y")


def remarks(settings: Settings, parts: Parts) -> Iterator[str]:
    """The scale of a mesh, and a symmetry of the game that the mesh does not have."""
    target = parts.target
    if target is None or target.units_per_cell is None or settings.target is None:
        return
    name = Path(str(settings.target.get("path", target.name))).name
    yield f"{name}: 1 board cell = {target.units_per_cell:.4g} units of the file"
    symmetry = settings.game["symmetry"]
    if symmetry == "none" or has_symmetry(target, symmetry):
        return
    own = next((other for other in LARGEST_FIRST if has_symmetry(target, other)), "none")
    yield (
        f"warning: {name} is not symmetric under symmetry={symmetry}, the folded sheet will be: "
        f"it fits only as far as that; the mesh has symmetry={own}"
    )


def has_symmetry(target: Target, symmetry: str) -> bool:
    """Whether every mirror of a group maps the target to itself."""
    from origami_lab.geometry.groups import GROUPS

    group = GROUPS[symmetry]
    return all(target.is_symmetric(matrix) for matrix in group.matrices[group.mirrors])
