"""Remarks before the trials start, one line each, on things that are not wrong but good to know."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from origami_lab.config.instantiate import Parts
from origami_lab.config.physical_size import millimetres_per_cell
from origami_lab.config.settings import Settings

if TYPE_CHECKING:
    from origami_lab.targets.target import Target

LARGEST_FIRST = ("xyd", "xy", "x", "y")


def remarks(settings: Settings, parts: Parts) -> Iterator[str]:
    """Settings that do nothing, the scale of a mesh, a symmetry of the game that the mesh does not have."""
    from origami_lab.geometry.groups import GROUPS
    from origami_lab.targets.mesh_reader import axis_up

    idle = [name for name in ("polish_seconds", "polish_simplify") if settings.config.get(name) is not None]
    if idle and not settings.polish:
        yield f"warning: {' and '.join(idle)} without polish=N: nothing is polished"
    if settings.minutes is not None:
        yield "warning: minutes ends a trial's search by the clock: what is found is not reproducible by the seed alone"
    target = parts.target
    if target is not None and "target" not in settings.config["objective"]:
        yield f"warning: the objective ({settings.task}) does not look at the target ({target.name}); leave target out"
    if target is None or target.units_per_cell is None or settings.target is None:
        return
    name = Path(str(settings.target.get("path", target.name))).name
    on_paper = "" if settings.cell is None else f", {settings.cell:.4g} mm on paper"
    if settings.part_lines:
        yield from settings.part_lines
    else:
        yield f"{name}: 1 board cell = {target.units_per_cell:.4g} units of the file{on_paper}"
    yield from _true_size(settings, target)
    if settings.target.get("up", "") is None and axis_up(name) == "y":
        yield f"{name} stands with its z axis up, as in version 0.1.0, which this run was made by; new runs turn y up"
    symmetry = settings.game.symmetry
    if symmetry == "none" or target.has_symmetry(GROUPS[symmetry]):
        return
    own = next((other for other in LARGEST_FIRST if target.has_symmetry(GROUPS[other])), "none")
    yield (
        f"warning: {name} is not symmetric under symmetry={symmetry}, the folded sheet will be: "
        f"it fits only as far as that; the mesh has symmetry={own}"
    )


def _true_size(settings: Settings, target: Target) -> Iterator[str]:
    """How large a part becomes on paper, where that is not its own size."""
    plain = millimetres_per_cell(replace(settings, cell=None), target)
    if settings.cell is None or plain is None or abs(settings.cell / plain - 1.0) < 1e-6:
        return
    sides = " × ".join(f"{length * settings.cell:.4g}" for length in np.ptp(target.vertices, axis=0))
    yield (
        f"on paper a cell is {settings.cell:.4g} mm: the part becomes {sides} mm, {settings.cell / plain:.3g} times its"
        f" size (cell={plain:.6g}mm keeps it)"
    )
