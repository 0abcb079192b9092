"""The chain of leaves: neighbours, sides, mirrors, turns."""

from __future__ import annotations

from origami_lab.game.kernels.state import Record, code_x, code_y
from origami_lab.geometry.planar import cross
from origami_lab.jit import inlined, kernel

PREV, NEXT = 0, 1


@inlined
def is_own_image(s: Record, r: Record, v: int, code: int) -> bool:
    """Whether a neighbour is the leaf's own mirror image, beyond an axis that the leaf is not on."""
    return code >> 3 == v and code & 7 != 0


@inlined
def near_side(s: Record, r: Record, v: int) -> int:
    """The side of an on-axis leaf that lies in the playable area."""
    if r.start_mirror != r.end_mirror:
        return NEXT if s.axis[v] == r.start_mirror else PREV
    return NEXT if s.prev[v] & 7 != 0 else PREV


@inlined
def side_is_open(s: Record, r: Record, v: int, side: int) -> bool:
    """Whether a crease can leave v on that side: less than π between the last crease there and the boundary."""
    x, y = s.xy[v, 0], s.xy[v, 1]
    if side == PREV:
        neighbour, crease = s.prev[v], s.last[v]
    else:
        neighbour, crease = s.next[v], s.first[v]
    nx, ny = code_x(s, r, neighbour) - x, code_y(s, r, neighbour) - y
    cx, cy = code_x(s, r, crease) - x, code_y(s, r, crease) - y
    sine = cross(cx, cy, nx, ny) if side == PREV else cross(nx, ny, cx, cy)
    return sine > 0 or (sine == 0 and nx * cx + ny * cy > 0)


@inlined
def turn_at(s: Record, r: Record, w: int, a: int, b: int) -> int:
    """Positive where, seen from w, the coded vertex b lies counter-clockwise of a by less than π."""
    x, y = s.xy[w, 0], s.xy[w, 1]
    ax, ay = code_x(s, r, a) - x, code_y(s, r, a) - y
    return cross(ax, ay, code_x(s, r, b) - x, code_y(s, r, b) - y)


@inlined
def sector_closes(s: Record, r: Record, w: int, side: int) -> bool:
    """Whether a crease along w's boundary segment leaves a sector of less than π to the next incoming crease."""
    if side == PREV:
        return turn_at(s, r, w, s.last[w], s.prev[w]) > 0
    return turn_at(s, r, w, s.next[w], s.first[w]) > 0


@inlined
def mirror_between(s: Record, r: Record, v: int, code: int) -> int:
    """The mirror that takes v to its image with that code: the start or end mirror of the domain."""
    x, y = code_x(s, r, code), code_y(s, r, code)
    for g in (r.start_mirror, r.end_mirror):
        if (
            r.matrices[g, 0] * s.xy[v, 0] + r.matrices[g, 1] * s.xy[v, 1] == x
            and r.matrices[g, 2] * s.xy[v, 0] + r.matrices[g, 3] * s.xy[v, 1] == y
        ):
            return g
    return 0


@kernel
def tail(s: Record) -> int:
    """The last leaf of the chain."""
    w = s.head
    while s.next[w] & 7 == 0 and s.next[w] >> 3 != s.head:
        w = s.next[w] >> 3
    return w
