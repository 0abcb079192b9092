"""Limits of what can be cut and folded: how short a crease, how sharp a corner, how narrow a panel may be.

All on the flat sheet, from integers: nothing here depends on a driving angle. A limit of 0 (of angles a cosine above
1) is none, and then every answer is yes.
"""

from __future__ import annotations

from origami_lab.game.kernels.state import Record
from origami_lab.geometry.planar import cross
from origami_lab.jit import inlined


@inlined
def is_long_enough(r: Record, dx: int, dy: int) -> bool:
    """Whether a crease may have this direction and length."""
    return float(dx * dx + dy * dy) >= r.min_length_sq


@inlined
def is_wide_enough(r: Record, ax: int, ay: int, bx: int, by: int, cx: int, cy: int) -> bool:
    """Whether a panel may have this triangle as a part: its smallest height is at least the least width.

    What is as wide as this in one of its triangles is so as a whole. One without area is no part of a panel.
    """
    doubled = float(cross(bx - ax, by - ay, cx - ax, cy - ay))
    longest = max(
        float((bx - ax) * (bx - ax) + (by - ay) * (by - ay)),
        float((cx - bx) * (cx - bx) + (cy - by) * (cy - by)),
        float((ax - cx) * (ax - cx) + (ay - cy) * (ay - cy)),
    )
    return doubled == 0.0 or doubled * doubled >= r.min_width_sq * longest


@inlined
def is_blunt_enough(r: Record, ax: int, ay: int, bx: int, by: int) -> bool:
    """Whether two neighbouring creases of a vertex may have these directions, less than 180° apart.

    The least angle is below 90°; one that is met exactly is enough.
    """
    dot = float(ax * bx + ay * by)
    if dot <= 0.0:
        return True
    lengths = float(ax * ax + ay * ay) * float(bx * bx + by * by)
    return dot * dot <= (r.max_cosine * r.max_cosine + 1e-9) * lengths
