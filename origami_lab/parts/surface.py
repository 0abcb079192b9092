"""The surface of a part as its mesh tells it: bodies, rims, sides that agree, and how its area is spread.

All in units and axes of the file. Nothing here depends on how the part is turned, shifted, or cut into triangles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from origami_lab.errors import InputError
from origami_lab.geometry.graph import connected_pieces
from origami_lab.targets.mesh_reader import read_mesh, used
from origami_lab.targets.skins import SKINS, find_walls, no_walls

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LEAST_PRECISION = 1e-9
"""Of its size, to which a part is ever known."""
THIRD_DEGREE = (
    (-9 / 16, (1 / 3, 1 / 3, 1 / 3)),
    *((25 / 48, w) for w in ((0.6, 0.2, 0.2), (0.2, 0.6, 0.2), (0.2, 0.2, 0.6))),
)
"""Weights and places in a triangle that integrate polynomials up to the third degree."""


@dataclass(frozen=True, eq=False)
class PartSurface:
    """A part's surface, in units and axes of its file."""

    vertices: Array
    """(V, 3)"""
    faces: Indices
    """(F, 3), those that meet along an edge turned to one side."""
    precision: float
    """How far a vertex may be from where it was meant to be."""

    @cached_property
    def size(self) -> float:
        """The diagonal of its bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def corners(self) -> Array:
        """(F, 3, 3)"""
        return np.asarray(self.vertices[self.faces])

    @cached_property
    def area_vectors(self) -> Array:
        """(F, 3) along the normals, as long as the areas."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return np.asarray(0.5 * np.cross(b - a, c - a))

    @cached_property
    def areas(self) -> Array:
        """(F,)"""
        return np.asarray(np.linalg.norm(self.area_vectors, axis=1))

    @property
    def area(self) -> float:
        return float(self.areas.sum())

    @cached_property
    def centroid(self) -> Array:
        """(3,) the middle of its area."""
        return np.asarray(self.areas @ self.corners.mean(axis=1) / self.area)

    @cached_property
    def vector_area(self) -> Array:
        """(3,) the sum of its area vectors: of an open dish the way it opens, of a solid nothing."""
        return np.asarray(self.area_vectors.sum(axis=0))

    @property
    def _samples(self) -> tuple[Array, Array]:
        """Points (n, 3) and weights (n,) that integrate polynomials up to the third degree over the surface."""
        points = np.concatenate([np.einsum("j,fjk->fk", np.array(place), self.corners) for _, place in THIRD_DEGREE])
        return points, np.concatenate([weight * self.areas for weight, _ in THIRD_DEGREE])

    @cached_property
    def moments(self) -> tuple[Array, Array]:
        """Second (3, 3) and third (3, 3, 3) moments of its area about its middle, in sizes: exact for each triangle."""
        points, weights = self._samples
        x, w = (points - self.centroid) / self.size, weights / self.area
        second = (x * w[:, None]).T @ x
        third = np.stack([(x * (w * x[:, k])[:, None]).T @ x for k in range(3)])
        return np.asarray(second), third

    @cached_property
    def _edges(self) -> tuple[Indices, Indices, Indices]:
        """The distinct edges (E, 2), the edge of each (3F,) side of a face, and how many faces have each (E,)."""
        edges, owner, counts = np.unique(
            np.sort(sides_of(self.faces), axis=1), axis=0, return_inverse=True, return_counts=True
        )
        return edges, owner.reshape(-1), counts

    @cached_property
    def neighbours(self) -> tuple[Indices, Indices]:
        """Pairs of faces (P, 2) that alone share an edge, and the side (P, 2) of each at which they do, 0 to 2."""
        return neighbours_of(self.faces)

    @cached_property
    def bodies(self) -> int:
        """Pieces that do not share an edge."""
        owner = self._edges[1]
        face = np.tile(np.arange(len(self.faces)), 3)
        order = np.argsort(owner, kind="stable")
        same = owner[order][1:] == owner[order][:-1]
        return _count(len(self.faces), np.column_stack([face[order][:-1][same], face[order][1:][same]]))

    @cached_property
    def open_edges(self) -> int:
        """Edges of one face only, or of another odd number."""
        return int((self._edges[2] % 2 == 1).sum())

    @property
    def is_closed(self) -> bool:
        return self.open_edges == 0

    @cached_property
    def rims(self) -> int:
        """Connected pieces of its border: a sheet without holes has one, a tube two."""
        edges, _, counts = self._edges
        border = edges[counts % 2 == 1]
        if not len(border):
            return 0
        _, index = np.unique(border, return_inverse=True)
        return _count(int(index.max()) + 1, index.reshape(-1, 2))


def read_surface(path: str | Path, max_faces: int, skin: str | None = None) -> tuple[PartSurface, float | None]:
    """A mesh file's surface, its vertices joined as far as the file's own digits leave it open; and its walls.

    Parameters
    ----------
    skin
        As for :func:`origami_lab.targets.mesh_target.load_mesh`; ``"auto"``: the outer one of a thin-walled solid.

    Returns
    -------
    The surface, and the thickness of the walls whose skin it is; None if it is the whole mesh.

    Raises
    ------
    InputError
        If it cannot be read (see ``targets``), has no area, or has no skin where one is asked for.
    """
    vertices, faces, precision = read_mesh(Path(path), max_faces)
    walls = None if skin is None else find_walls(vertices, faces, precision)
    if walls is not None:
        vertices, faces = used(vertices, faces[walls.skin("inner" if skin == "inner" else "outer")])
    elif skin in SKINS:
        raise no_walls(path, skin)
    return surface_of(vertices, faces, precision, path), None if walls is None else walls.thickness


def surface_of(vertices: Array, faces: Indices, precision: float, name: object = "part") -> PartSurface:
    """The surface of a triangle mesh, (V, 3) and (F, 3), whose coordinates are known to a precision.

    Raises
    ------
    InputError
        If it has no area; the name is that of the file.
    """
    low = vertices.min(axis=0)
    extent = float(np.ptp(vertices, axis=0).max())
    vertices = vertices - (middle := 0.5 * (low + vertices.max(axis=0)))  # far from the origin digits are lost
    precision = max(precision, LEAST_PRECISION * extent)
    pairs = cKDTree(vertices).query_pairs(2.0 * precision, output_type="ndarray")
    label = connected_pieces(len(vertices), pairs.astype(np.int64))
    _, first, index = np.unique(label, return_index=True, return_inverse=True)
    vertices, faces = vertices[first], index.reshape(-1)[faces].astype(np.int64)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces = faces[distinct]
    faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
    if len(faces) == 0 or not _double_areas(vertices, faces).sum() > 1e-12 * extent * extent:
        raise InputError("target.path", name, "its triangles have no area")
    vertices, faces = used(vertices + middle, faces)
    return PartSurface(vertices, _turned_alike(faces), precision)


def sides_of(faces: Indices) -> Indices:
    """(3F, 2) the first sides of all faces, then the second, then the third ones."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def neighbours_of(faces: Indices) -> tuple[Indices, Indices]:
    """Pairs of faces (P, 2) that alone share an edge, and at which of their sides (P, 2) they do."""
    sides = np.sort(sides_of(faces), axis=1)
    order = np.lexsort(sides.T)
    same = (sides[order][1:] == sides[order][:-1]).all(axis=1)
    alone = same & ~np.append(same[1:], False) & ~np.append(False, same[:-1])
    first, second = order[:-1][alone], order[1:][alone]
    count = len(faces)
    return np.column_stack([first % count, second % count]), np.column_stack([first // count, second // count])


def _turned_alike(faces: Indices) -> Indices:
    """The faces, turned over where they disagree with their neighbours; of each piece most keep their side."""
    pairs, at = neighbours_of(faces)
    if not len(pairs):
        return faces
    sides = np.stack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    against = (sides[at[:, 0], pairs[:, 0]] == sides[at[:, 1], pairs[:, 1]]).all(axis=1)
    count = len(faces)
    # two numbers, as a matrix keeps no zeros
    matrix = coo_array((1 + against, (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    matrix = matrix.maximum(matrix.T).tocsr()
    number, label = connected_components(matrix, directed=False)
    turned = np.zeros(count, dtype=bool)
    for piece in range(number):
        members = np.nonzero(label == piece)[0] if number < 1000 else np.array([], dtype=np.int64)
        if len(members) < 2:
            continue
        order, before = breadth_first_order(matrix, members[0], directed=False)
        differs = np.asarray(matrix[order[1:], before[order[1:]]]).reshape(-1) == 2
        for face, earlier, other in zip(order[1:].tolist(), before[order[1:]].tolist(), differs.tolist(), strict=True):
            turned[face] = turned[earlier] ^ other
        if 2 * turned[members].sum() > len(members):
            turned[members] ^= True
    return np.where(turned[:, None], faces[:, ::-1], faces)


def _double_areas(vertices: Array, faces: Indices) -> Array:
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _count(count: int, pairs: Indices) -> int:
    return int(connected_pieces(count, pairs).max()) + 1


def length(vector: Array) -> float:
    return float(math.sqrt(float(np.dot(vector, vector))))
