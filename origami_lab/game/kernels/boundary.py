"""The chain of leaves: neighbours, sides, mirrors."""

from __future__ import annotations

from origami_lab.game.kernels.state import Record, code_x, code_y
from origami_lab.jit import bare, inlined

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


@bare
def tail(s: Record) -> int:
    """The last leaf of the chain."""
    w = s.head
    while s.next[w] & 7 == 0 and s.next[w] >> 3 != s.head:
        w = s.next[w] >> 3
    return w
