"""FOLD 1.2, the interchange format of computational origami (https://github.com/edemaine/fold).

The key frame is the flat crease pattern, because simple readers stop there; its mountains, valleys and fold
angles are those of the best driving angle. The frames that follow are the folding motion: every reachable
driving angle in increasing order, except that the best one comes last. What FOLD has no key for is written
under keys with our namespace, e.g. ``vertices_origami_lab:mode`` for the rigid body mode M of the paper.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.files import write_whole
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.keys import ACTIONS, ANGLE, CREATOR, DRIVEN, METADATA, MODE
from origami_lab.fold_format.reader import read_fold
from origami_lab.game.crease_pattern import BOUNDARY, FLAT, CreasePattern
from origami_lab.text import one_line

__all__ = ["FoldFile", "FoldFrame", "as_fold_file", "fold_title", "read_fold", "to_fold", "write_fold"]

_LINE = 110
"""Columns at which the written JSON wraps."""
_ENCODED = json.JSONEncoder(allow_nan=False, ensure_ascii=False).encode


def to_fold(design: CreasePattern | FoldFile) -> dict[str, Any]:
    """The design as a FOLD 1.2 object: plain dictionaries, lists, strings and numbers.

    Lengths are board cells, angles degrees in [−180, 180], valleys positive; the angle of a boundary or flat
    edge is exactly 0. ``edges_faces`` lists the panel on the left of the edge first. Self-intersection is
    not claimed either way: that is what a certificate is for. What was read from a file that this wrote comes
    out the same; of a foreign file, what :class:`FoldFile` holds.
    """
    fold = design if isinstance(design, FoldFile) else as_fold_file(design)
    whole = [] if "C" in fold.assignments else ["noCuts"]
    return {
        "file_spec": 1.2,
        "file_creator": CREATOR,
        "file_title": fold.title,
        "file_classes": ["singleModel", "animation"],
        "frame_title": "crease pattern",
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D", "manifold", "orientable", *whole],
        "frame_unit": "unit",
        "vertices_coords": _numbers(fold.vertices),
        **({} if fold.modes is None else {MODE: [int(mode) for mode in fold.modes]}),
        "edges_vertices": [[int(u), int(v)] for u, v in fold.edges],
        "edges_assignment": list(fold.assignments),
        "edges_foldAngle": _stated(fold),
        "edges_faces": _edge_faces(fold),
        **({} if fold.driven is None else {DRIVEN: [bool(driven) for driven in fold.driven]}),
        "faces_vertices": [[int(v) for v in panel] for panel in fold.panels],
        ACTIONS: [int(action) for action in fold.actions],
        METADATA: _plain(fold.metadata),
        "file_frames": [_frame(fold, frame, whole) for frame in fold.frames],
    }


def as_fold_file(design: CreasePattern) -> FoldFile:
    """The design as it is read back once it is written: the key frame is that of the best driving angle."""
    reach = len(design.driving_angles)
    order = [k for k in range(reach) if k != design.best] + ([design.best] if reach else [])
    frames = tuple(_folded_form(design, k) for k in order)
    if frames:
        assignments, angles = frames[-1].assignments, frames[-1].fold_angles
    else:  # nothing folds: a flat sheet
        assignments = tuple(BOUNDARY if outer else FLAT for outer in design.boundary)
        angles = np.zeros(len(design.edges))
    return FoldFile(
        vertices=design.vertices,
        edges=design.edges,
        assignments=assignments,
        fold_angles=angles,
        panels=design.panels,
        modes=design.modes,
        driven=design.driven,
        frames=frames,
        actions=design.actions,
        title=fold_title(design.metadata),
        metadata=design.metadata,
    )


def write_fold(path: str | os.PathLike[str], design: CreasePattern | FoldFile) -> None:
    """Write the design as a FOLD file; a reader sees the whole file or none of it.

    Numbers keep their full precision, negative zeros become zero. Raises ``ValueError`` on coordinates that
    are not finite, ``OSError`` where the file cannot be written.
    """
    write_whole(path, _dump(to_fold(design)).encode("utf-8", "replace"))  # JSON may hold half of a character


def fold_title(metadata: Mapping[str, object]) -> str:
    """A title from the facts of a trial: ``title`` itself, or for instance "bowl, bfts, seed 3"."""
    if metadata.get("title"):
        return one_line(str(metadata["title"]))
    parts = [str(metadata[key]) for key in ("task", "search") if metadata.get(key) not in (None, "")]
    if metadata.get("seed") is not None:
        parts.append(f"seed {metadata['seed']}")
    return one_line(", ".join(parts)) or "rigid origami"


def _frame(fold: FoldFile, frame: FoldFrame, whole: list[str]) -> dict[str, Any]:
    """A folded form with what differs from the key frame; the last one is the best."""
    known = {} if frame.driving_angle is None else {ANGLE: _degrees(frame.driving_angle)}
    title = f"folded at {known[ANGLE]:.2f} degrees" if known else "folded"
    written = {
        "frame_parent": 0,
        "frame_inherit": True,
        "frame_title": title + (", the best" if frame is fold.best else ""),
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D", "manifold", "orientable", *whole],
        **known,
        "vertices_coords": _numbers(frame.coords),
        "edges_foldAngle": [_degrees(angle) for angle in frame.fold_angles.tolist()],
    }
    if frame.assignments != fold.assignments:  # a crease may change sign, or pass through flat, along the motion
        written["edges_assignment"] = list(frame.assignments)
    return written


def _folded_form(design: CreasePattern, k: int) -> FoldFrame:
    """Folded vertices, assignments and fold angles of the edges at driving angle ``k``."""
    assignments = dataclasses.replace(design, best=k).assignments
    still = [letter in (BOUNDARY, FLAT) for letter in assignments]
    angles = np.where(still, 0.0, np.clip(design.fold_angles[k], -math.pi, math.pi))
    return FoldFrame(float(design.driving_angles[k]), design.folded[k], angles, assignments)


def _edge_faces(fold: FoldFile) -> list[list[int]]:
    """The panels beside each edge, the left one first; one on the boundary, two elsewhere."""
    left = {
        (u, v): index
        for index, panel in enumerate(fold.panels)
        for u, v in zip(panel, (*panel[1:], panel[0]), strict=True)
    }
    return [[left[side] for side in ((int(u), int(v)), (int(v), int(u))) if side in left] for u, v in fold.edges]


def _stated(fold: FoldFile) -> list[float | None]:
    """Fold angles in degrees, null where they were only assumed."""
    assumed = [False] * len(fold.edges) if fold.assumed is None else fold.assumed.tolist()
    return [None if guess else _degrees(x) for x, guess in zip(fold.fold_angles.tolist(), assumed, strict=True)]


def _numbers(rows: NDArray[np.float64]) -> list[list[float]]:
    """Nested lists at full precision, without negative zeros."""
    if not np.isfinite(rows).all():
        raise ValueError("a design with coordinates that are not finite cannot be written")
    nested: list[list[float]] = (rows + 0.0).tolist()
    return nested


def _degrees(radians: float) -> float:
    """Degrees without a negative zero; not finite is refused as in :func:`_numbers`.

    At 13 decimals, 10⁻¹⁵ radians, reading and writing again gives the same number; at more it need not.
    """
    if not math.isfinite(radians):
        raise ValueError("a design with angles that are not finite cannot be written")
    return round(math.degrees(radians), 13) + 0.0


def _plain(value: object) -> Any:
    """``value`` as JSON has it: NumPy scalars become Python's, numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _dump(fold: Mapping[str, Any]) -> str:
    """JSON that a person can read and that is not much longer than need be."""
    return "\n".join(_lines(fold, "")) + "\n"


def _is_long(value: Any) -> bool:
    """Whether a list or dictionary has so many items that it cannot fit into a line: it need not be tried."""
    if isinstance(value, dict):
        value = list(value.values())
    return isinstance(value, list) and (3 * len(value) > _LINE or any(map(_is_long, value)))


def _lines(value: Any, indent: str, taken: int = 0) -> Iterator[str]:
    """``value`` on one line where it fits; else a key, a dictionary or as many items as fit per line.

    ``taken`` columns of the first line hold the key.
    """
    if not _is_long(value):
        inline = _ENCODED(value)
        if len(indent) + taken + len(inline) < _LINE or not isinstance(value, dict | list) or not value:
            yield inline
            return
    inner = indent + " "
    if isinstance(value, dict):
        yield "{"
        for index, (key, item) in enumerate(value.items()):
            name = json.dumps(key) + ": "
            first, *rest = _lines(item, inner, len(name))
            block = [inner + name + first, *rest]
            block[-1] += "," if index < len(value) - 1 else ""
            yield from block
        yield indent + "}"
        return
    yield "["
    row = inner
    for index, item in enumerate(value):
        first, *rest = _lines(item, inner) if isinstance(item, dict) else [_ENCODED(item)]
        comma = "," if index < len(value) - 1 else ""
        if rest:
            block = [inner + first, *rest]
            block[-1] += comma
            yield from block
            continue
        if row != inner and len(row) + len(first) + 2 > _LINE:
            yield row
            row = inner
        row += ("" if row == inner else " ") + first + comma
    if row != inner:
        yield row
    yield indent + "]"
