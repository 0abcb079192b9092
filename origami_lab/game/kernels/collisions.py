"""Rule 5 of the paper: panels must not pass through each other during the whole folding motion.

The new triangles of one representative are tested against every triangle of the sheet and all images; symmetry makes
the remaining pairs redundant. Boxes swept over the motion come first, then boxes at each angle, then the
triangles themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import Record, code_x, code_y, has_image, image_code
from origami_lab.geometry.triangles import CONTACT_TOLERANCE, triangles_cross
from origami_lab.jit import inlined, kernel


@inlined
def place_corner(s: Record, r: Record, code: int, k: int, out: NDArray[np.float64], row: int) -> None:
    """Folded position of a coded vertex at driving angle k."""
    v, g = code >> 3, code & 7
    x, y = s.position[v, k, 0], s.position[v, k, 1]
    if g == 0:
        out[row, 0], out[row, 1] = x, y
    else:
        out[row, 0] = r.matrices[g, 0] * x + r.matrices[g, 1] * y
        out[row, 1] = r.matrices[g, 2] * x + r.matrices[g, 3] * y
    out[row, 2] = s.position[v, k, 2]


@kernel
def sweep_triangle(s: Record, r: Record, t: int, reach: int) -> None:
    """Box around triangle t at the first ``reach`` driving angles."""
    corner = np.empty((1, 3))
    for j in range(3):
        s.swept[t, j], s.swept[t, 3 + j] = np.inf, -np.inf
    for i in range(3):
        for k in range(reach):
            place_corner(s, r, s.corners[t, i], k, corner, 0)
            for j in range(3):
                s.swept[t, j] = min(s.swept[t, j], corner[0, j])
                s.swept[t, 3 + j] = max(s.swept[t, 3 + j], corner[0, j])


@inlined
def share_edge(a: NDArray[np.int32], b: NDArray[np.int32]) -> bool:
    """Whether two flat triangles, each (3, 2), have two corners in common: they can only meet at |ρ| = π."""
    common = 0
    for i in range(3):
        for j in range(3):
            if a[i, 0] == b[j, 0] and a[i, 1] == b[j, 1]:
                common += 1
    return common >= 2


@inlined
def boxes_apart(p: NDArray[np.float64], q: NDArray[np.float64]) -> bool:
    """Whether the boxes around two triangles do not overlap by more than contact."""
    for j in range(3):
        p_low, p_high = min(p[0, j], p[1, j], p[2, j]), max(p[0, j], p[1, j], p[2, j])
        q_low, q_high = min(q[0, j], q[1, j], q[2, j]), max(q[0, j], q[1, j], q[2, j])
        if p_high < q_low or q_high < p_low:
            return True
    return False


@kernel
def collision_free_reach(s: Record, r: Record, n_old: int, n_all: int, reach: int) -> int:
    """How many of the first ``reach`` angles stay free of collisions with triangles n_old … n_all − 1 added.

    The new triangles' corners are in place; their swept boxes are computed here.
    """
    for t in range(n_old, n_all):
        sweep_triangle(s, r, t, reach)
    p, q = np.empty((3, 3)), np.empty((3, 3))
    flat_p, flat_q = np.empty((3, 2), np.int32), np.empty((3, 2), np.int32)
    boxes = np.empty((8, 4))
    codes = np.empty(3, np.int32)
    for new in range(n_old, n_all):
        # instead of moving every old triangle to its images, move the new one back to the representatives
        for g in range(r.order):
            a, b, c, d = r.matrices[g, 0], r.matrices[g, 1], r.matrices[g, 2], r.matrices[g, 3]
            x0, y0, x1, y1 = s.swept[new, 0], s.swept[new, 1], s.swept[new, 3], s.swept[new, 4]
            u0, u1 = a * x0 + b * y0, a * x1 + b * y1
            w0, w1 = c * x0 + d * y0, c * x1 + d * y1
            boxes[g, 0], boxes[g, 1], boxes[g, 2], boxes[g, 3] = min(u0, u1), min(w0, w1), max(u0, u1), max(w0, w1)
        low_z, high_z = s.swept[new, 2], s.swept[new, 5]
        for t in range(new + 1):
            if s.swept[t, 2] > high_z or s.swept[t, 5] < low_z:
                continue
            x0, y0, x1, y1 = s.swept[t, 0], s.swept[t, 1], s.swept[t, 3], s.swept[t, 4]
            for g in range(r.order):
                if x0 > boxes[g, 2] or x1 < boxes[g, 0] or y0 > boxes[g, 3] or y1 < boxes[g, 1]:
                    continue
                # the pair (new, image of t under the inverse of g)
                if (t == new and g == 0) or not has_image(r, s.images[t], r.inverses[g]):
                    continue
                for i in range(3):
                    codes[i] = image_code(r, g, s.corners[new, i])
                    flat_p[i, 0], flat_p[i, 1] = code_x(s, r, codes[i]), code_y(s, r, codes[i])
                    flat_q[i, 0], flat_q[i, 1] = code_x(s, r, s.corners[t, i]), code_y(s, r, s.corners[t, i])
                if share_edge(flat_p, flat_q):
                    continue
                for k in range(reach):
                    for i in range(3):
                        place_corner(s, r, codes[i], k, p, i)
                        place_corner(s, r, s.corners[t, i], k, q, i)
                    if boxes_apart(p, q):
                        continue
                    if triangles_cross(p, q, CONTACT_TOLERANCE):
                        reach = k
                        break
                if reach == 0:
                    return 0
    return reach
