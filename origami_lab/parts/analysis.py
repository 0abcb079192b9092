"""The analysis of a part: what its mesh is, and how it is to be laid on the board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from origami_lab.lengths import MILLIMETRES
from origami_lab.parts.flat_region import FlatRegion, flat_regions
from origami_lab.parts.frame import PartFrame, find_frame, is_flat_faced
from origami_lab.parts.setup import PartLayout, PartSetup, curved_setup, flat_setup, lay_out
from origami_lab.parts.shape_measures import Curvature, covered_share, curvature
from origami_lab.parts.sharp_edges import sharpened
from origami_lab.parts.surface import Array, PartSurface, read_surface
from origami_lab.targets.mesh_reader import unit_of
from origami_lab.targets.mesh_target import MOST_FACES, rotation_matrix
from origami_lab.targets.target import Target

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""What ``target.up=y`` does."""


@dataclass(frozen=True, eq=False)
class PartAnalysis:
    """A part: what its file holds, in the file's units, and the settings that suit it."""

    path: Path
    surface: PartSurface
    laid: PartSurface
    """The same with sharp edges in place of roundings between flat panels, by which it is laid on the board."""
    rounded: float
    """How far these edges are from the part as it is, units of the file; 0 if there are none."""
    regions: tuple[FlatRegion, ...]
    """Its flat regions, the largest first."""
    frame: PartFrame
    """How it lies on the board."""
    layout: PartLayout | None
    """How its base and walls lie on board points; None for a part that is not flat-faced or has no base with walls."""
    curvature: Curvature
    """How its curved parts bend."""
    covered: float
    """The part of an open surface that lies under another part of it, seen from above as it lies on the board."""
    walls: float | None
    """The thickness of the walls, units of the file, if it is a thin-walled solid of which one skin is taken."""
    skin: str | None
    """Which skin that is, ``outer`` or ``inner``."""
    unit: str
    """The file's unit as it was given, else the one that its size suggests: ``mm`` or ``m``; of glTF metres."""
    setup: PartSetup

    @property
    def extent(self) -> Array:
        """(3,) size along x, y and z as it lies on the board, units of the file."""
        return np.asarray(np.ptp(self.frame.placed(self.surface.vertices), axis=0))

    @property
    def is_flat_faced(self) -> bool:
        return is_flat_faced(self.laid, self.regions)

    @property
    def holes(self) -> int:
        """Rims beyond the first of each body of an open surface."""
        return max(0, self.surface.rims - self.surface.bodies)

    @property
    def cell(self) -> float:
        """A board cell, in millimetres if the unit is right."""
        return MILLIMETRES[self.unit] / self.setup.scale

    @property
    def area_cells(self) -> float:
        """Its area, square cells."""
        return self.surface.area * self.setup.scale**2

    @property
    def board_cells(self) -> int:
        """The area of the largest sheet, square cells."""
        return (self.setup.board[0] - 1) * (self.setup.board[1] - 1)

    def target(self) -> Target:
        """The part as it lies on the board, in cells."""
        cells = self.setup.scale * (self.surface.vertices @ self.frame.rotation.T) + np.array(self.setup.translate)
        return Target(
            self.path.stem, cells, self.surface.faces, self.surface.is_closed, 1.0 / self.setup.scale,
            uncertainty=2.0 * self.surface.precision * self.setup.scale,
        )  # fmt: skip


def analyse_part(
    path: str | Path,
    *,
    up: str = "z",
    rotate: Sequence[float] | None = None,
    scale: float | None = None,
    max_faces: int = MOST_FACES,
    skin: str | None = "auto",
    unit: str = "auto",
    cell: float | None = None,
) -> PartAnalysis:
    """Read a mesh file and find out what it is and how it is to be laid on the board.

    Parameters
    ----------
    path
        As for :func:`origami_lab.targets.mesh`.
    up
        The axis of the file that points up, ``y`` or ``z``: of no account unless the part may not be turned.
    rotate
        Degrees about the x, y and z axis if the part is to lie so; None: as it suits the part.
    scale
        Cells per unit of the file, if it is given.
    max_faces
        More triangles than this are refused.
    skin
        Of a thin-walled solid the ``outer`` or the ``inner`` side of its walls, None for all of it; ``auto``: the
        outer one if it is such a solid.
    unit
        That of the file: ``mm``, ``cm``, ``m`` or ``in``; ``auto``: by its kind and size.
    cell
        The length of a board cell in millimetres, if it is given: ``scale`` is then a factor on the true size.

    Raises
    ------
    InputError
        If the file cannot be read, has no area, or has no skin where one is asked for.
    """
    surface, walls = read_surface(path, max_faces, skin)
    unit = _unit(surface, Path(path)) if unit == "auto" else unit
    if cell is not None:
        scale = (1.0 if scale is None else float(scale)) * MILLIMETRES[unit] / cell
    regions, laid, off = flat_regions(surface), surface, 0.0
    if not is_flat_faced(surface, regions) and (sharp := sharpened(surface)) is not None:
        regions, laid, off = sharp.regions, sharp.surface, sharp.off
    turned = None if rotate is None else rotation_matrix(rotate) @ (Y_UP if up == "y" else np.eye(3))
    frame = find_frame(laid, regions, turned)
    layout = lay_out(laid, regions, frame, scale)
    if layout is None:
        setup = curved_setup(surface, frame, scale)
    else:
        setup = flat_setup(layout, frame, surface.is_closed)
    return PartAnalysis(
        path=Path(path),
        surface=surface,
        laid=laid,
        rounded=off,
        regions=regions,
        frame=frame,
        layout=layout,
        curvature=curvature(laid, regions),
        covered=0.0 if surface.is_closed else covered_share(surface, frame),
        walls=walls,
        skin=None if walls is None else "outer" if skin == "auto" else skin,
        unit=unit,
        setup=setup,
    )


def _unit(surface: PartSurface, path: Path) -> str:
    """That of its kind; or metres, where it would be smaller than a fingernail in millimetres."""
    unit = unit_of(path)
    return "m" if unit == "mm" and float(np.ptp(surface.vertices, axis=0).max()) < 3.0 else unit
