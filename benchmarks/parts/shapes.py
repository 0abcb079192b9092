"""Everyday parts in millimetres, made by code, as binary STL: ``python -m benchmarks.parts.shapes FOLDER``."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = Sequence[float]


def flat(*polygons: Sequence[Point]) -> Array:
    """(F, 3, 3) triangles of convex polygons."""
    triangles = [(ring[0], ring[k], ring[k + 1]) for ring in polygons for k in range(1, len(ring) - 1)]
    return np.array(triangles, dtype=np.float64)


def patch(place: Callable[[Array, Array], tuple[Array, Array, Array]], nu: int, nv: int) -> Array:
    """(F, 3, 3) triangles of a surface over the unit square, its diagonals mirrored about the middle of both sides."""
    u, v = np.meshgrid(np.linspace(0, 1, nu + 1), np.linspace(0, 1, nv + 1), indexing="ij")
    points = np.stack(place(u, v), axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    rising = ((u[:-1, :-1] + u[1:, 1:] - 1) * (v[:-1, :-1] + v[1:, 1:] - 1) >= 0)[..., None, None]
    first = np.where(rising, np.stack([a, b, c], axis=2), np.stack([a, b, d], axis=2))
    second = np.where(rising, np.stack([a, c, d], axis=2), np.stack([b, c, d], axis=2))
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])


def floor(x: float, y: float) -> list[Point]:
    return [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)]


def l_bracket() -> Array:
    """A floor of 80 by 50 with a wall of 40 along its long side: a single fold."""
    return flat([(0, 0, 0), (80, 0, 0), (80, 50, 0), (0, 50, 0)], [(0, 50, 0), (80, 50, 0), (80, 50, 40), (0, 50, 40)])


def gutter() -> Array:
    """A channel 200 long, 60 wide and 50 high, open at its ends."""
    walls = [[(-100, s * 30, 0), (100, s * 30, 0), (100, s * 30, 50), (-100, s * 30, 50)] for s in (-1, 1)]
    return flat(floor(100, 30), *walls)


def gutter_caps() -> Array:
    """The same with end caps."""
    caps = [[(s * 100, -30, 0), (s * 100, 30, 0), (s * 100, 30, 50), (s * 100, -30, 50)] for s in (-1, 1)]
    return np.concatenate([gutter(), flat(*caps)])


def _box(x: float, y: float, z: float, out: float = 0.0) -> Array:
    low, high = floor(x, y), [(px * (1 + out / x), py * (1 + out / y), z) for px, py, _ in floor(x, y)]
    return flat(low, *[[low[k - 1], low[k], high[k], high[k - 1]] for k in range(4)])


def box_lid() -> Array:
    """A lid of 120 by 80 with a rim of 20."""
    return _box(60, 40, 20)


def flared_tray() -> Array:
    """A tray of 80 by 60 whose walls lean outward: 30 for 40 of height."""
    return _box(40, 30, 40, out=30)


def box_with_flaps() -> Array:
    """An open box of 120 by 80 by 20 whose flaps, 20 wide, stand out level on all sides."""
    flaps = [[(-60, s * 40, 20), (60, s * 40, 20), (60, s * 60, 20), (-60, s * 60, 20)] for s in (-1, 1)]
    flaps += [[(s * 60, -40, 20), (s * 60, 40, 20), (s * 80, 40, 20), (s * 80, -40, 20)] for s in (-1, 1)]
    return np.concatenate([box_lid(), flat(*flaps)])


def corner_guard() -> Array:
    """Three squares of 60 that meet in a corner."""
    a = 60
    return flat([(0, 0, 0), (a, 0, 0), (a, a, 0), (0, a, 0)], [(0, 0, 0), (a, 0, 0), (a, 0, a), (0, 0, a)],
                [(0, 0, 0), (0, a, 0), (0, a, a), (0, 0, a)])  # fmt: skip


def asymmetric_tray() -> Array:
    """A dustpan: a floor of 120 by 80 with walls of 20 at its back and at one side, none elsewhere."""
    return flat(floor(60, 40), [(-60, 40, 0), (60, 40, 0), (60, 40, 20), (-60, 40, 20)],
                [(-60, -40, 0), (-60, 40, 0), (-60, 40, 20), (-60, -40, 20)])  # fmt: skip


def gable_roof() -> Array:
    """Two slopes of 120 by 50 that meet in a ridge, 30 high."""
    return flat(*[[(-60, 0, 30), (60, 0, 30), (60, s * 40, 0), (-60, s * 40, 0)] for s in (-1, 1)])


def shallow_dome() -> Array:
    """A cap of 150 across and 25 high."""
    radius = (75**2 + 25**2) / 50

    def place(u: Array, v: Array) -> tuple[Array, Array, Array]:
        s, t = 2 * u - 1, 2 * v - 1
        x, y = 75 * s * np.sqrt(1 - t * t / 2), 75 * t * np.sqrt(1 - s * s / 2)
        return x, y, np.sqrt(np.maximum(radius**2 - x * x - y * y, 0)) - radius + 25

    return patch(place, 24, 24)


def half_vault() -> Array:
    """Half a cylinder of radius 40, 120 long."""
    return patch(lambda u, v: (120 * u - 60, -40 * np.cos(np.pi * v), 40 * np.sin(np.pi * v)), 12, 32)


def saddle() -> Array:
    """A hyperbolic paraboloid over 120 by 120, its corners 20 up and down from the middle of its sides."""
    return patch(lambda u, v: (120 * u - 60, 120 * v - 60, 20 * ((2 * u - 1) ** 2 - (2 * v - 1) ** 2)), 24, 24)


def hyperbolic_canopy() -> Array:
    """A shade sail over 140 by 140: two opposite corners 30 up, two down."""
    return patch(lambda u, v: (140 * u - 70, 140 * v - 70, 30 * (2 * u - 1) * (2 * v - 1)), 24, 24)


def lampshade() -> Array:
    """A cone's frustum of 100 to 60 across, 70 high, open above and below."""

    def place(u: Array, v: Array) -> tuple[Array, Array, Array]:
        radius, angle = 50 - 20 * v, 2 * np.pi * u
        return radius * np.cos(angle), radius * np.sin(angle), 70 * v

    return patch(place, 64, 8)


def car_seat() -> Array:
    """A seat's shell, 100 wide: level in front, rising to a back, and hollow across."""

    def place(u: Array, v: Array) -> tuple[Array, Array, Array]:
        x, along = 100 * u - 50, 180 * v
        bend = np.clip((along - 80) / 40, 0, 1)
        angle = 1.2 * bend
        start = np.minimum(along, 80)
        arc = 40 / 1.2
        y = start + arc * np.sin(angle) + np.cos(1.2) * np.maximum(along - 120, 0)
        z = arc * (1 - np.cos(angle)) + np.sin(1.2) * np.maximum(along - 120, 0)
        rim = 12 * (x / 50) ** 2
        return x, y - rim * np.sin(angle), z + rim * np.cos(angle)

    return patch(place, 20, 36)


def closed_box() -> Array:
    """A solid block of 80 by 60 by 40."""
    walls = _box(40, 30, 40)
    return np.concatenate([walls, flat([(x, y, 40) for x, y, _ in floor(40, 30)][::-1])])


def _block(low: Point, high: Point) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[low, high])


def thick_bracket() -> Array:
    """The L-bracket as it comes from a CAD program, of sheet metal 3 thick: a solid."""
    return np.asarray(_block((0, 0, 0), (80, 50, 3)).union(_block((0, 47, 0), (80, 50, 40))).triangles)


def bent_bracket() -> Array:
    """The same bent about a radius of 4.5 outside."""
    turns = [(-math.pi / 2 + math.pi / 2 * k / 8) for k in range(9)]

    def profile(radius: float, inward: float) -> list[tuple[float, float]]:
        arc = [(45.5 + radius * math.cos(turn), 4.5 + radius * math.sin(turn)) for turn in turns]
        return [(0.0, inward), *arc, (50.0 - inward, 40.0)]

    outline = profile(4.5, 0.0) + profile(1.5, 3.0)[::-1]
    solid = manifold3d.CrossSection([np.array(outline)]).extrude(80.0).to_mesh()
    along = np.asarray(solid.vert_properties, dtype=np.float64)[:, [2, 0, 1]]  # it lies as the others do
    return np.asarray(along[np.asarray(solid.tri_verts)])


def thick_lid() -> Array:
    """The lid with walls 2 thick: a solid."""
    return np.asarray(_block((-60, -40, 0), (60, 40, 20)).difference(_block((-58, -38, 2), (58, 38, 21))).triangles)


PARTS: dict[str, Callable[[], Array]] = {
    make.__name__: make
    for make in (
        *(
            l_bracket,
            gutter,
            gutter_caps,
            box_lid,
            flared_tray,
            box_with_flaps,
            corner_guard,
            asymmetric_tray,
            gable_roof,
        ),
        *(
            closed_box,
            thick_bracket,
            bent_bracket,
            thick_lid,
            shallow_dome,
            half_vault,
            saddle,
            hyperbolic_canopy,
            lampshade,
            car_seat,
        ),
    )
}


def stl(triangles: Array) -> bytes:
    """Binary STL of (F, 3, 3) triangles."""
    records = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    a, b, c = np.moveaxis(triangles, 1, 0)
    normals = np.cross(b - a, c - a)
    records["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    records["corners"] = triangles
    return b"a part for origami-lab".ljust(80) + np.uint32(len(triangles)).tobytes() + records.tobytes()


def write_parts(folder: Path) -> list[Path]:
    """All parts as files of a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, make in PARTS.items():
        file = folder / f"{name}.stl"
        file.write_bytes(stl(make()))
        files.append(file)
    return files


if __name__ == "__main__":
    for written in write_parts(Path(sys.argv[1])):
        print(written)
