"""Thin-walled solids: what a sheet is to become of such a part is one side of its walls, its skin.

A part that was modelled with the thickness of its material bounds a solid: an outer skin, an inner one a wall's
thickness away from it, and between the two a narrow rim along its open edges. Nothing here depends on how the part is
turned or shifted, and little on how it is cut into triangles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from origami_lab.errors import InputError
from origami_lab.geometry.graph import connected_pieces

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

SKINS = ("outer", "inner")
Skin = Literal["outer", "inner"]

THINNEST, THICKEST = 2e-3, 0.06
"""Walls of such a thickness, in parts of the diagonal of the bounding box, are looked for."""
STEPS = 2.5
"""Points of the surface lie at most a thickness over this apart."""
MOST_POINTS, MOST_ASKED = 1_000_000, 100_000
"""How many points there are at most, and how many of them are asked for their other side."""
GENERALISED_GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps of a sequence of points that fills a square evenly, however many they are."""
OPPOSITE = -0.85
"""Cosine of the angle between the normals of the two sides of a wall, at most."""
FOUND, AWAY = 0.5, 0.4
"""A wall's other side is found within this part of its thickness of where it is expected, and no more than the other
part nearer or further as it is seen from there."""
MOSTLY = 0.5
"""Of a face's area: has another side, so that it belongs to a skin."""
ALIKE = math.radians(0.5)
"""Faces of one plane belong to a skin together."""
SMOOTH, GOES_ON = math.radians(20.0), math.cos(math.radians(35.0))
"""A skin goes on to its rim over edges that bend no more than this, and turns no more than this on the way."""
LEAST_SKIN, LEAST_SKINS = 0.25, 0.6
"""Of the area of such a part: the smaller skin, and both together."""


@dataclass(frozen=True, eq=False)
class Walls:
    """The two skins of a thin-walled solid, the outer one the larger.

    Attributes
    ----------
    outer, inner
        (F,) which faces of the mesh they have.
    thickness
        Of the walls, in units of the mesh.
    """

    outer: Mask
    inner: Mask
    thickness: float

    def skin(self, name: Skin) -> Mask:
        """(F,) the faces of one of them."""
        return self.outer if name == "outer" else self.inner


def find_walls(vertices: Array, faces: Indices, precision: float = 0.0) -> Walls | None:
    """The walls of a mesh (V, 3), (F, 3) whose coordinates are known to a precision; None if it is not thin-walled.

    Thin-walled is what is closed and whose surface, but for rims, has an opposite side at one and the same small
    distance, in two pieces that are themselves open.
    """
    solid = trimesh.Trimesh(vertices, faces, process=False)
    digits = 9 if precision <= 0.0 else int(np.clip(math.floor(-math.log10(2.0 * precision)), 0, 9))
    solid.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=digits)
    if not solid.is_watertight:
        return None
    if not solid.is_winding_consistent:
        trimesh.repair.fix_winding(solid)
    areas, size = np.asarray(solid.area_faces), float(np.linalg.norm(solid.extents))
    volume = abs(float(solid.volume))
    outward = np.asarray(solid.face_normals) * (1.0 if solid.volume >= 0.0 else -1.0)
    within = np.ones(len(faces), dtype=bool)
    thickness = 2.0 * volume / max(float(areas.sum()), 1e-300)
    for _ in range(3):  # the rims count until they are known
        if not THINNEST * size <= thickness <= THICKEST * size:
            return None
        points = _points(solid, thickness / STEPS)
        if points is None:
            return None
        within = _have_other_side(solid, *points, outward, thickness)
        if not areas[within].sum() > LEAST_SKINS * areas.sum():
            return None
        thickness = 2.0 * volume / float(areas[within].sum())
    return _two_skins(solid, within, areas, thickness)


def skin_of(path: object, vertices: Array, faces: Indices, precision: float, name: Skin) -> Mask:
    """(F,) the faces of one skin of a file's mesh.

    Raises
    ------
    InputError
        If it is no thin-walled solid.
    """
    walls = find_walls(vertices, faces, precision)
    if walls is None:
        raise no_walls(path, name)
    return walls.skin(name)


def no_walls(path: object, name: object) -> InputError:
    """What is said where a skin is asked for and there is none."""
    return InputError("target.skin", name, f"{path} is no thin-walled solid: must be null, or auto")


def _points(solid: trimesh.Trimesh, spacing: float) -> tuple[Array, Array, Indices] | None:
    """Points (N, 3) over the surface, the area (N,) that each stands for, and their faces (N,); None if too many."""
    areas = np.asarray(solid.area_faces)
    counts = np.ceil(areas / spacing**2).astype(np.int64)
    if counts.sum() > MOST_POINTS:
        return None
    owners = np.repeat(np.arange(len(areas)), counts)
    rank = np.arange(1, len(owners) + 1)  # goes on from face to face, so that narrow ones side by side differ
    u, v = ((0.5 + rank[:, None] * GENERALISED_GOLDEN) % 1.0).T
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = np.moveaxis(np.asarray(solid.triangles)[owners], 1, 0)
    places = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return places, np.repeat(areas / np.maximum(counts, 1), counts), owners


def _have_other_side(
    solid: trimesh.Trimesh, places: Array, areas: Array, owners: Indices, outward: Array, thickness: float
) -> Mask:
    """(F,) the faces that have, a thickness below most of their plane's area, a side that looks the other way."""
    tree, normals = cKDTree(places), outward[owners]
    asked = np.arange(0, len(owners), max(1, len(owners) // MOST_ASKED))
    asked = np.union1d(asked, np.nonzero(np.diff(owners, prepend=-1))[0])  # each face at least once
    below = places[asked] - thickness * normals[asked]
    reach, near = tree.query(below, k=6, distance_upper_bound=FOUND * thickness)
    near = np.where(np.isfinite(reach), near, 0)
    facing = np.einsum("nkj,nj->nk", normals[near], normals[asked]) <= OPPOSITE
    back = np.einsum("nkj,nkj->nk", normals[near], places[near] - places[asked, None])
    opposite = facing & (np.abs(back - thickness) <= AWAY * thickness)
    paired = (np.isfinite(reach) & opposite).any(axis=1)
    plane = _planes(solid)
    weights = np.bincount(owners, weights=areas)[owners[asked]] / np.bincount(owners[asked])[owners[asked]]
    of_plane = [np.bincount(plane[owners[asked]], weights=w, minlength=len(plane)) for w in (weights * paired, weights)]
    share = of_plane[0] / np.maximum(of_plane[1], 1e-300)
    return np.asarray((share > MOSTLY)[plane])


def _planes(solid: trimesh.Trimesh) -> Indices:
    """(F,) the plane of each face: neighbours that go on straight have one."""
    return connected_pieces(len(solid.faces), solid.face_adjacency[solid.face_adjacency_angles < ALIKE])


def _two_skins(solid: trimesh.Trimesh, within: Mask, areas: Array, thickness: float) -> Walls | None:
    """The two pieces into which the rims part the walls' sides."""
    pairs = solid.face_adjacency
    piece = connected_pieces(len(areas), pairs[within[pairs].all(axis=1)])
    sizes = np.bincount(piece, weights=areas * within)
    first, second = np.argsort(-sizes, kind="stable")[:2] if len(sizes) > 1 else (0, 0)
    if first == second or sizes[second] < LEAST_SKIN * areas.sum():
        return None
    if sizes[first] + sizes[second] < LEAST_SKINS * areas.sum():
        return None
    skins = [_to_its_rim(solid, within & (piece == one), within) for one in (first, second)]
    outer, inner = sorted(skins, key=lambda faces: -float(areas[faces].sum()))
    if any(
        (np.unique(solid.edges_sorted.reshape(-1, 3, 2)[one].reshape(-1, 2), axis=0, return_counts=True)[1] == 2).all()
        for one in (outer, inner)
    ):  # closed in itself: a hollow body has no rim
        return None
    return Walls(outer, inner, thickness)


def _to_its_rim(solid: trimesh.Trimesh, skin: Mask, within: Mask) -> Mask:
    """A skin with what goes on smoothly from it beyond the other one: a slanted rim leaves no other side there."""
    pairs, bends = solid.face_adjacency, solid.face_adjacency_angles
    smooth = np.concatenate([pairs[bends < SMOOTH], pairs[bends < SMOOTH][:, ::-1]])
    normals = np.asarray(solid.face_normals)
    seed = np.where(skin, np.arange(len(skin)), -1)
    while True:
        come, go = smooth[:, 0], smooth[:, 1]
        fits = (seed[come] >= 0) & (seed[go] < 0) & ~within[go]
        fits &= np.einsum("ij,ij->i", normals[seed[come]], normals[go]) > GOES_ON
        if not fits.any():
            return seed >= 0
        order = np.lexsort([seed[come[fits]], go[fits]])[::-1]  # the lowest seed counts
        seed[go[fits][order]] = seed[come[fits][order]]
