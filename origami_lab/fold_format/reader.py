"""Reading FOLD files from anywhere: everything is checked; a wrong file is one line, never a traceback."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.fold_format.fold_angles import measured_angles
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.laid_flat import UnfoldError, unfold
from origami_lab.fold_format.model import FoldModel, FoldState, panels_of
from origami_lab.fold_format.model_reader import read_model

Array = NDArray[np.float64]
_FLAT = 1e-6
"""Radians: an edge without assignments that folds by no more is flat."""


def read_fold(path: str | os.PathLike[str], frame: int | None = None) -> FoldFile:
    """Read and check a FOLD file of any program.

    Needed are ``vertices_coords`` and ``edges_vertices``, or ``faces_vertices``, of a crease pattern or of a folded
    form, which is laid flat then. Assignments that are missing follow from fold angles; fold angles that are missing
    are ±180° for M and V, and marked as assumed; faces are found between the edges. Folded forms with coordinates
    become frames.
    What was assumed stands in ``remarks``.

    Parameters
    ----------
    frame
        The number of a frame, 0 for the key frame: of a crease pattern, or of a state, which becomes the last one.
        By default the first crease pattern with all its states.

    Raises
    ------
    InputError
        Its field is the path (or ``frame``): on anything that is not such a file.
    """
    return fold_file_of(read_model(path, frame), str(path))


def fold_file_of(model: FoldModel, name: str) -> FoldFile:
    """What a file shows as a pattern with folded forms.

    Raises :class:`InputError`, whose field is ``name``, where there is no crease pattern and none can be unfolded.
    """
    remarks = list(model.remarks)
    if model.fault:
        raise InputError(name, f"frame {model.index}", f"must be flat: {model.fault}")
    states = list(model.states)
    if model.chosen is not None:
        states.append(states.pop(model.chosen))
    elif states and states[0].index == 0:  # what a file shows first is what it is about
        states.append(states.pop(0))
    flat = model.flat
    if flat is None:
        flat = _laid_flat(model, name)
        remarks.append(f"the file has no crease pattern: the sheet of frame {model.index} was laid flat")
    panels = model.faces if model.faces is not None and model.flat is not None else panels_of(model)
    if not panels:
        remarks.append("no panels: the file lists no faces and none lie between its edges, which cross or are open")
    last = states[-1] if model.chosen is not None or model.flat is None else None
    letters = model.letters if last is None else last.letters
    stated = model.angles if last is None else _angles_of(model, last, panels)
    shown = [state for state in states if state.coords is not None]
    if stated is None and shown:
        stated = _angles_of(model, shown[-1], panels)
        remarks.append(f"the crease pattern states no fold angles: those of {shown[-1].name} are taken")
    assignments, angles, assumed = _completed(model, panels, letters, stated, remarks)
    frames = tuple(
        FoldFrame(
            state.driving, state.coords, np.nan_to_num(_angles_of(model, state, panels)), _said(state, assignments)
        )
        for state in states
        if state.coords is not None
    )
    return FoldFile(
        vertices=np.ascontiguousarray(flat),
        edges=model.edges.astype(np.int32),
        assignments=assignments,
        fold_angles=angles,
        panels=panels,
        modes=model.modes,
        driven=model.driven,
        frames=frames if last is None or last.coords is not None else (),
        actions=model.actions,
        title=model.title,
        metadata=model.metadata,
        loose=model.loose if model.loose.any() else None,
        precision=model.precision,
        assumed=assumed if assumed.any() else None,
        remarks=(*remarks, *model.unread),
    )


def _laid_flat(model: FoldModel, name: str) -> Array:
    """(V, 2) the sheet of a file that has folded forms only; vertices of no panel lie in the origin."""
    state = next((state for state in model.states if state.coords is not None), None)
    if state is None or state.coords is None or model.faces is None:
        value = "no crease pattern" if state is None else "a folded form without faces_vertices"
        raise InputError(name, value, "must have a crease pattern, or a folded form with its faces, to lay it flat")
    try:
        flat = unfold(model.faces, state.coords, 4.0 * model.precision.folded)
    except UnfoldError as error:
        raise InputError(name, state.name, f"cannot be laid flat: {error}") from None
    return np.nan_to_num(flat)


def _angles_of(model: FoldModel, state: FoldState, panels: Sequence[tuple[int, ...]]) -> Array:
    """(E,) fold angles of a state, measured where it states none; NaN where neither is possible."""
    if state.angles is not None and (np.isfinite(state.angles).all() or state.coords is None):
        return state.angles
    measured = np.full(len(model.edges), np.nan)
    if state.coords is not None:
        measured = measured_angles(model.edges, panels, state.coords, state.letters)
    return measured if state.angles is None else np.where(np.isfinite(state.angles), state.angles, measured)


def _said(state: FoldState, assignments: tuple[str, ...]) -> tuple[str, ...]:
    """The letters of a state; the pattern's where the file has none."""
    return assignments if set(state.letters) == {"U"} else state.letters


def _completed(
    model: FoldModel,
    panels: Sequence[tuple[int, ...]],
    letters: tuple[str, ...] | None,
    stated: Array | None,
    remarks: list[str],
) -> tuple[tuple[str, ...], Array, NDArray[np.bool_]]:
    """Letters from angles and angles from letters, where the file leaves out one of them; (E,) what was assumed."""
    count = len(model.edges)
    known = np.zeros(count, dtype=np.bool_) if stated is None else np.isfinite(stated)
    angles = np.zeros(count) if stated is None else np.nan_to_num(stated)
    if model.letters is None:
        sides = [{*side} for face in panels for side in zip(face, (*face[1:], face[0]), strict=True)]
        faces_at: dict[frozenset[int], int] = {}
        for side in sides:
            faces_at[frozenset(side)] = faces_at.get(frozenset(side), 0) + 1
        letters = tuple(
            "B" if faces_at.get(frozenset(edge), 0) == 1
            else "U" if not has
            else "F" if abs(angle) <= _FLAT
            else "V" if angle > 0.0
            else "M"
            for edge, has, angle in zip(model.edges.tolist(), known.tolist(), angles.tolist(), strict=True)
        )  # fmt: skip
        remarks.append("the file has no assignments: boundary by the faces, mountains and valleys by the fold angles")
    assert letters is not None
    folds = np.array([{"V": math.pi, "M": -math.pi}.get(letter, 0.0) for letter in letters])
    assumed = ~known & (folds != 0.0)
    if assumed.any():
        what = (
            "the file states no fold angles" if not known.any() else f"{int(assumed.sum())} creases have no fold angle"
        )
        remarks.append(f"{what}: 180° is assumed for V, −180° for M")
    return letters, np.where(assumed, folds, angles), assumed
