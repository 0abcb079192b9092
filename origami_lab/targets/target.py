"""Target shapes: triangulated surfaces in board units, and the paper's closed-form ones (appendix).

The sheet lies in the plane z = 0, centred on the origin. A target never enters the game; objectives measure
folded designs against it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from origami_lab.errors import InputError
from origami_lab.geometry.bvh import Bvh, build_bvh, distances
from origami_lab.geometry.groups import SymmetryGroup
from origami_lab.geometry.sampling import areas, covering_points, sample_triangles
from origami_lab.geometry.wide_tree import WideTree, build_wide_tree

Array = NDArray[np.float64]
Direction = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Target:
    """A triangulated target surface.

    Attributes
    ----------
    name
        For titles and file names.
    vertices
        (V, 3) float64, board units, read-only.
    faces
        (F, 3) int64, F ≥ 1, read-only.
    closed
        Whether the surface bounds a solid: folded parts inside it then add nothing to the distance from the
        folded surface to the target.
    units_per_cell
        Units of the file that it came from in a board cell; None if it came from none.
    up, front
        Directions that are up, and towards the viewer, when it stands as one looks at it; None for z and −y.
    uncertainty
        How far its points may be from where they were meant to be, board units: a file has so many digits.
    """

    name: str
    vertices: Array
    faces: NDArray[np.int64]
    closed: bool
    units_per_cell: float | None = None
    up: Direction | None = None
    front: Direction | None = None
    uncertainty: float = 0.0

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64, order="C") + 0.0  # no negative zeros
        for field, array in (("vertices", vertices), ("faces", np.array(self.faces, np.int64, order="C"))):
            array.flags.writeable = False
            object.__setattr__(self, field, array)

    @cached_property
    def triangles(self) -> Array:
        """(F, 3, 3) float64. Writable only because numba compiles a second version for read-only arrays."""
        return self.vertices[self.faces]

    @cached_property
    def bvh(self) -> Bvh:
        """The bounding-box tree over :attr:`triangles`."""
        return build_bvh(self.triangles)

    @cached_property
    def wide_tree(self) -> WideTree:
        """The same for searches, which ask often."""
        return build_wide_tree(self.bvh)

    @property
    def size(self) -> float:
        """The longest side of the box around it, board units."""
        corners = self.triangles.reshape(-1, 3)
        return float(np.ptp(corners, axis=0).max())

    @property
    def area(self) -> float:
        """Surface area, square board units."""
        return float(areas(self.triangles).sum())

    def samples(self, spacing: float) -> Array:
        """Deterministic points (n, 3) that cover the surface, sorted by coordinates.

        The vertices of the mesh after midpoints were put on all edges longer than ``spacing``, again and
        again. A point of the surface is at most spacing/√3 from one of them. A symmetric mesh gives exactly
        symmetric points.

        Raises
        ------
        InputError
            If ``spacing`` is not positive or so fine that there would be millions of points.
        """
        if not spacing > 0.0:
            raise InputError("spacing", spacing, "must be a positive length in board units")
        try:
            return covering_points(self.triangles, spacing)
        except ValueError as error:
            raise InputError("spacing", spacing, f"too fine for target {self.name}: {error}") from error

    def sampled_points(self, count: int, seed: int) -> Array:
        """Random points (count, 3), uniform by area; the same for the same seed.

        Raises
        ------
        InputError
            If ``count`` is below 1 or ``seed`` is negative.
        """
        if count < 1 or seed < 0:
            raise InputError("count, seed", (count, seed), "must be at least 1 and at least 0")
        return sample_triangles(self.triangles, count, np.random.default_rng(seed))

    @property
    def tolerance(self) -> float:
        """How far two places may be apart that are meant to be one, board units: 1e-9 of its size, or twice what is
        uncertain.
        """
        return max(1e-9 * max(1.0, float(np.abs(self.vertices).max())), 2.0 * self.uncertainty)

    def has_symmetry(self, group: SymmetryGroup) -> bool:
        """Whether the surface maps to itself under a whole group: the mirrors that bound its domain generate it."""
        return all(self.is_symmetric(matrix) for matrix in group.matrices[group.mirrors])

    def is_symmetric(self, matrix: ArrayLike) -> bool:
        """Whether the surface maps to itself, within :attr:`tolerance`, under ``matrix`` acting on (x, y).

        Parameters
        ----------
        matrix
            2×2 integers, one of the eight symmetries of the square. The images of all vertices, edge
            midpoints and face centroids are compared with the surface.
        """
        key = np.asarray(matrix, dtype=np.float64).tobytes()
        if key not in self._symmetries:
            self._symmetries[key] = self._maps_to_itself(matrix)
        return self._symmetries[key]

    @cached_property
    def _symmetries(self) -> dict[bytes, bool]:
        """Whether the surface maps to itself, by the matrices that were asked for."""
        return {}

    def _maps_to_itself(self, matrix: ArrayLike) -> bool:
        image = np.eye(3)
        image[:2, :2] = np.asarray(matrix, dtype=np.float64)
        tolerance = self.tolerance
        used = self.vertices[np.unique(self.faces)]
        corners = self.triangles
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1)).reshape(-1, 3)
        return all(
            bool((distances(self.bvh, np.ascontiguousarray(points @ image.T)) <= tolerance).all())
            for points in (used, corners.mean(axis=1), middles)
        )
