"""How a part is to lie on the board: which side is down, how it is turned, where its middle is, and its symmetry.

All is read from the shape alone, so that a part that comes turned, shifted or in other units comes to lie as before.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from origami_lab.geometry.groups import GROUPS
from origami_lab.parts.flat_region import FlatRegion
from origami_lab.parts.surface import Array, PartSurface
from origami_lab.targets.target import Target

FLAT_SHARE = 0.99
"""Of the area, in flat regions: such a part is flat-faced."""
MOST_FACES = 60
"""Flat regions of a flat-faced part: what has more is a curved one, coarsely meshed."""
FEW_FACES, FAINT = 6, 20.0
"""So many flat regions are meant as such; where more meet at fewer degrees than that, mostly, they are a curve's."""
BASE_SHARE = 0.08
"""Of the area that a flat region of a curved part must have to be its floor."""
BASE_TILT = math.cos(math.radians(30.0))
"""A floor of an open curved part leans no more than this against the way that the part opens."""
OPENS = 0.1
"""Vector area as a part of the area, above which a surface has a way that it opens."""
SAME = 1e-4
"""Relative difference of two measures of a part below which they count as equal."""
UNSURE = 4.0
"""A turned vertex, measured from a computed middle, is so many precisions uncertain."""
MOST_DIRECTIONS = 72
SNAPPED = 1e-9


@dataclass(frozen=True, eq=False)
class PartFrame:
    """A place on the board: where the file's points come to lie, but for the scale."""

    rotation: Array
    """(3, 3) the board's axes, as rows, in those of the file."""
    origin: Array
    """(3,) the point of the file that comes to lie in the middle of the sheet."""
    symmetry: str
    """The largest group of the board that the part has about its origin."""
    base: int | None
    """The flat region that lies in the plane of the sheet; None if there is none."""
    on_surface: bool
    """Whether the part has a surface in the middle of the sheet, so that the sheet can begin there."""

    def placed(self, points: Array) -> Array:
        """Points of the file (..., 3) where they come to lie, in units of the file."""
        return np.asarray((points - self.origin) @ self.rotation.T)


def is_flat_faced(surface: PartSurface, regions: Sequence[FlatRegion]) -> bool:
    """Whether a part consists of flat regions, a few, with sharp edges between them."""
    share = sum(region.area for region in regions) / surface.area
    if share < FLAT_SHARE or len(regions) > MOST_FACES:
        return False
    hinges = [side for region in regions for side in region.outline if side.neighbour >= 0]
    faint = sum(side.length for side in hinges if abs(side.fold) < FAINT)
    return len(regions) <= FEW_FACES or 2.0 * faint < sum(side.length for side in hinges)


def find_frame(surface: PartSurface, regions: Sequence[FlatRegion], rotation: Array | None = None) -> PartFrame:
    """The frame of a part; with a rotation, (3, 3) as in :class:`PartFrame`, it is not turned otherwise."""
    base = _base(surface, regions, rotation)
    candidates = []
    if rotation is not None:
        candidates.append(_frame(surface, rotation, regions, base, None))
    for axes in _rotations(surface, regions, base) if rotation is None else ():
        # a quarter turn, or the other way up, exchanges the mirrors at most
        known = candidates[-1].symmetry if candidates else None
        exchanged = {"x": "y", "y": "x"}
        candidates.append(_frame(surface, axes, regions, base, None if known is None else exchanged.get(known, known)))
    compare = functools.cmp_to_key(_compare)
    return max(candidates, key=lambda frame: compare(_signature(surface, frame)))


def _base(surface: PartSurface, regions: Sequence[FlatRegion], rotation: Array | None) -> int | None:
    """The flat region to begin with: with its walls it has most of the area."""
    if not regions:
        return None
    allowed = list(range(len(regions)))
    if rotation is not None:
        allowed = [k for k in allowed if abs(regions[k].normal @ rotation[2]) > math.cos(math.radians(1e-3))]
    if is_flat_faced(surface, regions):
        # of a solid the widest side, from which the walls are shortest
        with_walls = {k: 0.0 if surface.is_closed else _walls(regions, k) for k in allowed}
        scores: dict[int, tuple[float, ...]]
        scores = {k: (regions[k].area + with_walls[k], regions[k].area) for k in allowed}
        return _largest(scores, surface.area)
    opens = surface.vector_area
    if np.linalg.norm(opens) > OPENS * surface.area:
        opens = opens / np.linalg.norm(opens)
        allowed = [k for k in allowed if abs(regions[k].normal @ opens) >= BASE_TILT]
    scores = {k: (regions[k].area,) for k in allowed if regions[k].area >= BASE_SHARE * surface.area}
    return _largest(scores, surface.area)


def _walls(regions: Sequence[FlatRegion], k: int) -> float:
    """The area of the regions that one driving angle can fold about the sides of a region."""
    areas: dict[float, dict[int, float]] = {}
    for side in regions[k].outline:
        if side.neighbour >= 0:
            angle = next((known for known in areas if abs(known - abs(side.fold)) < 1e-2), abs(side.fold))
            areas.setdefault(angle, {})[side.neighbour] = regions[side.neighbour].area
    return max((sum(found.values()) for found in areas.values()), default=0.0)


def _largest(scores: dict[int, tuple[float, ...]], area: float) -> int | None:
    best: int | None = None
    for k, score in scores.items():
        if best is None or _compare([s / area for s in score], [s / area for s in scores[best]]) > 0:
            best = k
    return best


def _rotations(surface: PartSurface, regions: Sequence[FlatRegion], base: int | None) -> Iterator[Array]:
    """The rotations to choose from: two ways up, and turned by quarters."""
    up = regions[base].normal if base is not None else _up(surface)
    turned = _edges_direction(regions[base]) if base is not None and is_flat_faced(surface, regions) else None
    x = _direction(surface, up) if turned is None else turned
    x = x - (x @ up) * up
    x = x / np.linalg.norm(x)
    for z in (up, -up):
        y = np.cross(z, x)
        for a, b in ((x, y), (y, -x), (-x, -y), (-y, x)):
            yield _snapped(np.stack([a, b, z]), max(SNAPPED, UNSURE * surface.precision / surface.size))


def _snapped(rotation: Array, unsure: float) -> Array:
    """A rotation that is one of the cube's as far as can be told, as that one."""
    whole = np.rint(rotation)
    return whole if float(np.abs(rotation - whole).max()) <= unsure else rotation


def _up(surface: PartSurface) -> Array:
    """The way a surface opens or, of one that opens nowhere, along which it is spread least."""
    opens = surface.vector_area
    if np.linalg.norm(opens) > OPENS * surface.area:
        return np.asarray(opens / np.linalg.norm(opens))
    _, axes = np.linalg.eigh(surface.moments[0])
    return np.asarray(axes[:, 0])


def _edges_direction(region: FlatRegion) -> Array:
    """The direction that most of a region's sides have, by length, up to quarter turns; hinged ones count twice."""
    sides = [side for outline in region.outlines for side in outline]
    x = (sides[0].end - sides[0].start) / sides[0].length
    y = np.cross(region.normal, x)
    angles = np.array([math.atan2((s.end - s.start) @ y, (s.end - s.start) @ x) for s in sides])
    lengths = np.array([side.length * (2.0 if side.neighbour >= 0 else 1.0) for side in sides])
    off = np.abs((angles[:, None] - angles[None, :] + math.pi / 4) % (math.pi / 2) - math.pi / 4)
    weights = (lengths[None, :] * (off < 1e-3)).sum(axis=1)
    best = int(
        np.nonzero(weights >= weights.max() * (1.0 - SAME))[0][
            np.argmax(lengths[weights >= weights.max() * (1.0 - SAME)])
        ]
    )
    return np.asarray(math.cos(angles[best]) * x + math.sin(angles[best]) * y)


def _direction(surface: PartSurface, z: Array) -> Array:
    """The direction across z that a mirror of the part has or, if it has none, along which it is widest."""
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    across = np.stack([x, y])
    values, axes = np.linalg.eigh(across @ surface.moments[0] @ across.T)
    principal = axes[0, 1] * x + axes[1, 1] * y
    if values[1] - values[0] > 10.0 * SAME * values[1]:
        return np.asarray(principal)
    corners = (surface.vertices - surface.centroid) @ across.T
    radii = np.hypot(*corners.T)
    far = corners[radii >= radii.max() - max(4.0 * surface.precision, SAME * radii.max())]
    angles = np.sort(np.arctan2(far[:, 1], far[:, 0]) % (math.pi / 2))
    angles = angles[np.append(True, np.diff(angles) > 1e-4)][:MOST_DIRECTIONS]
    between = 0.5 * (angles + np.roll(angles, -1)) + np.where(np.arange(len(angles)) == len(angles) - 1, math.pi / 4, 0)
    best: tuple[int, Array] = -1, principal
    for angle in [*angles, *between]:
        direction = math.cos(angle) * x + math.sin(angle) * y
        rank = _RANK[_symmetry(surface, np.stack([direction, np.cross(z, direction), z]), surface.centroid)]
        if rank > best[0]:
            best = rank, direction
        if rank == _RANK["xyd"]:
            break
    return np.asarray(best[1])


_RANK = {name: rank for rank, name in enumerate(("none", "x", "y", "xy", "xyd"))}


def _frame(
    surface: PartSurface, rotation: Array, regions: Sequence[FlatRegion], base: int | None, symmetry: str | None
) -> PartFrame:
    """The frame with a rotation, and its symmetry, if that is known."""
    turned = surface.vertices @ rotation.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    middle = 0.5 * (low + high)
    heights = _heights(turned[surface.faces], middle[:2], surface.precision)
    if base is not None:
        middle[2] = float((regions[base].centroid @ rotation.T)[2])
    else:
        middle[2] = float(heights.min()) if len(heights) else low[2]
    origin = middle @ rotation
    symmetry = _symmetry(surface, rotation, origin) if symmetry is None else symmetry
    return PartFrame(rotation, origin, symmetry, base, base is not None or bool(len(heights)))


def _heights(triangles: Array, place: Array, precision: float) -> Array:
    """The heights at which the vertical line through a place (x, y) meets triangles (F, 3, 3)."""
    a, b, c = np.moveaxis(triangles[:, :, :2] - place, 1, 0)
    weights = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    area = weights.sum(axis=1)
    usable = np.abs(area) > precision * precision
    weights = weights[usable] / area[usable, None]
    hit = (weights >= -1e-6).all(axis=1)
    return np.asarray((weights[hit] * triangles[usable][hit][:, :, 2]).sum(axis=1))


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _symmetry(surface: PartSurface, rotation: Array, origin: Array) -> str:
    """The largest group that a part has about the vertical axis through a point."""
    target: Target | None = None

    def has(matrix: Array) -> bool:
        nonlocal target
        image = np.eye(3)
        image[:2, :2] = matrix
        if not _has_moments(surface, rotation, origin, image):
            return False
        if target is None:
            vertices = (surface.vertices - origin) @ rotation.T
            target = Target("part", vertices, surface.faces, False, uncertainty=UNSURE * surface.precision)
        return target.is_symmetric(matrix)

    group = GROUPS["xyd"]
    across, along, diagonal = (has(group.matrices[k]) for k in (1, 2, 4))
    if across and along:
        return "xyd" if diagonal else "xy"
    return "y" if across else "x" if along else "none"


def _has_moments(surface: PartSurface, rotation: Array, origin: Array, image: Array) -> bool:
    """Whether a part's moments are those of its image: cheap, and nearly no part passes that is not symmetric."""
    first = rotation @ (surface.centroid - origin) / surface.size
    _, second, third = _turned_moments(surface, rotation)
    return all(
        float(np.abs(a - b).max()) <= SAME
        for a, b in (
            (first, image @ first),
            (second, image @ second @ image.T),
            (third, np.einsum("il,jm,kn,lmn->ijk", image, image, image, third, optimize=True)),
        )
    )


def _turned_moments(surface: PartSurface, rotation: Array) -> tuple[Array, Array, Array]:
    """The middle of a part's area, and its moments, in turned axes."""
    second, third = surface.moments
    turned = np.einsum("il,jm,kn,lmn->ijk", rotation, rotation, rotation, third, optimize=True)
    return rotation @ surface.centroid, rotation @ second @ rotation.T, np.asarray(turned)


def _signature(surface: PartSurface, frame: PartFrame) -> list[float]:
    """Measures of a placed part, by which the frame is chosen: the first that differs counts, the larger wins.

    The part is to rise above the sheet, to have as much symmetry as the board's groups can say, to be wider than deep,
    and to have most of its area at larger y, then at larger x.
    """
    width, depth, _ = np.ptp(frame.placed(surface.vertices), axis=0) / surface.size
    x, y, z = frame.placed(surface.centroid) / surface.size
    _, m, t = _turned_moments(surface, frame.rotation)
    odd = (m[1, 2], m[0, 2], t[1, 1, 1], t[0, 0, 0], t[0, 0, 1], t[0, 1, 1], t[1, 2, 2], t[0, 2, 2])
    even = (m[0, 0] - m[1, 1], t[0, 0, 2] - t[1, 1, 2], t[2, 2, 2], m[0, 1], t[0, 1, 2])
    measures = (z, _RANK[frame.symmetry], width - depth, y, x, *(10.0 * measure for measure in (*odd, *even)))
    return [float(measure) for measure in measures]


def _compare(first: Sequence[float], second: Sequence[float]) -> int:
    for a, b in zip(first, second, strict=True):
        if abs(a - b) > SAME:
            return 1 if a > b else -1
    return 0
