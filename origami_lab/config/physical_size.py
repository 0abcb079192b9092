"""Board cells as lengths: what a cell is in millimetres, and what a return in a unit is in cells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from origami_lab.config.amounts import CELLS, PERCENT, UNITS, Amount
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.targets.mesh_reader import millimetres_per_unit

if TYPE_CHECKING:
    from origami_lab.targets.target import Target


def millimetres_per_cell(settings: Settings, target: Target | None) -> float | None:
    """The length of a board cell on paper: as asked for, else that of a mesh; None where nothing says it."""
    if settings.cell is not None:
        return settings.cell
    if target is None or target.units_per_cell is None or settings.target is None:
        return None
    return target.units_per_cell * millimetres_per_unit(
        str(settings.target.get("path", "")), settings.target.get("unit")
    )


def is_distance(objective: Any) -> bool:
    """Whether its return is minus a distance to a target, in board cells."""
    from origami_lab.objectives.shape import ShapeObjective  # here: it brings kernels

    return isinstance(objective, ShapeObjective)


def thickness_in_cells(settings: Settings, target: Target | None) -> float:
    """The thickness of what is folded, in board cells; 0 for none.

    Raises
    ------
    InputError
        If nothing says what a cell is in millimetres.
    """
    if settings.thickness is None:
        return 0.0
    cell = millimetres_per_cell(settings, target)
    if cell is None:
        said = settings.config.get("thickness")
        raise InputError("thickness", said, "must come with cell=5mm or sheet=A4: nothing else says how long a cell is")
    return settings.thickness / cell


def aimed_return(amount: Amount, settings: Settings, objective: Any, target: Target | None) -> float:
    """The return that a ``target_return`` means.

    Raises
    ------
    InputError
        If it is in a unit that this objective or this target does not have.
    """
    number, said = amount.number, amount.said
    if not is_distance(objective):
        if amount.unit != CELLS:
            raise InputError("target_return", said, "must be a number: the return is no distance to a target")
        return number
    target, distance = objective.target, abs(number)
    if amount.unit == PERCENT:
        return -distance / 100.0 * target.size
    if amount.unit == CELLS:
        return -distance
    each = target.units_per_cell if amount.unit == UNITS else millimetres_per_cell(settings, target)
    if each is None:
        hint = "" if amount.unit == UNITS else "; cell=5mm says how long a cell is"
        raise InputError("target_return", said, f"must be in cells or percent: the target comes from no file{hint}")
    return -distance / each
