"""Verifying a design: all checks, in order, until one of them makes the rest pointless."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.verification.certificate import FACT, OK, OPEN, WRONG, Certificate, Check, degrees
from origami_lab.verification.claimed_states import (
    Claim,
    check_flat_foldability,
    check_fold_angles,
    check_loops,
    check_panels,
    claims,
    half_stated,
    held_flat,
)
from origami_lab.verification.continuation import Motion
from origami_lab.verification.crossing_search import MOST_LOOKS, Sweep
from origami_lab.verification.degrees_of_freedom import check_freedom
from origami_lab.verification.file_rounding import SAME_ANGLE, Rounding, allowance, rounding_of
from origami_lab.verification.findings import Meeting
from origami_lab.verification.flat_sheet import OverlapError, Sheet, SheetError, UndecidableError, build_sheet
from origami_lab.verification.fold_document import Design, Document, document_of
from origami_lab.verification.hints import hinted
from origami_lab.verification.linkage import Linkage, State
from origami_lab.verification.measured_panels import unfolded
from origami_lab.verification.motion_path import Course, branch_text, follow
from origami_lab.verification.panel_pairs import CrowdedError, Neighbourhood
from origami_lab.verification.threads import one_thread
from origami_lab.verification.triangle_separation import TOUCH, overlap_in_plane

MOST_CREASES = 800
"""Unknown fold angles of a motion that is followed."""
_MOST_STATES = 1e10
"""Bounds the states of a file that a motion is followed through: so many times the cube of the number of creases."""
_MOST_COURSES = 4
"""Ways through a file's states, where it has several at one driving angle, that are followed in search of crossings."""
_BEFORE = 1e-4
"""Radians: what is left open so near before a crossing is the crossing coming up."""
_WORK = 1e11
"""Bounds the states of a motion: so many times the cube of the number of unknowns."""


def verify(source: str | Path | Design, thickness: float = 0.0) -> Certificate:
    """Verify a FOLD file, or a design in memory.

    Parameters
    ----------
    thickness
        In the file's units: panels that share no vertex must keep this distance over the whole motion.

    Raises
    ------
    InputError
        On a file that cannot be read; whatever is wrong with the design is in the certificate.
    """
    if not (0.0 <= thickness < math.inf):
        raise InputError("thickness", thickness, "must be 0 or a positive length, in the file's units")
    name = str(source) if isinstance(source, str | Path) else "design"
    document = document_of(source)
    with one_thread():
        return Certificate(name, tuple(_checks(document, thickness)), document.remarks)


def _checks(document: Document, thickness: float) -> Iterator[Check]:
    """The checks, one after the other; the first that fails is the last where the others would mean nothing."""
    try:
        flat = document.flat
        if flat is None and not document.fault:
            flat = unfolded(document, next(f.coords for f in document.frames if f.coords is not None))
        sheet = build_sheet(np.empty((0, 2)) if flat is None else flat, document)
    except (SheetError, UndecidableError) as error:
        wrong, text = isinstance(error, SheetError), str(error)
        if isinstance(error, OverlapError) and not document.declared:  # it may be a folded form, or no origami
            wrong, text = False, f"{text}, and no frame_classes say that it is a crease pattern"
        yield Check("sheet valid", WRONG if wrong else OPEN, text)
        return
    linkage = Linkage(sheet)
    found = claims(sheet, document)
    allowed = allowance(sheet, document)
    rigid = check_panels(sheet, document, allowed)
    yield _sheet(sheet, document)
    yield hinted(rigid, sheet, document)
    unread = [*document.unread, *half_stated(sheet, document)]
    if unread:
        yield Check("frames read", OPEN, "; ".join(unread[:3]), {"unread": unread})
    if rigid.status == WRONG:
        return
    loops = check_loops(linkage, found, allowed)
    rest = [
        hinted(check_fold_angles(sheet, document, found, allowed), sheet, document),
        hinted(loops, sheet, document),
        check_flat_foldability(sheet, document, found),
    ]
    yield from rest
    if not any(check.status == WRONG for check in rest):
        bent = float(rigid.numbers.get("largest_deviation_length", 0.0))
        unclosed = math.radians(float(loops.numbers.get("largest_residual", 0.0)))
        rounding = rounding_of(document, sheet.size, bent, unclosed)
        yield from _Moving(document, linkage, found, thickness, rounding).checks()


def _sheet(sheet: Sheet, document: Document) -> Check:
    inner = int(sheet.inner.sum())
    numbers = {
        "vertices": len(np.unique(np.concatenate(sheet.faces))),
        "creases": inner,
        "panels": len(sheet.faces),
        "interior_vertices": len(sheet.fans),
        "holes": [list(hole) for hole in sheet.holes],
        "size": sheet.size,
    }
    text = f"{numbers['vertices']} vertices, {inner} creases, {len(sheet.faces)} panels"
    if sheet.holes:
        text += f", {len(sheet.holes)} hole(s), at vertex " + ", ".join(str(hole[0]) for hole in sheet.holes)
    return Check("sheet valid", OK, text, numbers)


@dataclass
class _Moving:
    """The checks that need the motion."""

    document: Document
    linkage: Linkage
    found: list[Claim]
    thickness: float
    rounding: Rounding

    def checks(self) -> Iterator[Check]:
        """Degrees of freedom, motion, crossing, clearance."""
        sheet, linkage = self.linkage.sheet, self.linkage
        held = held_flat(sheet, self.document, self.found)
        try:
            near = Neighbourhood(linkage, held)
            crossing = self.crossing_at_states(near)
        except CrowdedError:
            yield Check("crossing", OPEN, "too many panels lie close to each other to check them pair by pair")
            return
        folded = [claim for claim in self.found if np.abs(claim.rho).max(initial=0.0) > SAME_ANGLE]
        reason = self.why_not(sheet, held, folded)
        if reason:
            yield crossing or Check("motion", OPEN, reason)
            return
        freedom, motion, states = check_freedom(linkage, self.document, held, folded, self.rounding)
        yield freedom
        if freedom.status != OK or motion is None:
            if crossing is not None:
                yield crossing
            return
        try:
            left = int(freedom.numbers["freedoms_when_driven"])
            yield from self.motion_checks(motion, near, states, crossing, left)
        except CrowdedError:
            yield Check("crossing", OPEN, "too many panels come close to each other to check them pair by pair")

    def why_not(self, sheet: Sheet, held: NDArray[np.bool_], folded: list[Claim]) -> str:
        """Why no motion can be followed, in words; empty if one can."""
        if not folded:
            return "the file has no folded state, and at the flat one motions branch"
        if sheet.holes:
            return "the sheet has a hole, and loops around holes are not followed"
        if int((sheet.inner & ~held).sum()) > MOST_CREASES:
            return f"the motion of more than {MOST_CREASES} creases is not followed"
        if len(folded) * int((sheet.inner & ~held).sum()) ** 3 > _MOST_STATES:
            return f"a motion of so many creases through {len(folded)} states is not followed"
        return ""

    @property
    def margin(self) -> float:
        """A length: what the file's rounding may move panels by; 0 for an exact file."""
        return self.rounding.length_margin(self.linkage.sheet.size)

    def crossing_at_states(self, near: Neighbourhood) -> Check | None:
        """Panels that cross in a state of the file itself, the one with the smallest driving angle."""
        first: tuple[float, Check] | None = None
        looks = 0
        for claim in self.found:
            state = self.linkage.place(claim.driving or 0.0, claim.rho, np.zeros(len(claim.rho)), 0.0)
            corners = near.corners(state)
            for pairs in (near.neighbours, near.close(corners.min(axis=1), corners.max(axis=1))):
                looks += len(pairs)
                if looks > 2 * MOST_LOOKS:
                    raise CrowdedError
                depth = near.depth(pairs, state)
                # what the file rounds off may look like a crossing
                if len(depth) and depth.max() > max(10.0 * TOUCH * near.sheet.size, self.margin):
                    p, q = sorted(int(f) for f in pairs.panels[int(depth.argmax())])
                    text = f"panels {p} and {q} cross in {claim.name}, and perhaps before"
                    angle = None if claim.driving is None else math.degrees(claim.driving)
                    if first is None or (claim.driving is not None and claim.driving < first[0]):
                        numbers = {"first": False}
                        first = (claim.driving or math.inf, Check("crossing", WRONG, text, numbers, (p, q), angle))
        return None if first is None else first[1]

    # the motion

    def motion_checks(
        self,
        motion: Motion,
        near: Neighbourhood,
        states: list[list[State]],
        crossing: Check | None,
        freedoms: int,
    ) -> Iterator[Check]:
        """Continuation through all states, no crossings on the way, clearance.

        ``freedoms`` are those to first order that are there in every state, and blocked.
        """
        count = len(motion.free)
        most = int(min(max(_WORK / (count**3 + 1e7), 200), 8000))
        size = near.sheet.size
        courses, ways = [], _courses(states)
        for states_once in ways:
            sweep = Sweep(
                motion, near, self.thickness, most // len(ways), self.margin, self.rounding.angle_margin(size)
            )
            courses.append((sweep, follow(sweep, states_once), states_once))
            if sweep.found.crossing is not None:
                break
        crossed = [one for one in courses if one[0].found.crossing is not None]
        sweep, course, chain = (crossed or courses)[0]
        found = sweep.found
        covered = f"from {degrees(course.low)} to {degrees(course.high)}"
        numbers = {
            "from": math.degrees(course.low),
            "to": math.degrees(course.high),
            "largest_residual": math.degrees(found.residual),
            "largest_difference_to_file": math.degrees(course.missed),
            "states": found.states,
            "intervals": found.intervals,
            "branch_points": [math.degrees(angle) for angle in course.branches],
            "smallest_singular_value": course.singular,
            "smallest_singular_value_at": math.degrees(course.singular_at),
            "singular_between": [[math.degrees(low), math.degrees(high)] for low, high in course.flips],
        }
        solver = [gap for gap in found.gaps if "solver" in gap.why or "motion" in gap.why]
        if found.crossing is None and crossing is None:
            double = next((group for group in states if len(group) > 1), None)
            if double is not None:
                text = f"the file has {len(double)} different states at {degrees(double[0].driving)}"
                yield Check("motion", OPEN, text, numbers)
            elif solver:
                gap = solver[0]
                text = f"not followed between {degrees(gap.low)} and {degrees(gap.high)}: {gap.why}"
                yield Check("motion", OPEN, text, numbers)
            elif not course.flat:
                text = f"{degrees(course.low)}, the first state, could not be followed down to the flat sheet"
                yield Check("motion", OPEN, text, numbers)
            elif course.loose and not freedoms:
                low, high = course.loose[0]
                text = f"singular all the way from {degrees(low)} to {degrees(high)}: another freedom is not excluded"
                yield Check("motion", OPEN, text, numbers)
            else:
                below = "; below that it stays as good as flat"
                text = f"{covered}{below}; loops close to {math.degrees(found.residual):.1e}° in {found.states} states"
                yield Check("motion", OK, text + branch_text(course), numbers)
        if found.crossing is not None:
            yield self.crossed(found.crossing, sweep, course)
            return
        if crossing is not None:
            yield crossing
            return
        open_pairs = [gap for gap in found.gaps if gap not in solver]
        if open_pairs:
            gap = open_pairs[0]
            text = f"not certified between {degrees(gap.low)} and {degrees(gap.high)}: {gap.why}"
            yield Check(
                "crossing", OPEN, text, {"intervals": [[math.degrees(g.low), math.degrees(g.high)] for g in open_pairs]}
            )
        elif solver or not course.flat:
            yield Check("crossing", OPEN, "no panels cross where the motion could be followed")
        elif found.unsure is not None:
            p, q = found.unsure.panels
            text = (
                f"too imprecise to tell: panels {p} and {q} {found.unsure.how} near {degrees(found.unsure.angle)}, and "
            )
            text += self.rounding.words(size)
            yield Check("crossing", OPEN, text, {"margin": self.margin}, (p, q), math.degrees(found.unsure.angle))
        else:
            contacts = [[*pair, *map(math.degrees, span)] for pair, span in sorted(found.contacts.items())]
            text = f"no panels cross up to {degrees(course.high)}, in {found.intervals} intervals without a gap"
            if contacts:
                text += f"; {len(contacts)} pair(s) touch, first panels {contacts[0][0]} and {contacts[0][1]}"
            tolerance = TOUCH * float(near.diameters.max())
            yield Check("crossing", OK, text, {"contacts": contacts, "tolerance": tolerance, "margin": self.margin})
        yield self.coplanar(near, chain)
        yield self.clearance(sweep)

    def crossed(self, meeting: Meeting, sweep: Sweep, course: Course) -> Check:
        """Panels that cross on the way, and whether others may do so before."""
        p, q = meeting.panels
        text = f"panels {p} and {q} {meeting.how} at {degrees(meeting.angle)}"
        earlier = [gap for gap in sweep.found.gaps if gap.low < meeting.angle - _BEFORE]
        first = course.flat and not earlier
        if not first:
            text += ", and perhaps before: "
            text += earlier[0].why if earlier else "the motion could not be followed down to the flat sheet"
        return Check("crossing", WRONG, text, {"first": first}, (p, q), math.degrees(meeting.angle))

    def coplanar(self, near: Neighbourhood, states: list[State]) -> Check:
        """Panels that lie on each other in one plane, at the states of the file: contact, not collision."""
        listed = []
        touch = 10.0 * TOUCH * near.sheet.size
        for state in states:
            corners = near.corners(state)
            pairs = near.close(corners.min(axis=1) - touch, corners.max(axis=1) + touch)
            stacked = {(int(left), int(right)) for left, right in near.sheet.beside[np.abs(state.rho) > math.pi - 1e-7]}
            for some in (near.neighbours, pairs):
                if len(some):
                    flat = overlap_in_plane(near.first(some), near.second(some, state)[0], touch)
                    stacked |= {(int(p), int(q)) for p, q in some.panels[flat]}
            listed += [[min(p, q), max(p, q), math.degrees(state.driving)] for p, q in sorted(stacked)]
        text = f"{len(listed)} pair(s) of panels lie on each other" if listed else "none at the states of the file"
        return Check("coplanar contact", FACT, text, {"pairs": listed})

    def clearance(self, sweep: Sweep) -> Check:
        """The least distance of panels that share no vertex, and whether it leaves room for the thickness."""
        found, closest = sweep.found, sweep.found.closest
        name = "clearance"
        if self.thickness > 0.0 and found.thin is not None:
            p, q = found.thin.panels
            text = f"panels {p} and {q} are closer than {self.thickness:g} at {degrees(found.thin.angle)}"
            return Check(name, WRONG, text, {"thickness": self.thickness}, (p, q), math.degrees(found.thin.angle))
        if closest is None:
            return Check(name, OK, f"panels without a common vertex keep more than {sweep.look:.3g} apart")
        p, q = closest.panels
        numbers = {"clearance": found.clearance, "pair": [p, q], "at": math.degrees(closest.angle)}
        text = f"{found.clearance:.3g}, between panels {p} and {q} at {degrees(closest.angle)}"
        if self.thickness > 0.0:
            text += f"; all keep {self.thickness:g} apart"
        return Check(name, OK, text, numbers)


def _courses(groups: list[list[State]]) -> list[list[State]]:
    """Ways through the states that take each of them once at least, the last ones of each group first."""
    count = min(max(len(group) for group in groups), _MOST_COURSES)
    return [[group[max(len(group) - 1 - k, 0)] for group in groups] for k in range(count)]
