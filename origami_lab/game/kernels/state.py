"""The state of the game and its rules, each one NumPy record that the kernels read and write in place.

**The sheet.** At any time the sheet is a simple polygon; its boundary, walked counter-clockwise with the inside
on the left, is a cycle of *leaves* (vertices not extended yet). Under a symmetry only the part inside the closed
fundamental domain is stored: a chain of *representatives* from the start axis to the end axis. Every neighbour is
a *code*, ``8 · representative + group element``: a code with element 0 is a representative itself, any other is
an image of one, so the chain closes over each axis by a link to an image.

**Snapshots.** A state is one element of an array of the record. Copying one copies the used rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.geometry.wide_tree import MOST_LEVELS, WIDTH
from origami_lab.jit import bare, inlined

# phases of the game: what the next action decides
PLACEMENT, SELECTION, FIRST, SECOND, THIRD = 0, 1, 2, 3, 4

# how an episode stands
RUNNING, TERMINATED, STUCK, NOT_FOLDABLE, FULL = 0, 1, 2, 3, 4
STATUS_NAMES = ("running", "terminated", "stuck", "not foldable", "capacity exhausted")

# which images a triangle has: one for each group element, one for each coset of a mirror, or itself only
ALL_IMAGES, SINGLE = 0, -1

SQUARE, CREASE, PANEL, RECTANGLE, SEGMENT = 0, 1, 2, 3, 4
"""Start patterns: a square or a crease on a line whose size or height is an option, a polygon that is given, a
rectangle or a crease whose corners are chosen one after the other."""

ON_AXES, ON_BOUNDARY = 1, 2
"""Where driven creases may be laid: between a leaf and its mirror image only, or on any boundary segment."""

LARGEST_PANEL = 16
"""Most corners of a start pattern."""

CLOSED, BARE, STRAIGHT = 1, 2, 3
"""``locked`` of a leaf at which nothing new can fold, as an incoming sector is more than π; of one that no crease
leads to yet, a corner between two sides that are not driven; of one with an incoming sector of exactly π."""

DEFAULT_VERTICES = 320
"""Representative vertices that a state has room for."""

Record = Any
"""A state or rules record: ``np.void`` to Python, a typed record to the kernels."""
States = NDArray[np.void]
"""Array of state records."""


def _record(fields: list[Any]) -> np.dtype[np.void]:
    """An aligned record type; ``np.record`` so that plain Python reads its fields as the kernels do."""
    return np.dtype((np.record, np.dtype(fields, align=True)))


SCALARS = (
    *("n_vertices", "n_triangles", "n_creases", "n_actions", "n_extensions"),
    *("phase", "status"),
    "reach",  # driving angles, from flat up, that the motion reaches
    "head",  # first leaf of the chain
    "selected",  # the leaf being extended
    "mode",  # its rigid body mode, −1 or +1
    *("first_x", "first_y", "second_x", "second_y"),  # its outer children
    "unfinished",  # actions of an extension that is not complete
)
"""The fields of a state that are single numbers."""


def state_dtype(vertices: int = DEFAULT_VERTICES, angles: int = 10) -> np.dtype[np.void]:
    """Layout of a state with room for ``vertices`` representatives at ``angles`` driving angles.

    Kernels are compiled once for each layout.
    """
    triangles, creases, actions = 3 * vertices, 3 * vertices + 8, 4 * vertices + 8
    return _record(
        [
            *((name, np.int32) for name in SCALARS),
            ("xy", np.int32, (vertices, 2)),  # on the board
            ("prev", np.int32, (vertices,)),  # codes of the neighbours on the boundary
            ("next", np.int32, (vertices,)),
            ("first", np.int32, (vertices,)),  # incoming creases next to those neighbours: code of their other end
            ("last", np.int32, (vertices,)),
            ("axis", np.int32, (vertices,)),  # the mirror that fixes the vertex, 0 if none
            ("modes", np.int8, (vertices,)),  # 0 for a leaf
            ("locked", np.int8, (vertices,)),  # CLOSED, BARE or STRAIGHT, 0 for most
            ("corners", np.int32, (triangles, 3)),  # codes, counter-clockwise
            ("images", np.int32, (triangles,)),
            ("creases", np.int32, (creases, 2)),  # codes
            ("driven", np.int8, (creases,)),  # sign of a source crease, 0 for the others
            ("actions", np.int32, (actions,)),
            ("position", np.float64, (vertices, angles, 3)),  # in space
            ("frame_prev", np.float64, (vertices, angles, 6)),  # the panel on the prev side of a leaf
            ("frame_next", np.float64, (vertices, angles, 6)),
            ("flat_corners", np.int64, (triangles, 3)),  # corners on the board, each as one number
            ("boxes", np.float64, (triangles, angles, 6)),  # around the triangle at each angle: low xyz, high xyz
            ("swept", np.float64, (triangles, 6)),  # around it at all of them
            # what kernels write to while they run, and nothing else: it is not copied
            ("edges", np.int32, (vertices + 2, 4)),
            ("triangle", np.float64, (3, 3)),
            ("image_flat", np.int64, (8, 3)),
            ("image_swept", np.float64, (4, 8)),
            ("image_boxes", np.float64, (8, angles, 6)),
            ("image_corners", np.float64, (8, angles, 3, 3)),
            ("known", np.float64, (angles,)),
            ("ahead", np.int64, (angles,)),
            ("far", np.float64, (MOST_LEVELS, WIDTH)),
            ("near", np.int64),
        ]
    )


def rules_dtype(angles: int = 10) -> np.dtype[np.void]:
    """Layout of the rules: all that the kernels know of the game besides the state."""
    return _record(
        [
            ("half_x", np.int32),  # the board reaches from −half_x to +half_x and from −half_y to +half_y
            ("half_y", np.int32),
            ("order", np.int32),  # elements of the symmetry group
            ("matrices", np.int32, (8, 4)),
            ("products", np.int32, (8, 8)),
            ("inverses", np.int32, (8,)),
            ("n_axes", np.int32),  # sides of the fundamental domain
            ("normals", np.int32, (2, 2)),
            ("mirrors", np.int32, (2,)),
            ("start_mirror", np.int32),
            ("end_mirror", np.int32),
            ("max_length_sq", np.float64),
            ("min_length_sq", np.float64),  # of a crease; 0 for no limit
            ("min_width_sq", np.float64),  # of the triangles of panels; 0 for no limit
            ("max_cosine", np.float64),  # of the angle between neighbouring creases of a vertex; above 1 for no limit
            ("sources", np.int32),  # where driven creases may be laid during the game
            ("straight_sectors", np.int32),  # whether sectors may be exactly π
            ("collisions", np.int32),  # whether panels may not cross
            ("stuck_is_penalised", np.int32),  # whether an extension without a place left brings the penalty
            ("min_reach", np.int32),  # driving angles that must stay reachable
            ("start", np.int32),
            ("n_placements", np.int32),
            ("first_placement", np.int32),
            ("picks", np.int32),  # places that are chosen before the start pattern is laid
            ("n_driven", np.int32),  # its driven creases
            ("centre", np.int32, (2,)),  # of a square
            ("stays_below", np.int32),  # which panel of a single crease stays in the plane
            ("flips_x", np.int32),  # whether the symmetry takes x to −x, and y to −y
            ("flips_y", np.int32),
            ("least", np.int32, (2,)),  # width and height of a rectangle
            ("most", np.int32, (2,)),
            ("is_square", np.int32),
            ("is_pinned", np.int32),  # whether its first corner is given
            ("pin", np.int32, (2,)),
            ("n_corners", np.int32),  # of a panel that is given
            ("corners", np.int32, (LARGEST_PANEL, 2)),  # counter-clockwise
            ("sides", np.int32, (LARGEST_PANEL,)),  # sign of each side from there on, 0 where it is not driven
            ("angles", np.float64, (angles,)),
        ]
    )


# --- codes -----------------------------------------------------------------------------------------------------------


@inlined
def code_x(s: Record, r: Record, code: int) -> int:
    """Board x of a coded vertex."""
    v, g = code >> 3, code & 7
    return r.matrices[g, 0] * s.xy[v, 0] + r.matrices[g, 1] * s.xy[v, 1]


@inlined
def code_y(s: Record, r: Record, code: int) -> int:
    """Board y of a coded vertex."""
    v, g = code >> 3, code & 7
    return r.matrices[g, 2] * s.xy[v, 0] + r.matrices[g, 3] * s.xy[v, 1]


@inlined
def flat_corner(s: Record, r: Record, code: int) -> int:
    """Board point of a coded vertex as one number, another one for every point."""
    return int((np.int64(code_x(s, r, code)) << 32) + code_y(s, r, code))


@inlined
def image_code(r: Record, g: int, code: int) -> int:
    """Code of the image of a coded vertex under group element g."""
    return (code & ~7) | r.products[g, code & 7]


@inlined
def is_playable(r: Record, x: int, y: int) -> bool:
    """Whether a board point lies in the closed fundamental domain."""
    for i in range(r.n_axes):
        if r.normals[i, 0] * x + r.normals[i, 1] * y < 0:
            return False
    return True


@inlined
def axis_of(r: Record, x: int, y: int) -> int:
    """The mirror whose axis the playable point lies on: 0 for none, −1 for more than one."""
    axis = 0
    for i in range(r.n_axes):
        if r.normals[i, 0] * x + r.normals[i, 1] * y == 0:
            axis = r.mirrors[i] if axis == 0 else -1
    return axis


# --- actions ---------------------------------------------------------------------------------------------------------
# With n points of the board, an action is
#   mode·n + point (mode 0 for M = −1, 1 for M = +1)   select a leaf
#   2n + point                                          choose a location
#   3n                                                  terminate
#   3n + 1 + 2·end + (sign > 0)                         lay a source across the start (0) or end (1) axis
#   3n + 5 + 2·option + (sign > 0)                      place the start pattern
#   3n + 5 + 2·n_placements + (sign > 0)                begin a source on the boundary; its place is a location
# Where the corners of the start pattern are chosen they come first, as locations (corner_choice.py says which).


@inlined
def board_points(r: Record) -> int:
    """n, the number of points on the board."""
    return (2 * r.half_x + 1) * (2 * r.half_y + 1)


@inlined
def point_index(r: Record, x: int, y: int) -> int:
    """Index of a board point, row by row from the bottom left."""
    return (y + r.half_y) * (2 * r.half_x + 1) + x + r.half_x


@inlined
def point_x(r: Record, index: int) -> int:
    return index % (2 * r.half_x + 1) - r.half_x


@inlined
def point_y(r: Record, index: int) -> int:
    return index // (2 * r.half_x + 1) - r.half_y


# --- growing and copying ---------------------------------------------------------------------------------------------


@bare
def clear(s: Record) -> None:
    """An empty board before placement."""
    s.n_vertices = 0
    s.n_triangles = 0
    s.n_creases = 0
    s.n_actions = 0
    s.n_extensions = 0
    s.phase = PLACEMENT
    s.status = RUNNING
    s.reach = s.position.shape[1]
    s.head = -1
    s.selected = -1
    s.mode = 0
    s.first_x, s.first_y, s.second_x, s.second_y = 0, 0, 0, 0
    s.unfinished = 0
    s.near = 0


@inlined
def add_vertex(s: Record, r: Record, x: int, y: int) -> int:
    """A new representative; its position and links are the caller's to set."""
    v = s.n_vertices
    s.n_vertices = v + 1
    s.xy[v, 0], s.xy[v, 1] = x, y
    s.axis[v] = axis_of(r, x, y)
    s.modes[v] = 0
    s.locked[v] = 0
    return v


@inlined
def add_triangle(s: Record, r: Record, a: int, b: int, c: int, images: int) -> None:
    """A new triangle; its boxes are the caller's to set."""
    t = s.n_triangles
    s.n_triangles = t + 1
    s.corners[t, 0], s.corners[t, 1], s.corners[t, 2] = a, b, c
    s.flat_corners[t, 0], s.flat_corners[t, 1], s.flat_corners[t, 2] = (
        flat_corner(s, r, a),
        flat_corner(s, r, b),
        flat_corner(s, r, c),
    )
    s.images[t] = images


@inlined
def add_crease(s: Record, a: int, b: int, driven: int) -> None:
    i = s.n_creases
    s.n_creases = i + 1
    s.creases[i, 0], s.creases[i, 1] = a, b
    s.driven[i] = driven


@inlined
def has_image(r: Record, images: int, g: int) -> bool:
    """Whether group element g makes an image of a triangle that is not made by an earlier element."""
    if images == ALL_IMAGES:
        return True
    if images == SINGLE:
        return g == 0
    return g < r.products[g, images]


@inlined
def is_penalised(s: Record, r: Record) -> bool:
    """Whether the end of an episode brings the penalty instead of a score."""
    if s.status == NOT_FOLDABLE:
        return True
    inside_move = s.phase != SELECTION and s.phase != PLACEMENT
    return bool(r.stuck_is_penalised and s.status == STUCK and inside_move)


@inlined
def copy_scalars(target: Record, source: Record) -> None:
    """Copy all of :data:`SCALARS`, between any two records that have them."""
    target.n_vertices, target.n_triangles = source.n_vertices, source.n_triangles
    target.n_creases, target.n_actions = source.n_creases, source.n_actions
    target.n_extensions = source.n_extensions
    target.phase, target.status, target.reach = source.phase, source.status, source.reach
    target.head, target.selected, target.mode = source.head, source.selected, source.mode
    target.first_x, target.first_y = source.first_x, source.first_y
    target.second_x, target.second_y = source.second_x, source.second_y
    target.unfinished = source.unfinished


@bare
def copy_state(target: Record, source: Record) -> None:
    """Copy the used rows of one state to another."""
    n, t, c, a = source.n_vertices, source.n_triangles, source.n_creases, source.n_actions
    copy_scalars(target, source)
    target.near = source.near
    reach = source.reach
    for i in range(n):
        target.xy[i, 0], target.xy[i, 1] = source.xy[i, 0], source.xy[i, 1]
        target.prev[i], target.next[i] = source.prev[i], source.next[i]
        target.first[i], target.last[i] = source.first[i], source.last[i]
        target.axis[i] = source.axis[i]
        target.modes[i] = source.modes[i]
        target.locked[i] = source.locked[i]
        leaf = source.modes[i] == 0  # an extended vertex needs its panels no more
        for k in range(reach):
            for j in range(3):
                target.position[i, k, j] = source.position[i, k, j]
            if leaf:
                for j in range(6):
                    target.frame_prev[i, k, j] = source.frame_prev[i, k, j]
                    target.frame_next[i, k, j] = source.frame_next[i, k, j]
    for i in range(t):
        for j in range(3):
            target.corners[i, j] = source.corners[i, j]
            target.flat_corners[i, j] = source.flat_corners[i, j]
        target.images[i] = source.images[i]
        for k in range(reach):
            for j in range(6):
                target.boxes[i, k, j] = source.boxes[i, k, j]
        for j in range(6):
            target.swept[i, j] = source.swept[i, j]
    for i in range(c):
        target.creases[i, 0], target.creases[i, 1] = source.creases[i, 0], source.creases[i, 1]
        target.driven[i] = source.driven[i]
    for i in range(a):
        target.actions[i] = source.actions[i]
