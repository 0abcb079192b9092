"""Exact predicates of the flat sheet, on integer coordinates: no rounding, no tolerance."""

from __future__ import annotations

from origami_lab.jit import inlined


@inlined
def cross(ax: int, ay: int, bx: int, by: int) -> int:
    """z of a×b: positive where b lies counter-clockwise of a by less than π."""
    return ax * by - ay * bx


@inlined
def turn(ax: int, ay: int, bx: int, by: int, cx: int, cy: int) -> int:
    """Twice the signed area of the triangle a, b, c; positive counter-clockwise."""
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@inlined
def in_sector(px: int, py: int, nx: int, ny: int, dx: int, dy: int) -> bool:
    """Whether direction d lies in the closed sector swept counter-clockwise from p to n.

    If p and n point the same way the sector is the full turn.
    """
    pn = px * ny - py * nx
    pd = px * dy - py * dx
    dn = dx * ny - dy * nx
    if pn > 0:
        return pd >= 0 and dn >= 0
    if pn == 0:
        return pd >= 0 or px * nx + py * ny > 0
    return pd >= 0 or dn >= 0


@inlined
def triangle_contains(ax: int, ay: int, bx: int, by: int, cx: int, cy: int, qx: int, qy: int) -> bool:
    """Whether q lies in the closed counter-clockwise triangle a, b, c."""
    return (
        (bx - ax) * (qy - ay) - (by - ay) * (qx - ax) >= 0
        and (cx - bx) * (qy - by) - (cy - by) * (qx - bx) >= 0
        and (ax - cx) * (qy - cy) - (ay - cy) * (qx - cx) >= 0
    )


@inlined
def segments_touch(ax: int, ay: int, bx: int, by: int, cx: int, cy: int, dx: int, dy: int) -> bool:
    """Whether the closed segments a–b and c–d have a point in common."""
    if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx):
        return False
    if max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by):
        return False
    c_side = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    d_side = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    if (c_side > 0 and d_side > 0) or (c_side < 0 and d_side < 0):
        return False
    a_side = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    b_side = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    return not ((a_side > 0 and b_side > 0) or (a_side < 0 and b_side < 0))
