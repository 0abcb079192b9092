"""FOLD files as different programs write them, by a writer that shares nothing with ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.fold_format.corpus import Array, Pattern

Fold = dict[str, Any]


@dataclass(frozen=True)
class Dialect:
    """A way to write a pattern."""

    write: Callable[[Pattern], Fold]
    letters: bool = True
    """Whether mountains and valleys are in the file, by letters or by angles."""
    folds: bool = True
    """Whether fold angles or folded vertices are."""
    mirrored: bool = False
    """Whether the pattern is written as seen from below."""


def base(p: Pattern, *leave_out: str) -> Fold:
    """The flat pattern with all keys but some."""
    fold = {
        "vertices_coords": p.flat.tolist(),
        "edges_vertices": [list(edge) for edge in p.edges],
        "edges_assignment": list(p.letters),
        "edges_foldAngle": list(p.degrees[-1]),
        "faces_vertices": [list(face) for face in p.faces],
    }
    return {key: value for key, value in fold.items() if key not in leave_out}


def state(p: Pattern, k: int, turn: Array | None = None) -> Fold:
    """The keys of a folded state, turned in space."""
    coords = p.folded[k] if turn is None else p.folded[k] @ turn.T + [1.0, -2.0, 0.5]
    return {"frame_classes": ["foldedForm"], "vertices_coords": coords.tolist(), "edges_foldAngle": list(p.degrees[k])}


def heir(parent: int = 0) -> Fold:
    return {"frame_parent": parent, "frame_inherit": True}


TILTED, _ = np.linalg.qr(np.array([[0.3, 0.5, 0.9], [0.8, -0.2, 0.1], [0.1, 0.9, -0.4]]))
TILTED = TILTED * np.sign(np.linalg.det(TILTED))


def children(p: Pattern) -> Fold:
    """The pattern first, states that inherit from it."""
    frames = [heir() | state(p, k) for k in range(3)]
    return {"file_spec": 1.2, "frame_classes": ["creasePattern"]} | base(p) | {"file_frames": frames}


def folded_first(p: Pattern) -> Fold:
    """The folded form as the key frame, states and the pattern below it inherit classes and all else."""
    frames = [heir() | {"faceOrders": []}, heir() | state(p, 0)]
    frames.append(heir() | {"frame_classes": ["creasePattern"], "vertices_coords": p.flat.tolist()})
    return base(p) | state(p, 2) | {"file_frames": frames}


def apart(p: Pattern) -> Fold:
    """Frames without inheritance, the states' edges in another order and direction."""
    order = list(range(len(p.edges)))[::-1]
    frames = []
    for k in range(3):
        frames.append(
            state(p, k)
            | {
                "edges_vertices": [list(p.edges[e][::-1]) for e in order],
                "edges_assignment": [p.letters[e] for e in order],
                "edges_foldAngle": [p.degrees[k][e] for e in order],
            }
        )
    return {"frame_classes": ["creasePattern"]} | base(p) | {"file_frames": frames}


def chain(p: Pattern) -> Fold:
    """All in file_frames, each state inheriting from the one before it, the key frame with words only."""
    frames = [{"frame_classes": ["creasePattern"], "frame_title": "sheet"} | base(p)]
    frames += [heir(k + 1) | state(p, k) for k in range(3)]
    return {"file_spec": 1.1, "file_title": "a chain", "file_frames": frames}


def simulator(p: Pattern) -> Fold:
    """(x, y) written as (x, 0, y), the angles' key in the plural, and boundaries that are cuts elsewhere."""
    coords = [[x, 0.0, y] for x, y in p.flat.tolist()]
    frame = base(p, "edges_foldAngle") | {"vertices_coords": coords, "edges_foldAngles": list(p.degrees[-1])}
    return {"frame_classes": ["creasePattern"], "frame_attributes": ["3D"], "file_creator": "a simulator"} | frame


def tilted(p: Pattern) -> Fold:
    """A pattern in a tilted plane, states turned in space."""
    coords = np.column_stack([p.flat, np.zeros(len(p.flat))]) @ TILTED.T + [3.0, 2.0, 1.0]
    frames = [heir() | state(p, k, TILTED) for k in range(3)]
    return {"frame_classes": ["creasePattern"]} | base(p) | {"vertices_coords": coords.tolist(), "file_frames": frames}


def clockwise(p: Pattern) -> Fold:
    """Faces listed clockwise, edges the other way round, z = 0 written out, lower-case letters."""
    fold = children(p)
    fold["faces_vertices"] = [face[::-1] for face in fold["faces_vertices"]]
    fold["edges_vertices"] = [edge[::-1] for edge in fold["edges_vertices"]]
    fold["vertices_coords"] = [[*point, 0] for point in fold["vertices_coords"]]
    fold["edges_assignment"] = [letter.lower() for letter in fold["edges_assignment"]]
    return fold


def plain(p: Pattern) -> Fold:
    """A pattern with letters and angles, no faces and no classes."""
    return base(p, "faces_vertices")


def angles_only(p: Pattern) -> Fold:
    """A pattern without letters."""
    return {"frame_classes": ["creasePattern"]} | base(p, "edges_assignment")


def letters_only(p: Pattern) -> Fold:
    """A pattern as an editor draws it: lines and letters."""
    return {"frame_classes": ["creasePattern"], "edges_foldAngle": None} | base(p, "faces_vertices", "edges_foldAngle")


def sketched(p: Pattern) -> Fold:
    """A pattern with auxiliary lines: across a crease, out of a vertex, outside, over another line, of no length."""
    fold = plain(p)
    n, (u, v) = len(p.flat), next(edge for edge, letter in zip(p.edges, p.letters, strict=True) if letter != "B")
    middle, across = (p.flat[u] + p.flat[v]) / 2, (p.flat[v] - p.flat[u])[::-1] * [-0.01, 0.01]
    far = p.flat.max(axis=0) + 1.0
    points = [
        middle - across,
        middle + across,
        far,
        far + np.array([0.5, 0.2]),
        far + np.array([0.1, 0.6]),
        p.flat[u] + 1e-12,
    ]
    fold["vertices_coords"] = [*fold["vertices_coords"], *np.array(points).tolist()]
    lines = [[n, n + 1], [u, n], [n + 2, n + 3], [n + 3, n + 4], [n + 4, n + 2], [u, v], [u, n + 5]]
    fold["edges_vertices"] = [*fold["edges_vertices"], *lines]
    fold["edges_assignment"] = [*fold["edges_assignment"], *"FFFUFFF"]
    fold["edges_foldAngle"] = [*fold["edges_foldAngle"], *[0, 0, 0, None, 0, 0, 0]]
    return {"frame_classes": ["creasePattern"]} | fold


def folded_alone(p: Pattern) -> Fold:
    """A folded form as the only frame, faces running around in both directions."""
    fold = base(p) | state(p, 2)
    fold["faces_vertices"] = [face[::-1] if k % 3 == 1 else face for k, face in enumerate(fold["faces_vertices"])]
    return fold


def many(p: Pattern) -> Fold:
    """Other frames beside: a graph, another sheet, a state by angles only, the sheet again."""
    fold = children(p)
    fold["file_frames"] += [
        {"frame_classes": ["graph"], "vertices_coords": [[0, 0], [1, 1]], "edges_vertices": [[0, 1]]},
        {"frame_classes": ["creasePattern"], "vertices_coords": [[0, 0], [1, 0], [0, 1]]}
        | {"edges_vertices": [[0, 1], [1, 2], [2, 0]], "faces_vertices": [[0, 1, 2]]},
        heir() | {"frame_classes": ["foldedForm"], "edges_foldAngle": list(p.degrees[1])},
        {"frame_classes": ["creasePattern"]} | base(p),
    ]
    return fold


DIALECTS = {
    "children": Dialect(children),
    "folded first": Dialect(folded_first),
    "apart": Dialect(apart),
    "chain": Dialect(chain),
    "simulator": Dialect(simulator),
    "tilted": Dialect(tilted),
    "clockwise": Dialect(clockwise),
    "plain": Dialect(plain),
    "angles only": Dialect(angles_only),
    "letters only": Dialect(letters_only, folds=False),
    "sketched": Dialect(sketched),
    "folded alone": Dialect(folded_alone),
    "many": Dialect(many),
}
