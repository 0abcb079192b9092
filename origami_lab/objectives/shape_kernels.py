"""Kernels of the shape objective: how far the folded sheet strays from the target, and how well it covers it.

d→ (:func:`stray`) only grows as vertices are added, since a placed vertex never moves: its negative is the
monotone potential of the paper (section 3.6.1) and a true bound. d← (:func:`uncovered`) is the remainder.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.collisions import folded_place, place_corner
from origami_lab.game.kernels.state import Record, States, has_image, image_code
from origami_lab.geometry.bvh import Bvh, triangle_squared
from origami_lab.geometry.sampled import Sampled, nearest_sample_squared, sample_surface, sample_within_squared
from origami_lab.jit import bare, inlined, kernel
from origami_lab.objectives.known_places import Surface, strayed_squared

Array = NDArray[np.float64]


def memo_dtype(angles: int) -> np.dtype[np.void]:
    """Notes for one state: how many vertices were measured; at each driving angle d→ and the compactness penalty.

    And which part of the target the last measured place was nearest to, as the next one is likely near it, too.

    Records, so that plain Python reads their fields as the kernels do.
    """
    fields: list[Any] = [
        ("measured", np.int64),
        ("near", np.int64),
        ("stray", np.float64, (angles,)),
        ("penalty", np.float64, (angles,)),
    ]
    return np.dtype((np.record, np.dtype(fields, align=True)))


@inlined
def distance_from_centre(s: Record, v: int, k: int) -> float:
    """Distance of a vertex and its images from the board's centre, in space."""
    x, y, z = s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]
    return float(np.sqrt(x * x + y * y + z * z))


@bare
def stray(s: Record, r: Record, memo: Record, target: Surface, enough: float) -> float:
    """The smallest d→ + penalty over the usable reachable angles, from the vertices of a state.

    Vertices that were measured before are not measured again. At an angle whose sum has reached ``enough`` the rest is
    not measured: the returned value is then at least ``enough``, too.
    """
    first = r.min_reach - 1
    order = r.order if target.images else 1
    for v in range(memo.measured, s.n_vertices):
        if target.compactness > 0.0:
            for k in range(first, s.reach):
                memo.penalty[k] = max(memo.penalty[k], target.compactness * distance_from_centre(s, v, k))
        for g in range(order):
            if g > 0 and not has_image(r, s.axis[v], g):
                continue
            for k in range(first, s.reach):
                so_far = memo.stray[k]
                if so_far + memo.penalty[k] >= enough:
                    continue
                x, y, z = folded_place(s, r, 8 * v + g, k)
                squared, memo.near = strayed_squared(
                    target, x, y, z, so_far * so_far, enough * enough, memo.near, s.far
                )
                if squared > so_far * so_far:
                    memo.stray[k] = np.sqrt(squared)
    memo.measured = s.n_vertices
    best = np.inf
    for k in range(first, s.reach):
        best = min(best, memo.stray[k] + memo.penalty[k])
    return best


@bare
def stray_of(states: States, i: int, rules: States, memos: States, target: Surface, enough: float) -> float:
    """:func:`stray` of one of several states."""
    return stray(states[i], rules[0], memos[i], target, enough)


@inlined
def vertex_stray(
    s: Record, r: Record, v: int, k: int, target: Surface, start: float, enough: float, near: int
) -> tuple[float, int]:
    """max(start, distance of a vertex and its images from the target) at driving angle k, or at least ``enough``.

    And the part of the target that is nearest to the last of them; ``near`` is looked at first.
    """
    farthest = start
    for g in range(r.order if target.images else 1):
        if farthest >= enough or (g > 0 and not has_image(r, s.axis[v], g)):
            continue
        x, y, z = folded_place(s, r, 8 * v + g, k)
        squared, near = strayed_squared(target, x, y, z, farthest * farthest, enough * enough, near, s.far)
        if squared > farthest * farthest:
            farthest = np.sqrt(squared)
    return farthest, near


@bare
def stray_at(states: States, i: int, rules: States, k: int, target: Surface) -> float:
    """d→ of one of several states at driving angle k."""
    farthest, near = 0.0, 0
    for v in range(states[i].n_vertices):
        farthest, near = vertex_stray(states[i], rules[0], v, k, target, farthest, np.inf, near)
    return farthest


@bare
def write_folded(s: Record, r: Record, k: int, out: Array) -> None:
    """Write the corners of all triangles of the folded sheet, images included, at driving angle k."""
    row = 0
    for t in range(s.n_triangles):
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                for j in range(3):
                    place_corner(s, r, image_code(r, g, s.corners[t, j]), k, out[row], j)
                row += 1


@kernel
def folded_triangles(s: Record, r: Record, k: int) -> Array:
    """(T, 3, 3) corners of all triangles of the folded sheet, images included, at driving angle k."""
    count = 0
    for t in range(s.n_triangles):
        for g in range(r.order):
            if has_image(r, s.images[t], g):
                count += 1
    out = np.empty((count, 3, 3))
    write_folded(s, r, k, out)
    return out


@kernel
def folded_triangles_of(states: States, i: int, rules: States, k: int) -> Array:
    """:func:`folded_triangles` of one of several states."""
    return folded_triangles(states[i], rules[0], k)


@kernel
def uncovered(samples: Bvh, sheet: Sampled, start: float, enough: float, hint: NDArray[np.int64]) -> float:
    """max(start, the largest distance from a sample of the target to the folded sheet or the points drawn on it).

    Distance is 1-Lipschitz, so a box of samples is at most d(centre) + half its diagonal away. Returns a value of at
    least ``enough`` as soon as one is found.

    Parameters
    ----------
    samples
        Tree over the sample points as triangles without area.
    hint
        (1,) a sample to look at first; the one that decided is left there. It changes no result.
    """
    boxes, points = samples.boxes, samples.triangles
    count = points.shape[0]
    depth = 0
    while (2 << depth) < boxes.shape[0]:
        depth += 1
    best = start
    i = hint[0]
    cap = enough * enough
    d = np.sqrt(nearest_sample_squared(sheet, points[i, 0, 0], points[i, 0, 1], points[i, 0, 2], best * best, cap))
    best = max(best, d)
    stack = np.empty(64, np.int64)
    levels = np.empty(64, np.int64)
    stack[0], levels[0] = 1, 0
    size = 1
    while size > 0 and best < enough:
        size -= 1
        node, level = stack[size], levels[size]
        if level == depth:
            position = node - (1 << level)
            for i in range((count * position) >> level, (count * (position + 1)) >> level):
                d = np.sqrt(
                    nearest_sample_squared(sheet, points[i, 0, 0], points[i, 0, 1], points[i, 0, 2], best * best, cap)
                )
                if d > best:
                    best = d
                    hint[0] = i
            continue
        far, near = -1, -1
        far_squared = -1.0
        for child in (2 * node, 2 * node + 1):
            hx = 0.5 * (boxes[child, 3] - boxes[child, 0])
            hy = 0.5 * (boxes[child, 4] - boxes[child, 1])
            hz = 0.5 * (boxes[child, 5] - boxes[child, 2])
            limit = best - np.sqrt(hx * hx + hy * hy + hz * hz)
            limit_sq = limit * limit if limit >= 0.0 else -1.0
            squared = sample_within_squared(
                sheet, boxes[child, 0] + hx, boxes[child, 1] + hy, boxes[child, 2] + hz, limit_sq
            )
            if squared <= limit_sq:
                continue
            if squared > far_squared:
                near = far
                far, far_squared = child, squared
            else:
                near = child
        # the farther half is looked at first
        if near >= 0:
            stack[size], levels[size] = near, level + 1
            size += 1
        if far >= 0:
            stack[size], levels[size] = far, level + 1
            size += 1
    return best


@kernel
def uncovered_at(
    s: Record, r: Record, k: int, samples: Bvh, draws: Array, start: float, enough: float, hint: NDArray[np.int64]
) -> float:
    """:func:`uncovered` by the sheet folded to driving angle k, or the points of it that the draws choose."""
    triangles = folded_triangles(s, r, k)
    if enough < np.inf:
        # most angles fall at the sample that decided last, and without it the tree need not be built
        point = samples.triangles[hint[0], 0]
        squared = np.inf
        for t in range(triangles.shape[0]):
            squared = min(squared, triangle_squared(triangles, t, point[0], point[1], point[2]))
            if squared < enough * enough:
                break
        else:
            return enough
    return uncovered(samples, sample_surface(triangles, draws), start, enough, hint)


@kernel
def uncovered_of(
    states: States,
    i: int,
    rules: States,
    k: int,
    samples: Bvh,
    draws: Array,
    start: float,
    enough: float,
    hint: NDArray[np.int64],
) -> float:
    """:func:`uncovered_at` of one of several states."""
    return uncovered_at(states[i], rules[0], k, samples, draws, start, enough, hint)


@bare
def vertex_distance(
    s: Record, r: Record, memo: Record, samples: Bvh, draws: Array, enough: float, hint: NDArray[np.int64]
) -> tuple[float, int]:
    """The smallest max(d→, d←) + penalty over the usable angles and its index, if below ``enough``; else (inf, −1).

    d→ must have been measured by :func:`stray` with the same ``enough``.
    """
    best, angle = enough, -1
    if s.n_triangles == 0:
        return np.inf, -1
    tried = s.ahead
    for k in range(s.reach):
        tried[k] = 0
    for _ in range(r.min_reach - 1, s.reach):
        # the angle that strays least comes next
        k, least = -1, best
        for j in range(r.min_reach - 1, s.reach):
            if tried[j] == 0 and memo.stray[j] + memo.penalty[j] < least:
                k, least = j, memo.stray[j] + memo.penalty[j]
        if k < 0:
            break
        tried[k] = 1
        # compared without the penalty first: adding it again may round a refused distance below the best
        limit = best - memo.penalty[k]
        d = uncovered_at(s, r, k, samples, draws, memo.stray[k], limit, hint)
        if d < limit and d + memo.penalty[k] < best:
            best, angle = d + memo.penalty[k], k
    return (best, angle) if angle >= 0 else (np.inf, -1)


@bare
def least_distance(
    s: Record, r: Record, memo: Record, target: Surface, samples: Bvh, draws: Array, hint: NDArray[np.int64]
) -> float:
    """The smallest max(d→, d←) over the usable angles, infinite if there is none; compactness is left out.

    For whoever needs the value of every design, good or bad, and no angle. Always the angle that is known to stray
    least is looked at: its next vertex, from the last one back, as the outer ones stray most; then its d←. Vertices
    that the memo has no d→ of need not be measured before, and it stays as it is.
    """
    first, best = r.min_reach - 1, np.inf
    if s.n_triangles == 0 or s.reach <= first:
        return best
    near = memo.near
    known, ahead = s.known, s.ahead  # of each angle: d→ so far, and the vertex before which none is measured yet
    for k in range(first, s.reach):
        known[k], ahead[k] = memo.stray[k], s.n_vertices
    while True:
        k, least = -1, best
        for j in range(first, s.reach):
            if known[j] < least:
                k, least = j, known[j]
        if k < 0:
            return best
        if ahead[k] > memo.measured:
            ahead[k] -= 1
            known[k], near = vertex_stray(s, r, ahead[k], k, target, least, best, near)
        else:
            best = min(best, uncovered_at(s, r, k, samples, draws, least, best, hint))
            known[k] = np.inf
