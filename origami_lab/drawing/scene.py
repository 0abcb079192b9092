"""Things to draw: the target surface as a file gives it, and the colours."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError

FRONT = (244, 168, 88)
"""The side of the paper that lies up when the sheet is flat."""
BACK = (112, 154, 200)
TARGET = (88, 190, 150)
PALE_TARGET = (199, 233, 219)
"""As it appears on the page."""
INK = (38, 40, 52)
PAGE = (255, 255, 255)
MOUNTAIN = "#d62828"
VALLEY = "#1d5fd1"


@dataclass(frozen=True, eq=False)
class TargetSurface:
    """A target as a triangle mesh, in board cells."""

    vertices: NDArray[np.float64]
    """(V, 3)"""
    faces: NDArray[np.int64]
    """(F, 3)"""


def read_target(path: str | os.PathLike[str]) -> TargetSurface:
    """Read a target mesh (``target.ply`` of a run folder, or any file trimesh reads).

    Raises :class:`InputError`, whose field is the path, when there is no mesh in the file.
    """
    import trimesh  # here: it takes half a second, which a start-up should not

    path = Path(path)
    if not path.is_file():
        raise InputError(str(path), "missing", "must be a mesh file")
    try:
        mesh = trimesh.load(path, force="mesh", process=False)
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    except Exception as error:  # the many readers behind trimesh raise anything at all
        raise InputError(str(path), type(error).__name__, "must be a mesh file that trimesh reads") from None
    if faces.size == 0 or not np.isfinite(vertices).all():
        raise InputError(str(path), f"{len(faces)} faces", "must be a mesh with faces and finite vertices")
    return TargetSurface(vertices, faces)


def target_of(path: Path) -> TargetSurface | None:
    """The target of the run that a trial's FOLD file belongs to."""
    file = path.absolute().parent.parent / "target.ply"
    return read_target(file) if path.absolute().parent.name.startswith("seed=") and file.is_file() else None
