"""The folded sheet as a triangle mesh, for 3D programs and printers."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.panel_triangles import triangulate


def write_mesh(
    fold: FoldFile, frame: FoldFrame, path: str | os.PathLike[str], *, scale: float = 1.0, thickness: float = 0.0
) -> None:
    """Write the sheet folded as in ``frame``; the suffix (obj, stl, ply, glb) says how.

    Coordinates are the board's, z up, times ``scale``; in a GLB, whose readers take y as up, they stand under a node
    that turns them. ``thickness`` in the units that are written; without, triangles share the vertices of the
    pattern. Raises :class:`InputError` if no panel has an area.
    """
    import trimesh  # here: it takes half a second, which a start-up should not

    path = Path(path)
    vertices, faces = plates(fold, frame.coords * scale, thickness) if thickness > 0.0 else _sheet(fold, frame, scale)
    if not len(faces):
        raise InputError("to", path.suffix[1:], "needs panels with an area, this pattern has none")
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    kind = path.suffix.lower()[1:]
    written: Any = mesh
    if kind == "glb":
        upright = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
        # glTF shows one side of a surface only, unless its material says otherwise
        material = trimesh.visual.material.PBRMaterial(
            baseColorFactor=[244, 168, 88, 255], metallicFactor=0.0, roughnessFactor=0.9, doubleSided=True
        )
        mesh.visual = trimesh.visual.TextureVisuals(material=material)
        written = trimesh.Scene()
        written.add_geometry(mesh, node_name="sheet", geom_name="sheet", transform=upright)
    options = {"digits": 17} if kind == "obj" else {"vertex_normal": False} if kind == "ply" else {}
    content = written.export(file_type=kind, **options)
    write_whole(path, content.encode() if isinstance(content, str) else content)


def plates(
    fold: FoldFile, coords: NDArray[np.float64], thickness: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(N, 3) vertices and (T, 3) faces of one closed plate a panel, half its thickness on each side of the sheet.

    The sides are at right angles to the panel. Where two panels meet, their plates overlap within the fold and gape
    outside it; they are not cut to clear each other.
    """
    points, faces = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)]
    count = 0
    for panel in fold.panels:
        ring = list(panel)
        corners, n = coords[ring], len(ring)
        inner, _ = triangulate(fold.vertices[ring], [range(n)])
        if not len(inner):
            continue
        a, b, c = (corners[inner[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a).sum(axis=0)
        shift = normal * (thickness / 2 / np.linalg.norm(normal))
        here = np.arange(n)
        following = np.roll(here, -1)
        walls = [(here, here + n, following), (following, here + n, following + n)]
        sides = [np.column_stack(side) for side in walls]
        # the upper side, as the sheet is wound; the lower one the other way round
        faces += [part + count for part in (inner, inner[:, ::-1] + n, *sides)]
        points += [corners + shift, corners - shift]
        count += 2 * n
    return np.vstack(points), np.vstack(faces)


def _sheet(fold: FoldFile, frame: FoldFrame, scale: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    triangles, _ = triangulate(fold.vertices, fold.panels)
    return frame.coords * scale, triangles
