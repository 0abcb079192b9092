"""The paper that a pattern is to be cut from: what a board cell is on it, settled before a run."""

from __future__ import annotations

import math
from typing import Any

from origami_lab.config.amounts import Millimetres, Paper
from origami_lab.config.mesh_axis import is_mesh, with_target
from origami_lab.config.node import Node
from origami_lab.errors import InputError
from origami_lab.game.rule_settings import RuleSettings
from origami_lab.lengths import MARGIN
from origami_lab.targets.mesh_reader import millimetres_per_unit


def settle_cell(values: Node, game: RuleSettings, *, fits_part: bool = False) -> dict[str, Any]:
    """A whole configuration with the cell that its sheet has room for, where it names a sheet and no cell.

    Parameters
    ----------
    fits_part
        Whether the board was chosen for a part, whose size on paper then follows from it.

    Raises
    ------
    InputError
        If the board does not fit on the sheet; it names the cell that would.
    """
    sheet = None if values.get("sheet") is None else Paper().take(values["sheet"])
    cell = None if values.get("cell") is None else Millimetres().take(values["cell"])
    if not isinstance(sheet, tuple) or not (cell is None or isinstance(cell, float)):
        return dict(values)  # what is wrong with them is said when they are checked
    sides = game.width - 1, game.height - 1
    rooms = [(w - 2 * MARGIN, h - 2 * MARGIN) for w, h in (sheet, sheet[::-1])]
    fits = max(min(room / side for room, side in zip(turned, sides, strict=True)) for turned in rooms)
    largest = math.floor(100.0 * fits) / 100.0
    if largest <= 0.0:
        raise InputError("sheet", values["sheet"], f"must have room for a board within margins of {MARGIN:g} mm")
    if cell is None:
        cell = largest
        return with_target({**values, "cell": cell}, lambda target: _with_cell(target, largest, fits_part))
    if cell > fits * (1 + 1e-9):
        size = " × ".join(f"{side * cell:.4g}" for side in sides)
        room = " × ".join(f"{length:.4g}" for length in rooms[0])
        expected = f"must be at most {largest:g}mm: a pattern may be as large as the board, {size} mm,"
        raise InputError("cell", values["cell"], f"{expected} and this sheet has {room} mm within its margins")
    return dict(values)


def _with_cell(target: Node, cell: float, fits_part: bool) -> Node:
    if not is_mesh(target) or target.get("cell", 0) is not None:
        return target
    # with a cell the scale is a factor on the true size
    size = target.get("scale", 1.0)
    if fits_part:
        size = target["scale"] * cell / millimetres_per_unit(str(target["path"]), target.get("unit"))
    return {**target, "cell": cell, "scale": size}
