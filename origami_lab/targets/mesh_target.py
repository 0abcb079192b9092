"""A mesh file of the user's as a target: read, welded, turned, scaled and laid where it is to be met."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from origami_lab.errors import InputError
from origami_lab.lengths import millimetres
from origami_lab.targets.mesh_reader import Array, Indices, axis_up, millimetres_per_unit, read_mesh, used
from origami_lab.targets.skins import SKINS, Skin, skin_of
from origami_lab.targets.target import Target


def mesh(
    path: str | Path,
    scale: float = 1.0,
    rotate: Sequence[float] = (0.0, 0.0, 0.0),
    translate: Sequence[float] = (0.0, 0.0, 0.0),
    fit: Literal["board"] | None = None,
    align_z: bool | Sequence[float] = False,
    closed: Literal["auto"] | bool = "auto",
    board_size: int = 25,
    max_faces: int = 200_000,
    name: str | None = None,
    up: Literal["auto", "y", "z"] | None = "auto",
    board_width: int | None = None,
    board_height: int | None = None,
    cell: float | str | None = None,
    skin: Skin | None = None,
    unit: str | None = None,
) -> Target:
    """A target from a mesh file: see :func:`origami_lab.targets.mesh_target.load_mesh` for all parameters but two.

    Parameters
    ----------
    cell
        The length of a board cell, ``"5mm"`` or a number of millimetres: without ``fit`` the mesh is then as large as
        its file says, and ``scale`` a factor on that.
    unit
        That of the file: ``mm``, ``cm``, ``m`` or ``in``; None: what its kind says, millimetres where it says nothing.

    Raises
    ------
    InputError
        If the file or a setting is unusable; one line that says why.
    """
    length = None if cell is None else millimetres(cell)
    if cell is not None and length is None:
        raise InputError("target.cell", cell, "must be a length above 0, like 5mm")
    per_unit = millimetres_per_unit(path, unit)
    if length is not None and fit is None and _is_number(scale):
        scale = scale * per_unit / length
    try:
        vertices, faces, is_closed, units, uncertainty = load_mesh(
            *(path, scale, rotate, translate, fit, align_z, closed, board_size, max_faces, up),
            *(board_width, board_height, skin),
        )
    except InputError as error:
        if length is None or fit is not None or error.field != "target.scale" or not scale > 0.0:
            raise
        raise InputError("cell", cell, error.expected) from error  # what was asked for
    title = Path(path).stem if name is None else name
    return Target(title, vertices, faces, is_closed, units, uncertainty=uncertainty)


MOST_FACES = 10_000_000
"""The largest ``max_faces``: such a mesh takes gigabytes."""


FIT_SHARE = 0.8
"""``fit=board`` uses this share of the sheet's half-width."""


def load_mesh(
    path: str | Path,
    scale: float = 1.0,
    rotate: Sequence[float] = (0.0, 0.0, 0.0),
    translate: Sequence[float] = (0.0, 0.0, 0.0),
    fit: str | None = None,
    align_z: bool | Sequence[float] = False,
    closed: str | bool = "auto",
    board_size: int = 25,
    max_faces: int = 200_000,
    up: str | None = "auto",
    board_width: int | None = None,
    board_height: int | None = None,
    skin: Skin | None = None,
) -> tuple[Array, Indices, bool, float, float]:
    """Read a mesh and place it; the steps are done in the order up, rotate, fit, scale, translate, align_z.

    Parameters
    ----------
    path
        STL, OBJ, PLY, OFF, GLB, GLTF, or what else trimesh reads; several bodies are taken together. Polygons are cut
        into triangles, equal vertices are welded, triangles without area are dropped.
    scale
        Positive factor about the origin: board units per unit of the file or, with ``fit``, a factor on
        what fits.
    rotate
        Degrees about the fixed x, then y, then z axis, about the origin of the file.
    translate
        Board units along x, y, z.
    fit
        ``"board"``: the bounding box is centred over the origin with its lowest point at z = 0 and scaled
        uniformly until half its side in x or y plus its height is 0.8 of half the board's side there, (N−1)/2, and
        the other is no more. No point gets further from the middle of the sheet by folding, and walls use up paper: so
        a flat shape gets 0.8 of the board, a tall one less. (The paper's bowl and cube have 0.79 and 0.75.)
    align_z
        ``True`` moves the mesh along z until its highest point on the z axis is at z = 0, as the paper does
        for its face; ``(x, y)`` does so above that point of the board.
    closed
        Whether it bounds a solid (see ``Target``). ``"auto"``: if it is watertight.
    board_size
        N of the N×N board, for ``fit`` and for what is an absurd scale.
    max_faces
        More triangles than this are refused.
    up
        The axis of the file that points up; ``"y"`` is turned to the board's z, so that what looked along −z before
        looks along y. ``"auto"``: y for glTF, whose standard says so, z for all others. ``None``: the file is taken
        as version 0.1.0 took it, which turned nothing, fanned polygons and asked for symmetry to the last bit; so that
        runs which do not say what is up keep their target.
    board_width, board_height
        Points of the board along x and along y; None for N.
    skin
        ``"outer"`` or ``"inner"``: of a thin-walled solid (see :mod:`~origami_lab.targets.skins`) that side of its
        walls alone, an open surface. ``None``: the mesh as it is.

    Returns
    -------
    vertices (V, 3), faces (F, 3), closed, units of the file per board cell, and how far a vertex may be from where it
    was meant to be (board units), by the digits that the file has

    Raises
    ------
    InputError
        If a setting is wrong; if the file cannot be read (see :func:`read_mesh`) or has no area; if it is open
        where ``closed=True``; if it is to have a skin and is no thin-walled solid; if the result is smaller than a
        tenth of a board cell, larger than two boards, or
        further away than that.
    """
    # settings first: they are cheap to check
    angles, shift, place = check_settings(path, scale, rotate, translate, fit, align_z, closed, max_faces, up, skin)
    board = [board_size if side is None else side for side in (board_width, board_height)]

    vertices, faces, precision = read_mesh(Path(path), max_faces, as_first=up is None)
    if skin is not None:
        vertices, faces = used(vertices, faces[skin_of(path, vertices, faces, precision, skin)])
    if (axis_up(path) if up == "auto" else up) == "y":
        vertices = np.column_stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]])
    vertices, faces = _weld(vertices, faces)
    if len(faces) == 0:
        raise InputError("target.path", path, "its triangles have no area")
    vertices = vertices @ rotation_matrix(angles).T
    cells_per_unit = float(scale)
    if fit == "board":
        vertices, factor = _fit(vertices, *(FIT_SHARE * 0.5 * (side - 1) for side in board))
        cells_per_unit *= factor
    vertices = vertices * scale + shift
    if place is not None:
        vertices[:, 2] -= surface_height(vertices[faces], place, path)

    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = float((high - low).max())
    longer = max(board) - 1
    limit = 2.0 * longer  # no sheet on the board covers more
    if not 0.1 <= size <= limit:
        raise InputError(
            "target.scale",
            scale,
            f"makes the mesh {size:.3g} cells large on a board of {longer}: must be 0.1 to {limit:g}"
            " (target.fit=board chooses a scale)",
        )
    away = float(np.maximum(np.maximum(low, -high), 0.0).max())
    if away > limit:
        raise InputError(
            "target.translate",
            list(map(float, shift)),
            f"the mesh is {away:.3g} cells from the board: try target.fit=board",
        )
    open_edges = count_open_edges(faces)
    if closed is True and open_edges > 0:
        raise InputError(
            "target.closed", closed, f"{path} has {open_edges} open edges: repair it, or choose auto or false"
        )
    is_closed = open_edges == 0 if closed == "auto" else bool(closed)
    # all three coordinates may be off; where it was centred, so may the middle
    uncertainty = math.sqrt(3.0) * precision * cells_per_unit * (2.0 if fit == "board" else 1.0)
    return vertices, faces, is_closed, 1.0 / cells_per_unit, uncertainty


def check_settings(
    path: str | Path,
    scale: float = 1.0,
    rotate: Sequence[float] = (0.0, 0.0, 0.0),
    translate: Sequence[float] = (0.0, 0.0, 0.0),
    fit: str | None = None,
    align_z: bool | Sequence[float] = False,
    closed: str | bool = "auto",
    max_faces: int = 200_000,
    up: str | None = "auto",
    skin: str | None = None,
) -> tuple[Array, Array, Array | None]:
    """Check what :func:`load_mesh` takes, without reading the file; the angles, the shift and the point of align_z.

    Raises
    ------
    InputError
        For the first that is wrong.
    """
    if not (_is_number(scale) and scale > 0.0):
        raise InputError("target.scale", scale, "must be a positive number")
    angles = _numbers("target.rotate", rotate, 3, "three angles in degrees about x, y, z, e.g. [90,0,0]")
    shift = _numbers("target.translate", translate, 3, "three lengths in board units, e.g. [0,0,-1]")
    if fit not in (None, "board"):
        raise InputError("target.fit", fit, "must be board or null")
    if not (isinstance(path, str | Path) and str(path).strip()):
        raise InputError("target.path", path, "must be a mesh file: target.path=part.stl")
    if isinstance(max_faces, bool) or not isinstance(max_faces, int) or not 1 <= max_faces <= MOST_FACES:
        raise InputError("target.max_faces", max_faces, f"must be a whole number from 1 to {MOST_FACES}")
    if (isinstance(closed, float | int) and not isinstance(closed, bool)) or closed not in ("auto", True, False):
        raise InputError("target.closed", closed, "must be auto, true or false")
    if up not in ("auto", "y", "z", None):
        raise InputError("target.up", up, "must be auto, y or z")
    if skin is not None and skin not in SKINS:
        raise InputError("target.skin", skin, f"must be auto, {', '.join(SKINS)} or null")
    return angles, shift, alignment_point(align_z)


def count_open_edges(faces: Indices) -> int:
    """The number of edges with an odd number of (F, 3) faces: 0 means watertight, so it has an inside."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    return int((counts % 2 == 1).sum())


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _numbers(field: str, values: Sequence[float] | str, count: int, expected: str) -> Array:
    """``count`` finite numbers, or an :class:`InputError`."""
    try:
        items = list(values)
    except TypeError:
        items = []
    if isinstance(values, str) or len(items) != count or not all(map(_is_number, items)):
        raise InputError(field, values, f"must be {expected}")
    return np.array(items, dtype=np.float64)


def _weld(vertices: Array, faces: Indices) -> tuple[Array, Indices]:
    """Join vertices that agree within 1e-9 of the size (STL repeats them, OBJ at seams); drop empty faces."""
    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max())
    if size == 0.0:
        return vertices, faces[:0]
    _, first, index = np.unique(
        np.round((vertices - low) / (1e-9 * size)).astype(np.int64),
        axis=0,
        return_index=True,
        return_inverse=True,
    )
    vertices, faces = vertices[first], index.reshape(-1)[faces].astype(np.int64)
    a, b, c = np.moveaxis((vertices - low)[faces] / size, 1, 0)
    double_areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    if not double_areas.sum() > 1e-12:
        return vertices, faces[:0]
    # slivers stay: without them the mesh would have a gap
    return used(vertices, faces[distinct])


def rotation_matrix(degrees: Sequence[float] | Array) -> Array:
    """About the fixed axes x, then y, then z. Quarter turns are exact."""
    result = np.eye(3)
    for axis, angle in enumerate(degrees):
        quarter = angle / 90.0
        if quarter == round(quarter):
            cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
        else:
            cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = cos
        turn[j, i], turn[i, j] = sin, -sin
        result = turn @ result
    return result


def _fit(vertices: Array, reach_x: float, reach_y: float) -> tuple[Array, float]:
    """Centred over the origin, standing on z = 0, scaled so that it can be folded; by what.

    Half its extent in x plus its height is at most ``reach_x``, half that in y plus its height ``reach_y``, and one of
    them is equal.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    width, depth, height = high - low
    base = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
    factor = float(min(reach_x / (0.5 * width + height), reach_y / (0.5 * depth + height)))
    return (vertices - base) * factor, factor


def alignment_point(align_z: bool | Sequence[float]) -> Array | None:
    """The point (x, y) that ``target.align_z`` names, the origin for true, None for false; raises InputError."""
    if not isinstance(align_z, bool):
        return _numbers("target.align_z", align_z, 2, "true, false or a point [x,y] of the board")
    return np.zeros(2) if align_z else None


def surface_height(triangles: Array, place: Array, path: object) -> float:
    """The largest z of the surface on the vertical line through ``place`` (x, y); touching an edge counts."""
    flat = triangles[:, :, :2] - place
    a, b, c = np.moveaxis(flat, 1, 0)
    weights = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    area = weights.sum(axis=1)
    extent = np.abs(triangles).max() + np.abs(place).max()
    usable = np.abs(area) > 1e-12 * extent * extent
    weights = weights[usable] / area[usable, None]
    hit = (weights >= -1e-9).all(axis=1)
    if not hit.any():
        x, y = map(float, place)
        raise InputError(
            "target.align_z",
            [x, y],
            f"no part of {path} is above or below this point; choose another one",
        )
    return float((weights[hit] * triangles[usable][hit][:, :, 2]).sum(axis=1).max())


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
