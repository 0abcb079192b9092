"""How many ways a folded state can move: the rank of its closure Jacobian."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.verification.certificate import OK, OPEN, WRONG, Check, degrees
from origami_lab.verification.claimed_states import SAME_ANGLE, Claim
from origami_lab.verification.continuation import CLOSED, Motion
from origami_lab.verification.fold_document import Document
from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.plane_graph import Array, Indices

_ZERO = 1e-8
"""Of the largest singular value: smaller ones count as zero (rounding leaves 1e-15)."""
_PUSHES = (0.02, 0.005)
"""Radians by which a freedom is tried out: another state nearby would be found at the same place by both."""

_NAME = "degrees of freedom"
_MOST_STATES = 6
"""States at which the rank is worked out, evenly out of all."""


@dataclass(frozen=True)
class Rank:
    """The closure Jacobian of some creases at one state."""

    columns: int
    rank: int
    smallest: float
    """The smallest singular value that counts as not zero; infinite if there is none."""
    directions: Array
    """(columns − rank, columns) unit vectors of fold angles that keep all loops closed to first order."""

    @property
    def freedoms(self) -> int:
        """How many ways to move, to first order."""
        return self.columns - self.rank


def rank(linkage: Linkage, rho: Array, creases: Indices) -> Rank:
    """The rank of the closure Jacobian in the creases with the given numbers, at fold angles (E,)."""
    jacobian = linkage.closure(rho)[1][:, creases]
    count = len(creases)
    if not count:
        return Rank(0, 0, float("inf"), np.empty((0, 0)))
    if not len(jacobian):
        return Rank(count, 0, float("inf"), np.eye(count))
    _, values, right = np.linalg.svd(jacobian, full_matrices=len(jacobian) < count)
    kept = int(np.sum(values > _ZERO * values[0]))
    return Rank(count, kept, float(values[kept - 1]), right[kept:])


def is_free(motion: Motion, driving: float, rho: Array, found: Rank) -> bool:
    """Whether a freedom to first order is a real one: pushed along it, the loops close again somewhere else."""
    free = motion.free
    for direction in found.directions:
        moved = []
        for push in _PUSHES:
            guess = rho.copy()
            guess[free] += push * direction
            state = motion.solve(driving, guess)
            if state is not None and state.residual <= CLOSED:
                moved.append(float(np.linalg.norm(state.rho - rho)) / push)
        if len(moved) == len(_PUSHES) and all(0.5 < share < 2.0 for share in moved):
            return True
    return False


def check_freedom(
    linkage: Linkage, document: Document, held: NDArray[np.bool_], folded: Sequence[Claim], rounding: float
) -> tuple[Check, Motion | None, list[State]]:
    """How many degrees of freedom there are, and that none is left once the driven creases are tied to one angle.

    Returns the check and, where it is ok, the motion with the states of the file by increasing driving angle.
    ``rounding`` are radians by which the file's states may be off.
    """
    sheet = linkage.sheet
    hinges = np.flatnonzero(sheet.inner & ~held)
    some = [folded[i] for i in np.unique(np.linspace(0, len(folded) - 1, _MOST_STATES).round().astype(int))]
    whole = [rank(linkage, claim.rho, hinges) for claim in some]
    least = min(found.freedoms for found in whole)
    numbers: dict[str, Any] = {"creases": len(hinges), "freedoms": least, "flat_edges_held": int(held.sum())}
    driven = np.zeros(len(held), dtype=np.bool_) if document.driven is None else document.driven & sheet.inner
    if driven.any():
        tip = max(folded, key=lambda claim: float(np.abs(claim.rho[driven]).max()))
        drive = np.where(driven, np.sign(tip.rho), 0.0)
        numbers["driven"] = int(driven.sum())
    elif least != 1:
        text = f"{least} and the file does not say which creases are driven: which way it moves is open"
        return Check(_NAME, OPEN, text if least else "0: the loops hold the sheet as it is", numbers), None, []
    else:
        drive = _driver(whole[-1].directions[0], hinges, folded, len(held))
    motion = Motion(linkage, held, drive)
    tied = [rank(linkage, claim.rho, motion.free) for claim in some]
    left = min(found.freedoms for found in tied)
    numbers |= {"freedoms_when_driven": left, "smallest_singular_value": min(found.smallest for found in tied)}
    angles = [_driving(claim, drive, driven) for claim in some]
    if left and any(is_free(motion, a, c.rho, r) for a, c, r in zip(angles, some, tied, strict=True)):
        e = int(motion.free[np.abs(tied[-1].directions[0]).argmax()])
        panels = (int(sheet.beside[e].min()), int(sheet.beside[e].max()))
        text = (
            f"{left} left when the driven creases are held: the crease between panels {panels[0]} and {panels[1]} moves"
        )
        return Check(_NAME, WRONG, text, numbers | {"edge": e}, panels, math.degrees(angles[-1])), None, []
    states: list[State] = []
    for claim in sorted(folded, key=lambda claim: _driving(claim, drive, driven)):
        driving = _driving(claim, drive, driven)
        state = motion.solve(driving, claim.rho)
        if state is None or np.abs(state.rho - claim.rho).max() > 10.0 * max(SAME_ANGLE, rounding):
            text = f"the loops do not close near {claim.name} with the driven creases at {degrees(driving)}"
            return Check(_NAME, OPEN, text, numbers), None, []
        if not states or state.driving - states[-1].driving > 1e-9:
            states.append(state)
    tied_to_one = len(hinges) - len(motion.free)
    text = f"1: {len(hinges)} creases, {least} freedom(s), {tied_to_one} crease(s) tied to one driving angle, none left"
    if held.any():
        loose = Motion(linkage, np.zeros_like(held), drive)
        numbers["flat_edges_could_fold"] = is_free(
            loose, angles[-1], some[-1].rho, rank(linkage, some[-1].rho, loose.free)
        )
        could = ", which could fold" if numbers["flat_edges_could_fold"] else ""
        text += f"; {int(held.sum())} flat edges held{could}"
    singular = [degrees(angle) for angle, found in zip(angles, tied, strict=True) if found.freedoms]
    if singular:
        text += f"; singular at {', '.join(singular)}"
    return Check(_NAME, OK, text, numbers), motion, states


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
