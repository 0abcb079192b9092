"""What an experiment with a part is to be set to, chosen from its analysis."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from origami_lab.parts.corners import Corner, corners_between
from origami_lab.parts.flat_region import FlatRegion
from origami_lab.parts.frame import PartFrame, is_flat_faced
from origami_lab.parts.lattice import Lattice, lattices
from origami_lab.parts.surface import Array, PartSurface
from origami_lab.parts.unfolding import BaseSide, Unfolding, unfold

MOST_HALF = 40
"""Cells from the middle of the largest board that is chosen to its edge."""
LEAST_CELLS = 6
"""Cells across the smallest part that is chosen."""
TIE = 1e-3
"""Cells: lengths that differ by less are one, so that rounding decides nothing."""
NEARLY_SQUARE = 1.23
"""A curved part that needs no more room along one side than so many times that along the other has a square board."""
LEAST_WALL = 2.0
"""Cells that walls which meet are wide, unfolded: there is no room for tucked paper behind narrower ones."""
FAR, ROOM = 3.0, 2.0
"""Paper that is tucked away at a corner may reach so many times the walls' width; if it cannot, the board has so many
of these widths of room beyond the corner."""
CURVED_BOARD = 25
"""Points along the sides of a board for a curved part; as many in all if it is longer than wide."""
CURVED_SHARE = 0.8
"""Of the half-width of such a board that half the part and its height take up, as with ``target.fit=board``."""
CURVED_CREASE = 2.9
"""Longest crease for a curved part, cells."""
SHORT_OF_LIMIT = 1e-4
"""Degrees by which a solid's driving angle stays below its own: there, outer creases would lie on one line."""
FLAT_ANGLES, CURVED_ANGLES = 2, 10
"""How many driving angles are tried."""
LARGEST_ANGLE = math.degrees(3.14)
Group = str


@dataclass(frozen=True)
class PartSetup:
    """Settings for a part, in the words of the configuration."""

    rotate: tuple[float, float, float]
    """Degrees about the file's x, then y, then z axis."""
    scale: float
    """Cells per unit of the file."""
    translate: tuple[float, float, float]
    """Cells."""
    symmetry: Group
    start: Mapping[str, Any]
    """A start pattern: the name of its class in ``origami_lab.game`` as ``_target_``, and its arguments."""
    board: tuple[int, int]
    """Points along x and y."""
    max_crease_length: float | None
    """Cells."""
    driving_angle_max: float
    """Degrees."""
    driving_angle_count: int
    source_action: bool


@dataclass(frozen=True, eq=False)
class PartLayout:
    """How a flat-faced part lies on the board."""

    unfolding: Unfolding
    driven: tuple[bool, ...]
    """Of the sides of the base, which are the start panel's creases."""
    fold: float
    """Degrees, of these."""
    lattice: Lattice
    is_exact: bool
    """Whether all corners of the base and its walls lie on board points."""
    corners: tuple[Corner, ...]
    """Where two driven walls meet."""
    symmetry: Group
    shift: Array
    """(2,) cells by which the part is moved from its middle on the board."""


def lay_out(
    surface: PartSurface, regions: Sequence[FlatRegion], frame: PartFrame, scale: float | None = None
) -> PartLayout | None:
    """The layout of a flat-faced part, at a given scale if there is one; None if it has no base with walls, or
    no board for it.
    """
    if frame.base is None or not is_flat_faced(surface, regions):
        return None
    unfolding = unfold(regions, frame)
    driven, fold = _driven(unfolding.sides)
    if not any(driven):
        return None
    groups = [name for name in _below(frame.symmetry) if _fits_start(name, unfolding.sides, driven)]
    choices = []
    for group in groups:
        mirrored = _mirrored(group)
        exact, near = lattices(unfolding.all_corners, mirrored, surface.precision)
        if not exact:
            exact, near = lattices(unfolding.corners, mirrored, surface.precision)
        if scale is not None:
            exact = [one for one in exact if abs(one.scale / scale - 1.0) < 1e-6]
            near = Lattice(scale, 0, 0.0)
        choices += [
            _choice(surface, unfolding, driven, fold, group, one, is_exact)
            for one, is_exact in [*((one, True) for one in exact), (near, False)]
        ]
    choices = [choice for choice in choices if _can_begin(choice)]
    # small boards first, and on each the most symmetry; the first on board points, else the first that fits
    order = {name: rank for rank, name in enumerate(("xy", "y", "x", "none"))}
    choices.sort(key=lambda c: (_half(c), order[c.symmetry]))
    fitting = [c for c in choices if _half(c) <= MOST_HALF]
    roomy = [c for c in fitting if _has_room(c)]
    for some in (
        [c for c in roomy if c.is_exact],
        [c for c in fitting if c.is_exact],
        roomy,
        fitting,
    ):
        if some:
            return some[0]
    return None


def _choice(
    surface: PartSurface,
    unfolding: Unfolding,
    driven: tuple[bool, ...],
    fold: float,
    group: Group,
    one: Lattice,
    exact: bool,
) -> PartLayout:
    corners = tuple(corners_between(unfolding.sides, driven, one.scale))
    mirrored = _mirrored(group)
    flat = unfolding.corners * one.scale
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    first = flat[0]
    # the middle of the board, or half a cell beside it: always the same one, whichever corner came first
    shift = np.where(mirrored, 0.0, np.floor(first - middle + 0.5 - TIE) - first)
    return PartLayout(unfolding, driven, fold, one, exact, corners, group, shift)


def _half(layout: PartLayout) -> int:
    """Cells from the middle of the board to its edge, in the longer direction."""
    return max(_halves(layout))


def _halves(layout: PartLayout) -> tuple[int, int]:
    """Half the sides of the board: room for the unfolded part and for what is tucked away at its corners."""
    near, further = (
        points * layout.lattice.scale + layout.shift for points in (layout.unfolding.corners, layout.unfolding.further)
    )
    # what hangs on a wall may as well hang on the one opposite
    opposite = near.min(axis=0) + near.max(axis=0) - further
    extent = np.abs(np.concatenate([near, further, opposite])).max(axis=0)
    if not layout.is_exact:
        extent = extent + 1.0
    for corner in layout.corners:
        reach = corner.reach if corner.reach <= FAR * corner.height + TIE else ROOM * corner.height
        extent = np.maximum(extent, np.abs(np.array(corner.place) + layout.shift) + reach)
    start = np.abs(_start_points(layout)).max(axis=0) + 1
    wide, high = (max(2, math.ceil(float(t) - TIE)) for t in np.maximum(extent, start))
    return wide, high


def _has_room(layout: PartLayout) -> bool:
    """Whether the part is large enough to be played: sides with room for the start pattern, and walls."""
    scale, sides = layout.lattice.scale, layout.unfolding.sides
    if max(side.length for side in sides) * scale < 2.0 - TIE or _across(layout) < LEAST_CELLS - TIE:
        return False
    if any(corner.height < LEAST_WALL - TIE for corner in layout.corners if corner.height > 0.0):
        return False
    for k, side in enumerate(sides):
        if layout.driven[k]:
            free = 2 - layout.driven[k - 1] - layout.driven[(k + 1) % len(sides)]
            if side.length * scale < 1.0 + free - TIE:
                return False
    return True


def _can_begin(layout: PartLayout) -> bool:
    """Whether no driven side is so short, at a given scale, that both its ends come to lie on one board point."""
    ends = [
        np.rint(layout.lattice.scale * np.array([side.start, side.end]) + layout.shift)
        for side, is_driven in zip(layout.unfolding.sides, layout.driven, strict=True)
        if is_driven
    ]
    return all((start != end).any() for start, end in ends)


def _across(layout: PartLayout) -> float:
    """The longer side of the unfolded part, cells."""
    return float(np.ptp(layout.unfolding.all_corners, axis=0).max()) * layout.lattice.scale


def _driven(sides: Sequence[BaseSide]) -> tuple[tuple[bool, ...], float]:
    """The sides of the base about which one driving angle folds walls, the most by length; and that angle."""
    lengths: dict[float, float] = {}
    for side in sides:
        if side.wall >= 0 and 1.0 <= abs(side.fold) <= 179.0:
            angle = next((known for known in lengths if abs(known - abs(side.fold)) < 1e-2), abs(side.fold))
            lengths[angle] = lengths.get(angle, 0.0) + side.length
    if not lengths:
        return (False,) * len(sides), 0.0
    fold = max(lengths, key=lambda angle: (round(lengths[angle] / max(lengths.values()), 4), angle))
    return tuple(side.wall >= 0 and abs(abs(side.fold) - fold) < 1e-2 for side in sides), fold


def _below(symmetry: Group) -> tuple[Group, ...]:
    """The groups to choose from: the part's own, and those within it; diagonals would tuck paper to both walls."""
    return {
        "xyd": ("xy", "y", "x", "none"),
        "xy": ("xy", "y", "x", "none"),
        "y": ("y", "none"),
        "x": ("x", "none"),
    }.get(symmetry, ("none",))


def _mirrored(group: Group) -> tuple[bool, bool]:
    """Whether x, and whether y, is mirrored."""
    return group in ("y", "xy", "xyd"), group in ("x", "xy", "xyd")


def _fits_start(group: Group, sides: Sequence[BaseSide], driven: Sequence[bool]) -> bool:
    """Whether the start pattern has a symmetry: of a single crease, no mirror may exchange its panels."""
    if sum(driven) > 1 or group == "none":
        return True
    side = next(side for side, is_driven in zip(sides, driven, strict=True) if is_driven)
    across = np.abs(side.end - side.start) / side.length
    return group == ("y" if across[0] > 0.5 else "x") and bool(across.min() < 1e-6)


def _start_points(layout: PartLayout) -> Array:
    """(n, 2) the ends of the driven sides, drawn in where a side ends freely, round the base; board points if exact."""
    sides, driven = layout.unfolding.sides, layout.driven
    points: list[Array] = []
    for k, side in enumerate(sides):
        if not driven[k]:
            continue
        start, end = (np.rint(layout.lattice.scale * point + layout.shift) for point in (side.start, side.end))
        along = (end - start).astype(int)
        step = along / max(1, math.gcd(*(abs(int(t)) for t in along)))
        if not driven[k - 1] and np.abs(along).max() > 1:
            start = start + step
        if not driven[(k + 1) % len(sides)] and (end - start - step).any():
            end = end - step
        points += [start, end]
    distinct = [point for i, point in enumerate(points) if i == 0 or (point != points[i - 1]).any()]
    if len(distinct) > 1 and (distinct[0] == distinct[-1]).all():
        distinct.pop()
    return np.array(distinct)


def start_of(layout: PartLayout) -> dict[str, Any]:
    """The start pattern of a flat-faced part: its base, as far as walls hang on it."""
    points = _start_points(layout).astype(int)
    corners = [[int(x), int(y)] for x, y in points]
    sides = [side for side, is_driven in zip(layout.unfolding.sides, layout.driven, strict=True) if is_driven]
    if len(sides) == 1 or not _is_convex(points):
        longest = max(range(len(sides)), key=lambda k: sides[k].length)
        return _crease(layout, sides[longest])
    signs = [_sign_after(layout, points, k) for k in range(len(points))]
    first = corners.index(min(corners))
    corners, signs = corners[first:] + corners[:first], signs[first:] + signs[:first]
    if next(sign for sign in signs if sign) < 0:
        signs = [-sign for sign in signs]
    return {"_target_": "origami_lab.game.Panel", "corners": corners, "signs": signs}


def _crease(layout: PartLayout, side: BaseSide) -> dict[str, Any]:
    """A single crease along a side of the base, whose panel stays in the plane."""
    alone = PartLayout(
        layout.unfolding,
        tuple(other is side for other in layout.unfolding.sides),
        *(layout.fold, layout.lattice, layout.is_exact, (), layout.symmetry, layout.shift),
    )
    start, end = _start_points(alone)
    ends = sorted([[int(t) for t in start], [int(t) for t in end]])
    forward = bool((start <= end).all()) if start[0] == end[0] else bool(start[0] < end[0])
    # the base is on the left from start to end; the left of the way from the first end to the second is above
    return {
        "_target_": "origami_lab.game.Crease",
        "position": 0,
        "ends": ends,
        "stays": "upper" if forward else "lower",
    }


def _sign_after(layout: PartLayout, points: Array, k: int) -> int:
    """The sign of the side of the start panel after its k-th corner: that of the driven side which it is part of."""
    middle = (0.5 * (points[k] + points[(k + 1) % len(points)]) - layout.shift) / layout.lattice.scale
    for side, is_driven in zip(layout.unfolding.sides, layout.driven, strict=True):
        along = (side.end - side.start) / side.length
        across = abs(float(np.cross(along, middle - side.start)))
        if is_driven and across * layout.lattice.scale < 0.75 and 0.0 < along @ (middle - side.start) < side.length:
            return 1 if side.fold > 0.0 else -1
    return 0


def _is_convex(points: Array) -> bool:
    if not 3 <= len(points) <= 16:
        return False
    sides = np.roll(points, -1, axis=0) - points
    turns = np.cross(sides, np.roll(sides, -1, axis=0))
    return bool((turns > 0).all())


def flat_setup(layout: PartLayout, frame: PartFrame, closed: bool) -> PartSetup:
    """The settings for a flat-faced part."""
    wide, high = _halves(layout)
    scale = layout.lattice.scale
    return PartSetup(
        rotate=rotation_angles(frame.rotation),
        scale=scale,
        translate=_translation(frame, scale, np.append(layout.shift, 0.0)),
        symmetry=layout.symmetry,
        start=start_of(layout),
        board=(2 * wide + 1, 2 * high + 1),
        max_crease_length=None,
        driving_angle_max=layout.fold - (SHORT_OF_LIMIT if closed else 0.0),
        driving_angle_count=FLAT_ANGLES,
        source_action=True,
    )


def curved_setup(surface: PartSurface, frame: PartFrame, scale: float | None = None) -> PartSetup:
    """The settings for a part with curved regions, or whose flat ones do not hang on one base."""
    placed = frame.placed(surface.vertices)
    half = 0.5 * np.ptp(placed, axis=0)[:2]
    height = float(np.abs(placed[:, 2]).max())
    wide, high = half + height
    aspect = 1.0 if frame.symmetry == "xyd" else float(np.clip(wide / high, 0.4, 2.5))
    if 1.0 / NEARLY_SQUARE < aspect < NEARLY_SQUARE:
        aspect = 1.0
    board = tuple(2 * round(0.5 * (CURVED_BOARD * math.sqrt(share) - 1.0)) + 1 for share in (aspect, 1.0 / aspect))
    reach = [CURVED_SHARE * 0.5 * (points - 1) for points in board]
    if scale is None:
        scale = min(reach[0] / float(wide), reach[1] / float(high))
    return PartSetup(
        rotate=rotation_angles(frame.rotation),
        scale=scale,
        translate=_translation(frame, scale, np.zeros(3)),
        symmetry=frame.symmetry,
        start={"_target_": "origami_lab.game.Square", "size": "choose", "position": None},
        board=(board[0], board[1]),
        max_crease_length=CURVED_CREASE,
        driving_angle_max=LARGEST_ANGLE,
        driving_angle_count=CURVED_ANGLES,
        source_action=True,
    )


def rotation_angles(rotation: Array) -> tuple[float, float, float]:
    """Degrees about the fixed x, then y, then z axis; those that are whole as far as doubles tell are whole."""
    from scipy.spatial.transform import Rotation

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # at a quarter turn about y there are several, and any will do
        a = Rotation.from_matrix(rotation).as_euler("xyz", degrees=True)
    x, y, z = (float(round(angle)) + 0.0 if abs(angle - round(angle)) < 1e-9 else float(angle) for angle in a)
    return x, y, z


def _translation(frame: PartFrame, scale: float, shift: Array) -> tuple[float, float, float]:
    x, y, z = (float(t) + 0.0 for t in shift - scale * (frame.rotation @ frame.origin))
    return x, y, z
