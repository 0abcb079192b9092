"""Which of a trial's improvements is kept: the last one that its certificate does not refute."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.file_names import BEST, CERTIFICATE
from origami_lab.runs.trial_row import NOT_CHECKED, REFUTED

if TYPE_CHECKING:
    from origami_lab.game.crease_pattern import CreasePattern
    from origami_lab.search.problem import Outcome

MOST_STEPS_BACK = 20
"""How many improvements before a refuted best are verified, the last one first."""


@dataclass(frozen=True)
class Kept:
    """The design that a trial keeps; its ``best.fold`` is written, and ``certificate.json`` if it has one."""

    outcome: Outcome
    """What the search found, as if the kept design had been its last improvement."""
    design: CreasePattern
    verdict: str | None
    """What ``trials.csv`` says of it; None where the search found no design."""
    passed_over: tuple[Mapping[str, Any], ...] = ()
    """The better designs that are refuted, the best one first, as ``result.json`` names them."""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Verified:
    """A design, and what the verification said of its file; no text if it failed itself."""

    outcome: Outcome
    design: CreasePattern
    verdict: str
    reason: str
    text: str

    def to_json(self) -> Mapping[str, Any]:
        return {
            "return": float(self.outcome.value),
            "driving_angle": self.design.metadata["driving_angle"],
            "interactions": int(self.outcome.interactions_to_best),
            "certificate": self.verdict,
            "reason": self.reason,
        }


def keep_design(
    path: Path,
    outcome: Outcome,
    make: Callable[[Outcome], CreasePattern],
    verifies: bool,
    thickness: float = 0.0,
) -> Kept:
    """Write a trial's best design and verify the file; a refuted one gives way to the last improvement that is not.

    Where all that are looked at are refuted the best one stays, and its verdict says so. A verification that fails
    itself is a warning, and its design counts as not checked.

    Parameters
    ----------
    path
        The folder of the trial.
    make
        The design of an outcome, with all that its file says of it.
    verifies
        Whether designs are verified at all.
    thickness
        In board cells: panels that share no vertex must keep this distance.
    """
    from origami_lab.fold_format.writer import write_fold

    if not (verifies and outcome.succeeded):
        design = make(outcome)
        write_fold(path / BEST, design)
        return Kept(outcome, design, NOT_CHECKED if outcome.succeeded else None)
    refuted: list[_Verified] = []
    for back in range(min(len(outcome.improvements), MOST_STEPS_BACK + 1)):
        earlier = _without_last(outcome, back)
        design = make(earlier)
        write_fold(path / BEST, design)
        found = _Verified(earlier, design, *_verify(path / BEST, thickness))
        if found.verdict != REFUTED:
            break
        refuted.append(found)
    else:
        found = refuted[0]
        write_fold(path / BEST, found.design)
    if found.text:
        (path / CERTIFICATE).write_text(found.text, encoding="utf-8")
    passed_over = () if found.verdict == REFUTED else tuple(one.to_json() for one in refuted)
    return Kept(found.outcome, found.design, found.verdict, passed_over, tuple(_warnings(found, refuted)))


def is_refuted(design: CreasePattern, thickness: float = 0.0) -> bool:
    """Whether the certificate of a design, with panels so thick in board cells, refutes it."""
    from origami_lab.fold_format.writer import write_fold

    with tempfile.TemporaryDirectory(prefix="origami-lab-") as place:
        file = Path(place) / BEST
        write_fold(file, design)
        return _verify(file, thickness)[0] == REFUTED


def _without_last(outcome: Outcome, count: int) -> Outcome:
    """What the search would have found without its last improvements."""
    improvements = outcome.improvements[: len(outcome.improvements) - count]
    last = improvements[-1]
    return replace(
        outcome,
        value=last.value,
        angle=last.angle,
        actions=last.actions,
        interactions_to_best=last.interaction,
        improvements=improvements,
    )


def _verify(file: Path, thickness: float) -> tuple[str, str, str]:
    """The verdict on a file, its reason, and the text of the certificate.

    No time limit: how many states of the motion are solved for is bounded, so that the verdict does not depend on the
    machine.
    """
    try:
        from origami_lab.verification.verify_design import verify

        certificate = replace(verify(file, thickness), name=BEST)
        return certificate.verdict, certificate.reason, certificate.json_text()
    except Exception as error:
        return NOT_CHECKED, f"{type(error).__name__}: {error}", ""


def _warnings(kept: _Verified, refuted: Sequence[_Verified]) -> list[str]:
    """Lines on what was refuted, and on a verification that failed."""
    lines = [] if kept.text else [f"no {CERTIFICATE}: {kept.reason}"]
    if not refuted:
        return lines
    best, others = refuted[0], len(refuted) - 1
    if kept.verdict == REFUTED:
        also = f"; so is what it found before ({others} looked at)" if others else ""
        return [*lines, f"its best design is refuted: {best.reason}{also}"]
    what = "the best design" if not others else f"the best {others + 1} designs"
    values = f"{best.outcome.value:.6g}, kept is {kept.outcome.value:.6g}"
    return [*lines, f"{what} passed over, as refuted ({values}): {best.reason}"]
