"""The paper's abstract objectives in plain NumPy on whole sheets: the oracle of the kernels, written from the formulas.

Each function takes a sheet and the index of an angle. Nothing here knows representatives, images or pruning.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from origami_lab.game.folded_sheet import FoldedSheet

Floats = NDArray[np.float64]
AtAngle = Callable[[FoldedSheet, int], float]


def bucket(sheet: FoldedSheet, k: int) -> float:
    """A corner of the square that the first action lays is as far from both axes as it is half wide."""
    rules, action = sheet.rules[0], int(sheet.states["actions"][sheet.index][0])
    points = (2 * int(rules["half_x"]) + 1) * (2 * int(rules["half_y"]) + 1)
    half = int(rules["first_placement"]) + (action - 3 * points - 5) // 2
    placed = np.abs(sheet.flat).max(axis=1) > half
    placed |= np.abs(sheet.flat).min(axis=1) < half
    return _bucket(sheet, k, placed)


def bucket_by_its_rim(sheet: FoldedSheet, k: int) -> float:
    rim = np.zeros(len(sheet.flat), dtype=bool)
    rim[sheet.leaves] = True
    return _bucket(sheet, k, rim)


def _bucket(sheet: FoldedSheet, k: int, counts: NDArray[np.bool_]) -> float:
    z, away = sheet.points[k, sheet.leaves, 2], np.hypot(*sheet.points[k, counts, :2].T)
    apart = len(away) and away.max() > 2 * away.min() + 1e-9
    if z.min() <= 0 or z.max() > 2 * z.min() + 1e-9 or apart:
        return 0.0
    return float(z.min())


def planes(sheet: FoldedSheet, k: int) -> tuple[Floats, Floats, Floats]:
    """(T, 3) unit normals, (T,) distances from the origin along them, (T,) areas."""
    a, b, c = (sheet.points[k, sheet.triangles[:, j]] for j in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    normals /= lengths[:, None]
    return normals, (normals * a).sum(axis=1), lengths / 2


def shelf(sheet: FoldedSheet, k: int, levels: int = 3, gap: float = 0.5) -> float:
    normals, distances, areas = planes(sheet, k)
    count, sets = connected_components(np.abs(normals @ normals.T) > 0.99999)
    best = 0.0
    for number in range(count):
        members = np.flatnonzero(sets == number)
        offsets = distances[members] * np.sign(normals[members] @ normals[members[0]])
        found, level = connected_components(np.abs(offsets[:, None] - offsets[None]) < gap)
        if found >= levels:
            best = max(best, min(areas[members[level == i]].sum() for i in range(found)))
    return float(best)


def table(sheet: FoldedSheet, k: int) -> float:
    z = np.sort(sheet.points[k, :, 2])[::-1]
    rest = np.abs(z[4:]).mean() if len(z) > 4 else 0.0
    return float(-np.abs(z[:4] - 2.5).mean() - rest)


def chair(sheet: FoldedSheet, k: int) -> float:
    r_min = -2.0 * float(max(sheet.rules["half_x"][0], sheet.rules["half_y"][0]))
    x, y, z = sheet.points[k].T
    cost = np.abs(z + 4) + np.abs(np.abs(y) - 2.1)
    third = np.sort(z)[2]
    below, level = z < third - 1e-9, np.abs(z - third) <= 1e-9
    legs = np.concatenate([cost[below], np.sort(cost[level])[: 3 - below.sum()]])
    behind = z > 1e-9
    rest = abs(z.max() - 4) + (np.abs(np.abs(y[behind]) - 2.1).mean() if behind.any() else 0.0)
    value = -legs.mean() - rest
    if max(np.abs(x).max(), np.abs(y).max()) > 4 + 1e-6:
        value += r_min
    standing = y[below | level]
    if third - z.min() > 0.1 or (standing > 1e-9).all() or (standing < -1e-9).all():
        value += r_min / 2
    return float(value)


def packaging(sheet: FoldedSheet, k: int) -> float:
    areas = planes(sheet, k)[2]
    centroids = sheet.points[k, sheet.triangles].mean(axis=1)
    centroid = areas @ centroids / areas.sum()
    return float(areas.sum() / np.linalg.norm(sheet.points[k] - centroid, axis=1).max() ** 3)


def farthest(sheet: FoldedSheet, k: int) -> float:
    """Distance of the furthest vertex from the board's centre."""
    return float(np.linalg.norm(sheet.points[k], axis=1).max())


REFERENCES: dict[str, AtAngle] = {
    "bucket": bucket,
    "bucket by its rim": bucket_by_its_rim,
    "shelf": shelf,
    "table": table,
    "chair": chair,
    "packaging": packaging,
}
