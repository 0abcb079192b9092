"""The states that the file claims: rigid panels, fold angles as measured, loops that close, flat-foldability."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.certificate import FACT, OK, OPEN, WRONG, Check, degrees
from origami_lab.verification.file_rounding import FAR_BENT, FAR_TURNED, SAME_ANGLE, Allowance
from origami_lab.verification.flat_sheet import Sheet
from origami_lab.verification.fold_document import Document, Frame
from origami_lab.verification.linkage import Linkage
from origami_lab.verification.measured_panels import bending, diameters, fold_angles, length_error
from origami_lab.verification.plane_graph import Array

_IMPRECISE = "too imprecise to tell"
_SIGNS = {"V": 1.0, "M": -1.0}


@dataclass(frozen=True, eq=False)
class Claim:
    """A state of the file, by its fold angles."""

    name: str
    driving: float | None
    """What the file says, radians."""
    rho: Array
    """(E,) measured, or stated where the file has angles only."""
    frame: Frame | None = None
    """Where it stands in the file; None for the fold angles of the crease pattern itself."""


def claims(sheet: Sheet, document: Document) -> list[Claim]:
    """All folded states; near ±180° the sign of a measured angle is the one that the file states.

    The fold angles of the crease pattern itself are one more where no frame shows them.
    """
    found = []
    for frame in document.frames:
        name = _name(frame.name, frame.driving)
        if frame.coords is not None:
            rho = fold_angles(sheet, frame.coords)
            signs = np.zeros(len(rho)) if frame.angles is None else np.sign(np.nan_to_num(frame.angles))
            signs = np.where(signs != 0.0, signs, [_SIGNS.get(letter, 0.0) for letter in frame.letters])
            turned = (np.abs(rho) > math.pi - SAME_ANGLE) & (signs * rho < 0.0)
            found.append(Claim(name, frame.driving, np.where(turned, -rho, rho), frame))
        elif frame.angles is not None and np.isfinite(frame.angles[sheet.inner]).all():
            found.append(Claim(name, frame.driving, np.where(sheet.inner, frame.angles, 0.0), frame))
    stated = _stated(sheet, document)
    if stated is not None and np.isfinite(stated).all() and stated.any():
        if not any(np.abs(wrapped(stated - claim.rho)).max(initial=0.0) <= SAME_ANGLE for claim in found):
            found.append(Claim("the crease pattern's fold angles", None, stated))
    return found


def half_stated(sheet: Sheet, document: Document) -> list[str]:
    """Frames with fold angles only that leave some crease open, each in a line: no state can be had from them."""
    lines = []
    for frame in document.frames:
        if frame.coords is None and frame.angles is not None:
            missing = np.flatnonzero(sheet.inner & ~np.isfinite(frame.angles))
            if len(missing):
                lines.append(f"{frame.name} has fold angles only, and none for edge {missing[0]}")
    return lines


def _stated(sheet: Sheet, document: Document) -> Array | None:
    """(E,) the crease pattern's own fold angles, 0 on the boundary, NaN where it leaves one open."""
    return None if document.angles is None else np.where(sheet.inner, document.angles, 0.0)


def _name(name: str, driving: float | None) -> str:
    return name if driving is None else f"{name} ({degrees(driving)})"


def check_panels(sheet: Sheet, document: Document, allowed: Allowance) -> Check:
    """Every folded panel is congruent to its flat self."""
    frames = [frame for frame in document.frames if frame.coords is not None]
    if not frames:
        return Check("panels rigid", FACT, "the file has no folded vertices; panels are rigid by construction here")
    found = [_bent(sheet, frame.coords) for frame in frames]
    lengths_off = [bent * diameters(sheet) for bent in found]
    beyond = [off / allowed.rigid for off in lengths_off]
    at = max(range(len(frames)), key=lambda k: float(beyond[k].max()))
    panel, frame = int(beyond[at].argmax()), frames[at]
    worst = float(found[at][panel])
    lengths = max(length_error(sheet, frame.coords)[0] for frame in frames if frame.coords is not None)
    numbers = {
        "largest_deviation": worst,
        "largest_deviation_length": max(float(off.max()) for off in lengths_off),
        "largest_length_error": lengths,
        "frames": len(frames),
    }
    status = allowed.status(float(beyond[at][panel])) if math.isfinite(worst) else WRONG
    if status == OK and worst > FAR_BENT:
        status = OPEN
    if status != OK:
        text = f"bent or stretched by {worst:.2g} of its diameter in {_name(frame.name, frame.driving)}"
        text = f"panel {panel} is {text}" if status == WRONG else f"{_IMPRECISE}: panel {panel} may be {text}"
        return Check("panels rigid", status, text, numbers | {"panel": panel}, angle=_angle(frame.driving))
    text = f"in {len(frames)} states, to {worst:.1e} of a panel's diameter; edge lengths to {lengths:.1e}"
    return Check("panels rigid", OK, text, numbers)


def _bent(sheet: Sheet, coords: Array | None) -> Array:
    return np.empty(0) if coords is None else bending(sheet, coords)


def check_fold_angles(sheet: Sheet, document: Document, found: list[Claim], allowed: Allowance) -> Check:
    """Stated fold angles are the measured ones, assignments have their signs, driven creases the driving angle."""
    compared, worst = 0, 0.0
    doubts: list[Check] = []
    for claim in found:
        frame = claim.frame
        letters = document.letters if frame is None else frame.letters
        off, e = _against(letters, claim.rho, allowed)
        faults = [(off, e, f"is {letters[e]} but folds by {degrees(claim.rho[e])}")]
        if frame is not None and frame.coords is not None and frame.angles is not None:
            known = sheet.inner & np.isfinite(frame.angles)
            compared += int(known.sum())
            error = np.where(known, np.abs(wrapped(frame.angles - claim.rho)), 0.0)
            worst = max(worst, float(error.max(initial=0.0)))
            e = int((error / allowed.angle).argmax())
            text = f"folds by {degrees(claim.rho[e])}, not {degrees(np.nan_to_num(frame.angles[e]))}"
            faults.insert(0, (float(error[e] / allowed.angle[e]), e, text))
        if document.driven is not None and claim.driving is not None:
            error = np.abs(np.abs(claim.rho) - abs(claim.driving)) * (document.driven & sheet.inner)
            e = int((error / allowed.angle).argmax())
            faults.append((float(error[e] / allowed.angle[e]), e, f"is driven but folds by {degrees(claim.rho[e])}"))
        for times, e, text in faults:
            if (status := allowed.status(times)) != OK:
                check = _wrong(sheet, e, f"edge {e} {text} in {claim.name}", claim.driving, status)
                if status == WRONG:
                    return check
                doubts.append(check)
    if (key := _key_is_none(sheet, document, found, allowed)) is not None:
        doubts.append(key)
    if worst > FAR_TURNED:
        text = f"{_IMPRECISE}: stated fold angles differ from the measured ones by {degrees(worst)}"
        doubts.append(Check("fold angles", OPEN, text, {"largest_error": math.degrees(worst)}))
    if doubts:
        return next((check for check in doubts if check.status == WRONG), doubts[0])
    if not compared:
        return Check("fold angles", FACT, "the file states none beside its folded vertices")
    return Check(
        "fold angles",
        OK,
        f"{compared} agree with the geometry to {math.degrees(worst):.1e}°",
        {"largest_error": math.degrees(worst)},
    )


def _against(letters: Sequence[str], rho: Array, allowed: Allowance) -> tuple[float, int]:
    """How many times further than allowed an edge folds against its letter, and which one does most so."""
    signs = np.array([_SIGNS.get(letter, 0.0) for letter in letters])
    flat = np.array([letter == "F" for letter in letters])
    off = np.maximum(-signs * rho, np.where(flat, np.abs(rho), 0.0)) / allowed.angle
    e = int(off.argmax())
    return float(off[e]), e


def _key_is_none(sheet: Sheet, document: Document, found: list[Claim], allowed: Allowance) -> Check | None:
    """The crease pattern's own fold angles and letters are those of a state of the file.

    Where it says what is driven, angles of no state contradict it; else they are a state of their own (:func:`claims`).
    """
    folded = [claim for claim in found if np.abs(claim.rho).max(initial=0.0) > SAME_ANGLE]
    frames = [claim for claim in folded if claim.frame is not None]
    stated = _stated(sheet, document)
    if stated is not None and frames and np.nan_to_num(stated).any():
        errors = [
            np.abs(wrapped(np.where(np.isnan(stated), claim.rho, stated) - claim.rho)) / allowed.angle
            for claim in frames
        ]
        nearest = min(range(len(errors)), key=lambda k: float(errors[k].max()))
        e = int(errors[nearest].argmax())
        if (status := allowed.status(float(errors[nearest][e]))) != OK:
            state = frames[nearest]
            text = f"edge {e} is said to fold by {degrees(stated[e])} but the nearest state, {state.name}, folds it by "
            text += degrees(state.rho[e])
            if document.driven is not None:
                return _wrong(sheet, e, text, state.driving, status)
            if np.isnan(stated).any():
                return Check("fold angles", OPEN, text, {"edge": e})
    if folded and all(_against(document.letters, claim.rho, allowed)[0] > 1.0 for claim in folded):
        edge = _against(document.letters, folded[-1].rho, allowed)[1]
        text = f"no state of the file folds as the crease pattern's letters say (edge {edge})"
        return Check("fold angles", OPEN, text, {"edge": edge})
    return None


def _wrong(sheet: Sheet, e: int, text: str, driving: float | None, status: str = WRONG) -> Check:
    panels = tuple(int(f) for f in sheet.beside[e])
    beside = (panels[0], panels[1]) if min(panels) >= 0 else None
    text = text if status == WRONG else f"{_IMPRECISE}: {text}"
    return Check("fold angles", status, text, {"edge": e}, beside, _angle(driving))


def _angle(driving: float | None) -> float | None:
    return None if driving is None else math.degrees(driving)


def wrapped(angle: Array) -> Array:
    """Differences of angles, in [−π, π]."""
    return np.asarray(np.remainder(angle + math.pi, 2.0 * math.pi) - math.pi)


def check_loops(linkage: Linkage, found: list[Claim], allowed: Allowance) -> Check:
    """The rotations around each interior vertex multiply to the identity at every state of the file."""
    fans = linkage.sheet.fans
    if not found or not fans:
        text = "there is no interior vertex" if not fans else "the file has no folded state"
        return Check("loops close", FACT, text, {"vertices": len(fans)})
    residuals = [linkage.closure(claim.rho).angle for claim in found]
    worst = max(range(len(found)), key=lambda k: float((residuals[k] / allowed.closed).max()))
    at = int((residuals[worst] / allowed.closed).argmax())
    largest = max(float(residual.max()) for residual in residuals)
    numbers = {"vertices": len(fans), "largest_residual": math.degrees(largest)}
    off = float(residuals[worst][at])
    status = allowed.status(off / float(allowed.closed[at]))
    if status == OK and off > FAR_TURNED:
        status = OPEN
    if status != OK:
        vertex = fans[at].vertex
        text = f"around vertex {vertex} the fold angles miss closing by {degrees(off)} in {found[worst].name}"
        text = text if status == WRONG else f"{_IMPRECISE}: {text}"
        return Check("loops close", status, text, numbers | {"vertex": vertex}, angle=_angle(found[worst].driving))
    return Check("loops close", OK, f"around {len(fans)} vertices, to {math.degrees(largest):.1e}°", numbers)


def check_flat_foldability(sheet: Sheet, document: Document, found: list[Claim]) -> Check:
    """Kawasaki and Maekawa: facts about each interior vertex; a must only where the file claims a flat-folded state."""
    kawasaki, maekawa, known = [], [], 0
    for fan in sheet.fans:
        folds = [i for i, e in enumerate(fan.edges) if document.letters[e] not in "FJ"]
        if not folds:
            continue
        known += 1
        merged = np.add.reduceat(np.roll(fan.sectors, -folds[0]), np.array(folds) - folds[0])
        if len(folds) % 2 or abs(merged[::2].sum() - math.pi) > 1e-7:
            kawasaki.append(fan.vertex)
        letters = [document.letters[fan.edges[i]] for i in folds]
        if abs(letters.count("M") - letters.count("V")) != 2:
            maekawa.append(fan.vertex)
    numbers = {"vertices": known, "kawasaki_fails": kawasaki, "maekawa_fails": maekawa}
    flat = next((claim for claim in found if _folded_flat(sheet, claim.rho)), None)
    if flat is not None and kawasaki:
        text = f"{flat.name} is folded flat, which vertex {kawasaki[0]} cannot be (Kawasaki)"
        return Check("flat-foldable", WRONG, text, numbers)
    ways = known - len(kawasaki), known - len(set(kawasaki) | set(maekawa))
    text = f"{ways[0]} of {known} interior vertices satisfy Kawasaki, {ways[1]} of them Maekawa, too"
    return Check("flat-foldable", FACT, text, numbers)


def _folded_flat(sheet: Sheet, rho: Array) -> bool:
    size = np.abs(rho[sheet.inner])
    return bool(len(size) and np.all((size < SAME_ANGLE) | (size > math.pi - SAME_ANGLE)) and np.any(size > 1.0))


def held_flat(sheet: Sheet, document: Document, found: list[Claim]) -> NDArray[np.bool_]:
    """(E,) edges that the file marks flat and that never fold: their panels are one."""
    marked = np.array([letter in "FJ" for letter in document.letters])
    folds = np.max([np.abs(claim.rho) for claim in found], axis=0) if found else np.zeros(len(marked))
    return np.asarray(sheet.inner & marked & (folds <= SAME_ANGLE / 10.0))
