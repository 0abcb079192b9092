"""Rule 5 of the paper: panels must not pass through each other during the whole folding motion.

The new triangles of one representative are tested against every triangle of the sheet and all images; symmetry makes
the remaining pairs redundant. Instead of moving every old triangle to its images, the new one is moved back to the
representatives. Of a pair come first the boxes swept over the motion, then the corners on the flat sheet, then the
boxes at each angle, which are kept, then the triangles themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import Record, flat_corner, has_image, image_code
from origami_lab.geometry.triangles import CONTACT_TOLERANCE, triangles_cross
from origami_lab.jit import bare, inlined


@inlined
def folded_place(s: Record, r: Record, code: int, k: int) -> tuple[float, float, float]:
    """Folded position of a coded vertex at driving angle k."""
    v, g = code >> 3, code & 7
    x, y, z = s.position[v, k, 0], s.position[v, k, 1], s.position[v, k, 2]
    if g == 0:
        return x, y, z
    return r.matrices[g, 0] * x + r.matrices[g, 1] * y, r.matrices[g, 2] * x + r.matrices[g, 3] * y, z


@inlined
def place_corner(s: Record, r: Record, code: int, k: int, out: NDArray[np.float64], row: int) -> None:
    """Write the folded position of a coded vertex at driving angle k."""
    out[row, 0], out[row, 1], out[row, 2] = folded_place(s, r, code, k)


@bare
def sweep_triangle(s: Record, r: Record, t: int, reach: int) -> None:
    """Boxes around triangle t at each of the first ``reach`` driving angles, and around all of them."""
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    a, b, c = s.corners[t, 0], s.corners[t, 1], s.corners[t, 2]
    for k in range(reach):
        ax, ay, az = folded_place(s, r, a, k)
        bx, by, bz = folded_place(s, r, b, k)
        cx, cy, cz = folded_place(s, r, c, k)
        x0, y0, z0 = min(ax, bx, cx), min(ay, by, cy), min(az, bz, cz)
        x1, y1, z1 = max(ax, bx, cx), max(ay, by, cy), max(az, bz, cz)
        s.boxes[t, k, 0], s.boxes[t, k, 1], s.boxes[t, k, 2] = x0, y0, z0
        s.boxes[t, k, 3], s.boxes[t, k, 4], s.boxes[t, k, 5] = x1, y1, z1
        low_x, low_y, low_z = min(low_x, x0), min(low_y, y0), min(low_z, z0)
        high_x, high_y, high_z = max(high_x, x1), max(high_y, y1), max(high_z, z1)
    s.swept[t, 0], s.swept[t, 1], s.swept[t, 2] = low_x, low_y, low_z
    s.swept[t, 3], s.swept[t, 4], s.swept[t, 5] = high_x, high_y, high_z


@inlined
def turned(m0: int, m1: int, low_x: float, low_y: float, high_x: float, high_y: float) -> tuple[float, float]:
    """Low and high end of one side of a box under a symmetry of the board, whose matrix has the row (m0, m1)."""
    one, other = m0 * low_x + m1 * low_y, m0 * high_x + m1 * high_y
    return min(one, other), max(one, other)


@bare
def sweep_images(s: Record, r: Record, t: int) -> None:
    """The swept boxes of triangle t's images, seen from above: ``image_swept``, (4, 8), empty where there is none."""
    x0, y0, x1, y1 = s.swept[t, 0], s.swept[t, 1], s.swept[t, 3], s.swept[t, 4]
    out = s.image_swept
    for g in range(8):
        if g < r.order:
            m = r.matrices[g]
            out[0, g], out[2, g] = turned(m[0], m[1], x0, y0, x1, y1)
            out[1, g], out[3, g] = turned(m[2], m[3], x0, y0, x1, y1)
        else:
            out[0, g] = out[1, g] = np.inf
            out[2, g] = out[3, g] = -np.inf


@inlined
def images_near(s: Record, t: int) -> int:
    """Bit g says whether the swept box of triangle t overlaps that of the new triangle's image g, seen from above."""
    x0, y0, x1, y1 = s.swept[t, 0], s.swept[t, 1], s.swept[t, 3], s.swept[t, 4]
    b, near = s.image_swept, 0
    for g in range(8):  # all of them, in one vector: there is no branch
        near |= int((x0 <= b[2, g]) & (x1 >= b[0, g]) & (y0 <= b[3, g]) & (y1 >= b[1, g])) << g
    return near


@bare
def lay_image(s: Record, r: Record, t: int, g: int, reach: int) -> None:
    """Image g of triangle t: its corners on the flat sheet and at each driving angle, and its boxes there."""
    m = r.matrices[g]
    for i in range(3):
        code = image_code(r, g, s.corners[t, i])
        s.image_flat[g, i] = flat_corner(s, r, code)
        for k in range(reach):
            place_corner(s, r, code, k, s.image_corners[g, k], i)
    for k in range(reach):
        x0, y0, x1, y1 = s.boxes[t, k, 0], s.boxes[t, k, 1], s.boxes[t, k, 3], s.boxes[t, k, 4]
        box = s.image_boxes[g, k]
        box[0], box[3] = turned(m[0], m[1], x0, y0, x1, y1)
        box[1], box[4] = turned(m[2], m[3], x0, y0, x1, y1)
        box[2], box[5] = s.boxes[t, k, 2], s.boxes[t, k, 5]


@inlined
def share_edge(s: Record, t: int, g: int) -> bool:
    """Whether image g and triangle t have two corners in common on the flat sheet: they can only meet at |ρ| = π."""
    a, b, c = s.image_flat[g, 0], s.image_flat[g, 1], s.image_flat[g, 2]
    common = 0
    for j in range(3):
        q = s.flat_corners[t, j]
        common += int(a == q) + int(b == q) + int(c == q)
    return common >= 2


@inlined
def boxes_apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Whether two boxes have no point in common."""
    return bool(a[2] > b[5] or a[5] < b[2] or a[0] > b[3] or a[3] < b[0] or a[1] > b[4] or a[4] < b[1])


@bare
def collision_free_reach(s: Record, r: Record, n_old: int, n_all: int, reach: int) -> int:
    """How many of the first ``reach`` angles stay free of collisions with triangles n_old … n_all − 1 added.

    The new triangles' corners are in place; their boxes are computed here.
    """
    for t in range(n_old, n_all):
        sweep_triangle(s, r, t, reach)
    for new in range(n_old, n_all):
        sweep_images(s, r, new)
        low_z, high_z = s.swept[new, 2], s.swept[new, 5]
        laid = 0  # bit g: image g is laid
        for t in range(new + 1):
            if s.swept[t, 2] > high_z or s.swept[t, 5] < low_z:
                continue
            near, g = images_near(s, t), -1
            if t == new:
                near &= ~1
            while near != 0:
                g += 1
                is_near = near & 1
                near >>= 1
                # the pair (new, image of t under the inverse of g)
                if is_near == 0 or not has_image(r, s.images[t], r.inverses[g]):
                    continue
                if (laid >> g) & 1 == 0:
                    laid |= 1 << g
                    lay_image(s, r, new, g, reach)
                if share_edge(s, t, g):
                    continue
                for k in range(reach):
                    if boxes_apart(s.image_boxes[g, k], s.boxes[t, k]):
                        continue
                    for i in range(3):
                        place_corner(s, r, s.corners[t, i], k, s.triangle, i)
                    if triangles_cross(s.image_corners[g, k], s.triangle, CONTACT_TOLERANCE):
                        reach = k
                        break
                if reach == 0:
                    return 0
    return reach
