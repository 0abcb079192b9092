"""Symmetry groups of the board, as integer matrices, and their fundamental domains.

A group element is an integer 2×2 matrix acting on the board; a mirror of the board is a mirror of space
through the vertical plane over its axis, so the same matrix (with 1 for z) acts on folded shapes.
The playable area is the closed fundamental domain (paper, appendix A): a wedge that the boundary of the
sheet enters over its *start* axis and leaves over its *end* axis when walked counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_IDENTITY = ((1, 0), (0, 1))
_MIRROR_Y = ((-1, 0), (0, 1))
_MIRROR_X = ((1, 0), (0, -1))
_HALF_TURN = ((-1, 0), (0, -1))
_DIAGONAL = ((0, 1), (1, 0))
_ANTIDIAGONAL = ((0, -1), (-1, 0))
_QUARTER_TURN = ((0, -1), (1, 0))
_THREE_QUARTER_TURN = ((0, 1), (-1, 0))

Matrix = tuple[tuple[int, int], tuple[int, int]]


@dataclass(frozen=True, eq=False)
class SymmetryGroup:
    """A finite group of board symmetries and its closed fundamental domain."""

    name: str
    matrices: NDArray[np.int64]
    """(g, 2, 2), the identity first."""
    normals: NDArray[np.int64]
    """(a, 2) inner normals: a point is playable where all ``normals @ point >= 0``."""
    mirrors: NDArray[np.int64]
    """(a,) index of the mirror whose axis bounds the domain on each of those sides."""
    start_mirror: int
    """The mirror over whose axis the counter-clockwise boundary enters the domain (0: there is none)."""
    end_mirror: int
    """The mirror over whose axis it leaves."""

    @property
    def order(self) -> int:
        return len(self.matrices)

    @property
    def products(self) -> NDArray[np.int64]:
        """(g, g) table: element i after element j."""
        flat = {m.tobytes(): i for i, m in enumerate(self.matrices)}
        return np.array([[flat[(p @ q).tobytes()] for q in self.matrices] for p in self.matrices])

    @property
    def inverses(self) -> NDArray[np.int64]:
        """(g,) index of each element's inverse."""
        return np.asarray(np.argmin(self.products, axis=1))

    def playable(self, points: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which of the (n, 2) ``points`` lie in the closed fundamental domain."""
        if not len(self.normals):
            return np.ones(len(points), dtype=np.bool_)
        return np.asarray(np.all(points @ self.normals.T >= 0, axis=1))


def _group(
    name: str, matrices: list[Matrix], domain: list[tuple[tuple[int, int], Matrix]], seams: tuple[Matrix, ...]
) -> SymmetryGroup:
    start, end = (matrices.index(seam) for seam in seams) if seams else (0, 0)
    return SymmetryGroup(
        name,
        np.array(matrices, dtype=np.int64),
        np.array([normal for normal, _ in domain], dtype=np.int64).reshape(-1, 2),
        np.array([matrices.index(mirror) for _, mirror in domain], dtype=np.int64),
        start,
        end,
    )


GROUPS: dict[str, SymmetryGroup] = {
    group.name: group
    for group in (
        _group("none", [_IDENTITY], [], ()),
        _group("y", [_IDENTITY, _MIRROR_Y], [((-1, 0), _MIRROR_Y)], (_MIRROR_Y, _MIRROR_Y)),
        _group("x", [_IDENTITY, _MIRROR_X], [((0, 1), _MIRROR_X)], (_MIRROR_X, _MIRROR_X)),
        _group(
            "xy",
            [_IDENTITY, _MIRROR_Y, _MIRROR_X, _HALF_TURN],
            [((-1, 0), _MIRROR_Y), ((0, 1), _MIRROR_X)],
            (_MIRROR_Y, _MIRROR_X),
        ),
        _group(
            "xyd",
            [
                _IDENTITY,
                _MIRROR_Y,
                _MIRROR_X,
                _HALF_TURN,
                _DIAGONAL,
                _ANTIDIAGONAL,
                _QUARTER_TURN,
                _THREE_QUARTER_TURN,
            ],
            [((0, 1), _MIRROR_X), ((-1, -1), _ANTIDIAGONAL)],
            (_ANTIDIAGONAL, _MIRROR_X),
        ),
    )
}
"""The groups by name: ``y`` is symmetric about the y axis (x → −x), ``x`` about the x axis, and so on."""
