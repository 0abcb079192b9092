"""Folding a crease pattern that states its fold angles: the sheet in space, and its motion from the flat sheet."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from origami_lab.fold_format.flat_graph import Face
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.verification.continuation import Motion, StuckError
from origami_lab.verification.flat_sheet import Sheet, SheetError, UndecidableError, build_sheet
from origami_lab.verification.fold_document import MOST_EDGES, MOST_FACES, MOST_VERTICES, Document
from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.plane_graph import Array
from origami_lab.verification.threads import one_thread

_CLOSES = math.radians(0.1)
"""Stated angles miss closing a loop by no more, beside what the file rounds off."""
_MEETS = 1e-6
"""Of the sheet's size: placed panels that miss each other by no more meet."""
_STEPS = 10
"""States of a motion, the stated one included."""
MOST_CREASES = 800
"""Unknown fold angles of a motion that is followed; the stated angles of more are taken as they stand."""
_WORK = 1e11
"""Bounds the states of a motion: so many times the cube of the number of unknowns."""
_ZERO = 1e-8
"""Of the largest singular value: smaller ones count as zero."""


class FoldingError(Exception):
    """The pattern cannot be folded as it says; the message says why."""


def fold_pattern(
    fold: FoldFile, degrees: float | None = None, moving: bool = True
) -> tuple[tuple[FoldFrame, ...], str]:
    """Fold a pattern by its own fold angles.

    Parameters
    ----------
    degrees
        A driving angle to stop at: how far the creases that drive fold, which are those that the file declares or, in a
        pattern with one degree of freedom, the one that folds furthest. By default the stated angles.
    moving
        Whether states on the way from the flat sheet are wanted, too.

    Returns
    -------
    frames, note
        The states from nearly flat to the stated one, or the one at ``degrees``, which is the last; only that one where
        the motion cannot be followed, and then a line that says why.

    Raises :class:`FoldingError` where the angles are not known, do not close, or cannot be reached.
    """
    with one_thread():
        return _fold(fold, degrees, moving)


def _fold(fold: FoldFile, degrees: float | None, moving: bool) -> tuple[tuple[FoldFrame, ...], str]:
    document = _document(fold)
    for count, most, what in (
        (len(fold.vertices), MOST_VERTICES, "vertices"),
        (len(fold.edges), MOST_EDGES, "edges"),
        (len(fold.panels), MOST_FACES, "panels"),
    ):
        if count > most:
            raise FoldingError(f"it has {count} {what}, at most {most} are folded")
    try:
        sheet = build_sheet(fold.vertices, document)
    except (SheetError, UndecidableError) as error:
        raise FoldingError(str(error)) from None
    linkage = Linkage(sheet)
    rho = _stated(sheet, document)
    rho, residual = _closed(linkage, rho, document)
    motion, note = _motion(linkage, document, rho) if moving or degrees is not None else (None, "")
    if motion is None:
        if degrees is not None:
            raise FoldingError(f"only the stated angles can be folded: {note}")
        return (_frame(fold, linkage, linkage.place(0.0, rho, np.zeros(len(rho)), residual), None),), note
    end = float(np.abs(rho[motion.drive != 0.0]).max())
    goal = end if degrees is None else math.radians(degrees)
    if not 0.0 < goal <= end + 1e-9:
        raise FoldingError(f"the driving angle must be above 0 and at most {math.degrees(end):.6g}, as far as it folds")
    states, note = _followed(motion, rho, residual, min(goal, end), _STEPS if moving else 1)
    if degrees is not None and not (states and abs(states[-1].driving - min(goal, end)) < 1e-9):
        raise FoldingError(f"the motion could not be followed to {degrees:g}°")
    return tuple(_frame(fold, linkage, state, state.driving) for state in states), note


def _document(fold: FoldFile) -> Document:
    """The pattern as it is to be checked."""
    angles = fold.fold_angles if fold.assumed is None else np.where(fold.assumed, np.nan, fold.fold_angles)
    return Document(
        flat=fold.vertices,
        edges=fold.edges.astype(np.int64),
        faces=fold.panels or None,
        letters=fold.assignments,
        angles=angles,
        driven=fold.driven,
        frames=(),
        loose=fold.loose,
        precision=fold.precision,
    )


def _stated(sheet: Sheet, document: Document) -> Array:
    """(E,) the stated fold angles, 0 on the boundary; raises where a crease has none."""
    assert document.angles is not None
    rho = np.where(sheet.inner, document.angles, 0.0)
    unknown = np.flatnonzero(~np.isfinite(rho))
    if len(unknown) == int(sheet.inner.sum()) or (len(unknown) and not np.nan_to_num(rho).any()):
        raise FoldingError("the file states no fold angles (edges_foldAngle) and has no folded frame")
    if len(unknown):
        raise FoldingError(f"edge {unknown[0]} has no fold angle, {len(unknown)} in all: how far they fold is open")
    return rho


def _closed(linkage: Linkage, rho: Array, document: Document) -> tuple[Array, float]:
    """Fold angles nearest to the stated ones that close all loops, and what is left open; raises if they are far."""
    sheet = linkage.sheet
    if not sheet.fans:
        return rho, 0.0
    angle = linkage.closure(rho).angle
    at = int(angle.argmax())
    fan = sheet.fans[at]
    shortest = min(float(np.linalg.norm(np.diff(sheet.points[sheet.edges[e]], axis=0))) for e in fan.edges)
    off = len(fan.edges) * (document.precision.angle + 4.0 * document.precision.flat / shortest)
    if not angle[at] <= _CLOSES + off:
        text = f"around vertex {fan.vertex} the fold angles miss closing by {math.degrees(angle[at]):.4g}°"
        raise FoldingError(text)
    free = np.flatnonzero(sheet.inner & ~_held(sheet, document, rho))
    best, least = rho, float(angle.max())
    if len(free) > MOST_CREASES:
        return best, least
    closure = linkage.closure(rho)
    for _ in range(20):
        jacobian, error = closure.jacobian(free), closure.error.reshape(-1)
        step = linalg.lstsq(jacobian, -error, cond=1e-9, lapack_driver="gelsy", check_finite=False)[0]
        rho = rho.copy()
        rho[free] += step
        closure = linkage.closure(rho)
        if not float(closure.angle.max()) < least:
            break
        best, least = rho, float(closure.angle.max())
    return best, least


def _held(sheet: Sheet, document: Document, rho: Array) -> NDArray[np.bool_]:
    """(E,) creases that are marked flat and do not fold."""
    return np.asarray(sheet.inner & np.array([letter in "FJ" for letter in document.letters]) & (rho == 0.0))


def _motion(linkage: Linkage, document: Document, rho: Array) -> tuple[Motion | None, str]:
    """The motion that leads to a state, or None and why there is none to follow."""
    sheet = linkage.sheet
    if not np.abs(rho).max(initial=0.0) > 0.0:
        return None, ""
    held = _held(sheet, document, rho)
    free = np.flatnonzero(sheet.inner & ~held)
    driven = np.zeros(len(rho), dtype=np.bool_) if document.driven is None else document.driven & sheet.inner
    if sheet.holes:
        return None, "the sheet has a hole, and motions around holes are not followed"
    if len(free) > MOST_CREASES:
        return None, f"the motion of more than {MOST_CREASES} creases is not followed"
    drive = np.where(driven, np.sign(rho), 0.0)
    if not driven.any():
        values = linalg.svdvals(linkage.closure(rho).jacobian(free)) if sheet.fans else np.empty(0)
        zero = max(_ZERO, 100.0 * document.precision.flat / sheet.size) * values.max(initial=0.0)
        freedoms = len(free) - int(np.sum(values > zero))
        if freedoms != 1:
            return (
                None,
                f"the motion is not followed: {freedoms} degrees of freedom, and no driven creases are declared",
            )
        drive[int(np.argmax(np.abs(rho)))] = np.sign(rho[int(np.argmax(np.abs(rho)))])
    return Motion(linkage, held, drive), ""


def _followed(motion: Motion, rho: Array, residual: float, goal: float, steps: int) -> tuple[list[State], str]:
    """The states up to ``goal``, the nearly flat one first."""
    end = float(np.abs(rho[motion.drive != 0.0]).max())
    here = motion.solve(end, rho)
    if here is None:
        still = motion.linkage.place(end, rho, np.zeros(len(rho)), residual)
        return [still], "the motion is not followed: the loops do not close well enough around the stated angles"
    found = [here] if goal == end else []
    most = int(min(max(_WORK / (len(motion.free) ** 3 + 1e7) / steps, 20), 4000))
    for part in range(steps if goal < end else steps - 1, 0, -1):
        try:
            here = motion.walk(here, goal * part / steps, most)[-1]
        except StuckError as stuck:
            low = math.degrees(stuck.states[-1].driving)
            return found[::-1], f"the motion could not be followed below {low:.4g}°"
        found.append(here)
    return found[::-1], ""


def _frame(fold: FoldFile, linkage: Linkage, state: State, driving: float | None) -> FoldFrame:
    """A state as a folded form; raises where panels that share a vertex do not meet there."""
    sheet = linkage.sheet
    coords = linkage.vertices(state)
    for index, face in enumerate(sheet.faces):
        ring = list(face)
        there = linkage.flat[ring] @ state.turn[index].T + state.shift[index]
        miss = float(np.abs(there - coords[ring]).max())
        if miss > _MEETS * sheet.size + 100.0 * fold.precision.flat:
            raise FoldingError(f"the fold angles tear the sheet: panels miss each other by {miss:.2g} at panel {index}")
    for v in np.flatnonzero(np.isnan(coords[:, 0])):  # of an auxiliary line: it stays on its panel
        face_index = _panel_at(sheet, fold.vertices[v])
        coords[v] = linkage.flat[v] @ state.turn[face_index].T + state.shift[face_index]
    letters = tuple(
        letter if letter not in "MV" or abs(angle) < 1e-6 else "V" if angle > 0.0 else "M"
        for letter, angle in zip(fold.assignments, state.rho.tolist(), strict=True)
    )
    return FoldFrame(driving, coords, state.rho, letters)


def _panel_at(sheet: Sheet, point: Array) -> int:
    """The panel that a flat point lies on, or the one whose middle is nearest."""
    for index, face in enumerate(sheet.faces):
        if _inside(sheet.points, face, point):
            return index
    middles = np.array([sheet.points[list(face)].mean(axis=0) for face in sheet.faces])
    return int(np.argmin(np.linalg.norm(middles - point, axis=1)))


def _inside(points: Array, face: Face, point: Array) -> bool:
    """Whether a point lies in a polygon: a ray towards +x leaves it an odd number of times."""
    inside = False
    for u, v in zip(face, (*face[1:], face[0]), strict=True):
        (ax, ay), (bx, by) = points[u], points[v]
        if (ay > point[1]) != (by > point[1]) and point[0] < ax + (point[1] - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside
