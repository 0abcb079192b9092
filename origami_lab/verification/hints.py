"""Hints beside a refutation: habits of other programs that look like a wrong design."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from origami_lab.verification.certificate import WRONG, Check
from origami_lab.verification.flat_sheet import Sheet
from origami_lab.verification.fold_document import Document
from origami_lab.verification.measured_panels import fold_angles
from origami_lab.verification.plane_graph import Array

_FOLDS = math.radians(0.02)
"""Below this a crease counts as flat."""
_ALIKE = 1e-4
"""Relative spread of ratios that are one ratio."""


def hinted(check: Check, sheet: Sheet, document: Document) -> Check:
    """The check with a hint behind its text, where it refutes and the file shows a known habit."""
    if check.status != WRONG:
        return check
    known = {"panels rigid": _scaled, "fold angles": _turned, "loops close": _targets_only}.get(check.name)
    hint = "" if known is None else known(sheet, document)
    return replace(check, text=f"{check.text}; hint: {hint}") if hint else check


def _scaled(sheet: Sheet, document: Document) -> str:
    """Whether a folded form is a scaled one: all edges are longer, or shorter, by one factor."""
    u, v = sheet.edges[(sheet.beside >= 0).any(axis=1)].T
    flat = np.linalg.norm(sheet.points[u] - sheet.points[v], axis=1)
    for frame in document.frames:
        if frame.coords is None:
            continue
        ratio = np.linalg.norm(frame.coords[u] - frame.coords[v], axis=1) / flat
        factor = float(np.median(ratio))
        off = 2.0 * document.precision.length / float(flat.min())
        if abs(factor - 1.0) > _ALIKE and np.ptp(ratio) <= max(_ALIKE * factor, off):
            return f"every edge of {frame.name} is {factor:.6g} times as long as in the crease pattern, one is scaled"
    return ""


def _turned(sheet: Sheet, document: Document) -> str:
    """Whether all signs are reversed, angles are radians, or the targets of a simulation."""
    for frame in document.frames:
        if frame.coords is None:
            continue
        rho = fold_angles(sheet, frame.coords)
        folds = sheet.inner & (np.abs(rho) > _FOLDS) & (np.abs(rho) < math.pi - _FOLDS)
        letters = np.array([{"V": 1.0, "M": -1.0}.get(letter, 0.0) for letter in frame.letters])
        stated = np.zeros(len(rho)) if frame.angles is None else np.nan_to_num(frame.angles)
        for name, signs in (("fold angles", np.sign(stated)), ("mountains and valleys", letters)):
            some = folds & (signs != 0.0)
            if some.any() and np.all(signs[some] * rho[some] < 0.0):
                return f"all {name} are the other way round in {frame.name}: signs reversed, or seen from below"
        some = folds & (stated != 0.0)
        if some.any() and np.allclose(np.degrees(stated[some]), rho[some], atol=_FOLDS):
            return "the fold angles look like radians, FOLD has degrees"
        if some.any() and np.all(stated[some] * rho[some] > 0.0) and _beyond(stated[some], rho[some]):
            return _target_text(document, frame.name)
        flat = sheet.inner & (np.abs(rho) <= _FOLDS) & (stated != 0.0)
        if not folds.any() and flat.any():
            return _target_text(document, frame.name)
    said = [("the crease pattern", document.letters, document.angles)]
    said += [(frame.name, frame.letters, frame.angles) for frame in document.frames if frame.coords is None]
    for name, letters_said, angles in said:
        signs = np.array([{"V": 1.0, "M": -1.0}.get(letter, 0.0) for letter in letters_said])
        stated = np.zeros(len(signs)) if angles is None else np.sign(np.nan_to_num(angles))
        both = (signs != 0.0) & (stated != 0.0)
        if both.any() and np.all(signs[both] == -stated[both]):
            return (
                f"all mountains have the fold angles of valleys in {name}: signs reversed, FOLD's valleys are positive"
            )
    return ""


def _beyond(stated: Array, rho: Array) -> bool:
    """Whether fold angles are stated that are nowhere smaller than the measured ones, and larger somewhere."""
    more = np.abs(stated) - np.abs(rho)
    return bool(np.all(more > -_FOLDS) and np.any(more > _FOLDS))


def _targets_only(sheet: Sheet, document: Document) -> str:
    """Whether fold angles that do not close are what a simulation aims at: all a full turn, or by their program."""
    stated = [angles for angles in (document.angles, *(f.angles for f in document.frames)) if angles is not None]
    for angles in stated:
        size = np.abs(np.nan_to_num(angles[sheet.inner]))
        if np.all((size < _FOLDS) | (size > math.pi - _FOLDS)) and np.any(size > _FOLDS):
            return _target_text(document, "the file")
    return _target_text(document, "the file") if "Origami Simulator" in document.creator else ""


def _target_text(document: Document, where: str) -> str:
    by = "Origami Simulator wrote this file; its" if "Origami Simulator" in document.creator else "the"
    habit = "" if "Origami Simulator" in document.creator else ", as Origami Simulator writes them"
    return f"{by} fold angles may be targets of a simulation{habit}, not those of {where}"
