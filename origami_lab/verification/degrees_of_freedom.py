"""How many ways a folded state can move: the rank of its closure Jacobian."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.certificate import OK, OPEN, WRONG, Check, degrees
from origami_lab.verification.claimed_states import Claim, wrapped
from origami_lab.verification.continuation import Motion
from origami_lab.verification.file_rounding import SAME_ANGLE, Rounding
from origami_lab.verification.fold_document import Document
from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.plane_graph import Array, Indices
from origami_lab.verification.second_order import Freedom, explore
from origami_lab.verification.singular_values import Rank, rank

_CURVED, _EPSILON = 48.0, 2e-16
"""Bounds second derivatives of the loops around vertices of usual degrees; the residual that rounding leaves."""
_SAME_DRIVING, _SAME = 1e-9, 1e-6
"""Radians: states at one driving angle, and how far their fold angles may differ if they are one."""
_NAME = "degrees of freedom"
_A_FEW = 8
"""Directions in which it is tried whether flat edges could fold, which decides nothing."""
_MOST_STATES = 6
"""States at which the rank is worked out, evenly out of all."""


def check_freedom(
    linkage: Linkage, document: Document, held: NDArray[np.bool_], folded: Sequence[Claim], rounding: Rounding
) -> tuple[Check, Motion | None, list[list[State]]]:
    """How many degrees of freedom there are, and that none is left once the driven creases are tied to one angle.

    Returns the check and, where it is ok, the motion with the states of the file by increasing driving angle; states
    at one driving angle that are not the same stand beside each other.
    """
    sheet = linkage.sheet
    hinges = np.flatnonzero(sheet.inner & ~held)
    some = [folded[i] for i in _some(len(folded))]
    least_value = rounding.angle_margin(sheet.size)
    whole = [rank(linkage.closure(claim.rho), hinges, least_value) for claim in some]
    least = min(found.freedoms for found in whole)
    numbers: dict[str, Any] = {"creases": len(hinges), "freedoms": least, "flat_edges_held": int(held.sum())}
    driven = np.zeros(len(held), dtype=np.bool_) if document.driven is None else document.driven & sheet.inner
    if driven.any():
        tip = max(folded, key=lambda claim: float(np.abs(claim.rho[driven]).max()))
        drive = np.where(driven, np.sign(tip.rho), 0.0)
        numbers["driven"] = int(driven.sum())
    elif least != 1:
        text = f"{least} and the file does not say which creases are driven: which way it moves is open"
        if not least:
            text = "0: the loops hold the sheet as it is"
            if least_value:
                text = f"too imprecise to tell whether the loops hold the sheet: {rounding.words(sheet.size)}"
        return Check(_NAME, OPEN, text, numbers), None, []
    else:
        drive = _driver(whole[-1].directions[0], hinges, folded, len(held))
    motion = Motion(linkage, held, drive)
    states: list[State] = []
    for claim in folded:
        driving = _driving(claim, drive, driven)
        state = motion.solve(driving, claim.rho)
        if state is None or np.abs(wrapped(state.rho - claim.rho)).max() > max(10.0 * SAME_ANGLE, least_value):
            text = f"the loops do not close near {claim.name} with the driven creases at {degrees(driving)}"
            if least_value:
                text = f"too imprecise to tell whether {claim.name} can be moved to: {rounding.words(sheet.size)}"
            return Check(_NAME, OPEN, text, numbers), None, []
        states.append(state)
    picked = [states[i] for i in _some(len(states))]
    tied = [rank(linkage.closure(state.rho), motion.free, max(least_value, _resolved(state))) for state in picked]
    left = min(found.freedoms for found in tied)
    numbers |= {"freedoms_when_driven": left, "smallest_singular_value": min(found.smallest for found in tied)}
    blocked = ""
    if left:
        check = _left(motion, picked, tied)
        if check.status != OK:
            return replace(check, numbers=numbers | dict(check.numbers)), None, []
        blocked = f"; {check.text}"
    tied_to_one = len(hinges) - len(motion.free)
    text = f"1: {len(hinges)} creases, {least} freedom(s), {tied_to_one} crease(s) tied to one driving angle, none left"
    text += blocked
    if held.any():
        loose, last = Motion(linkage, np.zeros_like(held), drive), states[-1]
        found = rank(linkage.closure(last.rho), loose.free, least_value)
        could = bool(found.freedoms) and explore(loose, last, found, tries=_A_FEW)[0] in (Freedom.MOVES, Freedom.MIXES)
        numbers["flat_edges_could_fold"] = could
        text += f"; {int(held.sum())} flat edges held{', which could fold' if could else ''}"
    singular = [degrees(state.driving) for state, found in zip(picked, tied, strict=True) if found.freedoms > left]
    if singular:
        text += f"; singular at {', '.join(singular)}"
    return Check(_NAME, OK, text, numbers), motion, _beside(states)


def _some(count: int) -> list[int]:
    """Some of so many states, evenly, the first and the last among them."""
    return [int(i) for i in np.unique(np.linspace(0, count - 1, _MOST_STATES).round().astype(int))]


def _resolved(state: State) -> float:
    """The singular value below which a state's loops do not close well enough to tell whether it is 0.

    Newton's method is sure of a single solution nearby where residual · curvature / σ² is below 1/2 (Kantorovich).
    """
    return math.sqrt(_CURVED * max(state.residual, _EPSILON))


def _left(motion: Motion, states: Sequence[State], tied: Sequence[Rank]) -> Check:
    """What is to be said of freedoms that are left in every state once the driven creases are held."""
    left = min(found.freedoms for found in tied)
    blocked, at, wanted, direction = False, len(states) - 1, Freedom.BLOCKED, None
    for at in reversed(range(len(states))):
        wanted, direction = explore(motion, states[at], tied[at])
        if wanted is not Freedom.BLOCKED:
            break
        blocked = True
    if wanted is Freedom.BLOCKED:
        return Check(_NAME, OK, f"{left} to first order, which second-order terms block")
    e = int(motion.free[np.abs(direction).argmax()]) if direction is not None else int(motion.free[0])
    beside = motion.linkage.sheet.beside[e]
    panels = (int(beside.min()), int(beside.max()))
    text = f"{left} left when the driven creases are held: "
    if wanted is Freedom.MOVES:
        text += f"the crease between panels {panels[0]} and {panels[1]} moves"
    elif wanted is Freedom.MIXES:
        text += f"in a mixture of them the crease between panels {panels[0]} and {panels[1]} moves"
    else:
        text += f"nothing is shown to block the crease between panels {panels[0]} and {panels[1]}"
    status = WRONG if wanted is Freedom.MOVES and not blocked else OPEN
    return Check(_NAME, status, text, {"edge": e}, panels, math.degrees(states[at].driving))


def _beside(states: Sequence[State]) -> list[list[State]]:
    """The states by increasing driving angle; those at one angle that differ stand beside each other."""
    groups: list[list[State]] = []
    for state in sorted(states, key=lambda state: state.driving):
        if not groups or state.driving - groups[-1][0].driving > _SAME_DRIVING:
            groups.append([state])
        elif not any(np.abs(wrapped(state.rho - other.rho)).max(initial=0.0) <= _SAME for other in groups[-1]):
            groups[-1].append(state)
    return groups


def _driving(claim: Claim, drive: Array, driven: NDArray[np.bool_]) -> float:
    """The driving angle of a state, radians: what the file says, or how far the driven creases fold."""
    if claim.driving is not None and driven.any():
        return abs(claim.driving)
    return float(np.abs(claim.rho[drive != 0.0]).mean())


def _driver(direction: Array, hinges: Indices, folded: Sequence[Claim], count: int) -> Array:
    """A crease to drive by, where there is one freedom and the file names none: the one that moves most.

    It must fold further from state to state, or it could not lead through all of them.
    """
    order = hinges[np.argsort(-np.abs(direction))]
    size = np.array([np.abs(claim.rho) for claim in folded])
    size = size[np.argsort(size.mean(axis=1))]
    steady = [e for e in order if size[0, e] > SAME_ANGLE and (np.diff(size[:, e]) > 0.0).all()]
    drive = np.zeros(count)
    e = int(steady[0] if steady else order[0])
    drive[e] = float(np.sign(folded[-1].rho[e])) or 1.0
    return drive
