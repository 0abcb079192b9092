"""The states that the file claims: rigid panels, fold angles as measured, loops that close, flat-foldability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.certificate import FACT, OK, WRONG, Check, degrees
from origami_lab.verification.flat_sheet import Sheet
from origami_lab.verification.fold_document import Document
from origami_lab.verification.linkage import Linkage
from origami_lab.verification.measured_panels import bending, fold_angles, length_error
from origami_lab.verification.plane_graph import Array

RIGID = 1e-5
"""Of its diameter: by how much a rigid panel may differ from its flat self (our files 1e-15, six digits 1e-6)."""
SAME_ANGLE = math.radians(0.02)
"""A stated fold angle may differ from the measured one by this."""
CLOSES = math.radians(0.1)
"""A loop around a vertex closes if it does so by this, with fold angles as they are written in a file."""


@dataclass(frozen=True, eq=False)
class Claim:
    """A state of the file, by its fold angles."""

    name: str
    driving: float | None
    """What the file says, radians."""
    rho: Array
    """(E,) measured, or stated where the file has angles only."""


def claims(sheet: Sheet, document: Document) -> list[Claim]:
    """All folded states; near ±180° the sign of a measured angle is the one that the file states."""
    found = []
    for frame in document.frames:
        if frame.coords is not None:
            rho = fold_angles(sheet, frame.coords)
            signs = np.zeros(len(rho)) if frame.angles is None else np.sign(np.nan_to_num(frame.angles))
            signs = np.where(signs != 0.0, signs, [{"V": 1.0, "M": -1.0}.get(x, 0.0) for x in frame.letters])
            turned = (np.abs(rho) > math.pi - SAME_ANGLE) & (signs * rho < 0.0)
            found.append(Claim(_name(frame.name, frame.driving), frame.driving, np.where(turned, -rho, rho)))
    if not found and document.angles is not None:
        stated = document.angles[sheet.inner]
        if np.isfinite(stated).all() and np.abs(stated).max(initial=0.0) > 0.0:
            found.append(Claim("the crease pattern's fold angles", None, np.where(sheet.inner, document.angles, 0.0)))
    return found


def _name(name: str, driving: float | None) -> str:
    return name if driving is None else f"{name} ({degrees(driving)})"


def check_panels(sheet: Sheet, document: Document) -> Check:
    """Every folded panel is congruent to its flat self."""
    frames = [frame for frame in document.frames if frame.coords is not None]
    if not frames:
        return Check("panels rigid", FACT, "the file has no folded vertices; panels are rigid by construction here")
    found = [_bent(sheet, frame.coords) for frame in frames]
    at = max(range(len(frames)), key=lambda k: float(found[k].max()))
    worst, panel, frame = float(found[at].max()), int(found[at].argmax()), frames[at]
    lengths = max(length_error(sheet, frame.coords)[0] for frame in frames if frame.coords is not None)
    numbers = {"largest_deviation": worst, "largest_length_error": lengths, "frames": len(frames)}
    if not worst <= RIGID:
        text = (
            f"panel {panel} is bent or stretched by {worst:.2g} of its diameter in {_name(frame.name, frame.driving)}"
        )
        return Check("panels rigid", WRONG, text, numbers | {"panel": panel}, angle=_angle(frame.driving))
    text = f"in {len(frames)} states, to {worst:.1e} of a panel's diameter; edge lengths to {lengths:.1e}"
    return Check("panels rigid", OK, text, numbers)


def _bent(sheet: Sheet, coords: Array | None) -> Array:
    return np.empty(0) if coords is None else bending(sheet, coords)


def check_fold_angles(sheet: Sheet, document: Document, found: list[Claim]) -> Check:
    """Stated fold angles are the measured ones, assignments have their signs, driven creases the driving angle."""
    compared, worst = 0, 0.0
    for frame, claim in zip([f for f in document.frames if f.coords is not None], found, strict=False):
        if frame.angles is not None:
            known = sheet.inner & np.isfinite(frame.angles)
            compared += int(known.sum())
            error = np.where(known, np.abs(wrapped(frame.angles - claim.rho)), 0.0)
            worst = max(worst, float(error.max(initial=0.0)))
            if worst > SAME_ANGLE:
                e = int(error.argmax())
                text = f"edge {e} folds by {degrees(claim.rho[e])}, not {degrees(frame.angles[e])}, in {claim.name}"
                return _wrong(sheet, e, text, frame.driving)
        for e, letter in enumerate(frame.letters):
            sign = {"V": 1.0, "M": -1.0}.get(letter)
            rho = claim.rho[e]
            if (sign is not None and sign * rho < -SAME_ANGLE) or (letter == "F" and abs(rho) > SAME_ANGLE):
                return _wrong(
                    sheet, e, f"edge {e} is {letter} but folds by {degrees(rho)} in {claim.name}", frame.driving
                )
        if document.driven is not None and frame.driving is not None:
            off = np.abs(np.abs(claim.rho) - abs(frame.driving)) * (document.driven & sheet.inner)
            if off.max(initial=0.0) > SAME_ANGLE:
                e = int(off.argmax())
                text = f"edge {e} is driven but folds by {degrees(claim.rho[e])} in {claim.name}"
                return _wrong(sheet, e, text, frame.driving)
    if (key := _key_is_none(sheet, document, found)) is not None:
        return key
    if not compared:
        return Check("fold angles", FACT, "the file states none beside its folded vertices")
    return Check(
        "fold angles",
        OK,
        f"{compared} agree with the geometry to {math.degrees(worst):.1e}°",
        {"largest_error": math.degrees(worst)},
    )


def _key_is_none(sheet: Sheet, document: Document, found: list[Claim]) -> Check | None:
    """The crease pattern's own fold angles are those of a state of the file, where it says what is driven."""
    if document.angles is None or document.driven is None or not document.frames:
        return None
    stated = np.where(sheet.inner & np.isfinite(document.angles), document.angles, 0.0)
    if not stated.any():
        return None
    errors = [np.abs(wrapped(stated - claim.rho)) * (sheet.inner & np.isfinite(document.angles)) for claim in found]
    nearest = min(range(len(errors)), key=lambda k: float(errors[k].max()))
    e = int(errors[nearest].argmax())
    if errors[nearest][e] <= SAME_ANGLE:
        return None
    text = f"edge {e} is said to fold by {degrees(stated[e])} but the nearest state, {found[nearest].name}, "
    return _wrong(sheet, e, text + f"folds it by {degrees(found[nearest].rho[e])}", found[nearest].driving)


def _wrong(sheet: Sheet, e: int, text: str, driving: float | None) -> Check:
    left, right = (int(f) for f in sheet.beside[e])
    return Check(
        "fold angles", WRONG, text, {"edge": e}, (left, right) if min(left, right) >= 0 else None, _angle(driving)
    )


def _angle(driving: float | None) -> float | None:
    return None if driving is None else math.degrees(driving)


def wrapped(angle: Array) -> Array:
    """Differences of angles, in [−π, π]."""
    return np.asarray(np.remainder(angle + math.pi, 2.0 * math.pi) - math.pi)


def check_loops(linkage: Linkage, found: list[Claim]) -> Check:
    """The rotations around each interior vertex multiply to the identity at every state of the file."""
    fans = linkage.sheet.fans
    if not found or not fans:
        text = "there is no interior vertex" if not fans else "the file has no folded state"
        return Check("loops close", FACT, text, {"vertices": len(fans)})
    residuals = [linkage.closure(claim.rho)[2] for claim in found]
    worst = max(range(len(found)), key=lambda k: float(residuals[k].max()))
    largest = float(residuals[worst].max())
    numbers = {"vertices": len(fans), "largest_residual": math.degrees(largest)}
    if not largest <= CLOSES:
        vertex = fans[int(residuals[worst].argmax())].vertex
        text = f"around vertex {vertex} the fold angles miss closing by {degrees(largest)} in {found[worst].name}"
        return Check("loops close", WRONG, text, numbers | {"vertex": vertex}, angle=_angle(found[worst].driving))
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
