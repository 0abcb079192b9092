"""The state of a trial's search, as a file beside its design: from it a longer run goes on.

It holds what was found so far, improvement by improvement, and what the searcher saves of itself.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.file_names import ACTIONS
from origami_lab.files import read_json, regular_bytes
from origami_lab.runs.trial_row import NO_DESIGN, TrialRow

if TYPE_CHECKING:
    from origami_lab.search.problem import Outcome

LARGEST = 2**30
"""Bytes of a state that is read."""
_OWN = "searcher."
_COUNTS = ("interactions", "interactions_to_best", "episodes", "rejected", "places_evaluated")


@dataclass(frozen=True)
class SearchState:
    """A search between two stages."""

    stages: int
    """How many it has gone through."""
    outcome: Outcome
    seconds: float
    record: tuple[Mapping[str, Any], ...] = ()
    """What each stage was given and has come to."""
    searcher: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """What the searcher has saved; empty if it begins anew."""

    def to_bytes(self) -> bytes:
        """The contents of the file; the same for the same state."""
        improvements = self.outcome.improvements
        numbers = {name: int(getattr(self.outcome, name)) for name in _COUNTS}
        about = {"stages": self.stages, "seconds": self.seconds, "record": list(self.record), **numbers}
        arrays: dict[str, NDArray[Any]] = {
            "about": np.array(json.dumps(about)),
            "found_at": np.array([step.interaction for step in improvements], dtype=np.int64),
            "values": np.array([step.value for step in improvements], dtype=np.float64),
            "angles": np.array([step.angle for step in improvements], dtype=np.int64),
            "lengths": np.array([len(step.actions) for step in improvements], dtype=np.int64),
            "actions": np.array([action for step in improvements for action in step.actions], dtype=np.int32),
            "start": np.array(() if improvements else self.outcome.actions, dtype=np.int32),
        }
        arrays |= {_OWN + name: value for name, value in self.searcher.items()}
        stream = io.BytesIO()
        np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
        return stream.getvalue()


def state_of_bytes(content: bytes) -> SearchState:
    """The state in a file's contents; raises ValueError, KeyError or OSError if it is none."""
    from origami_lab.search.problem import Improvement, Outcome

    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    about = json.loads(str(arrays["about"]))
    ends = np.cumsum(arrays["lengths"])
    parts = np.split(arrays["actions"], ends[:-1]) if len(ends) else []
    rows = zip(arrays["found_at"], arrays["values"], arrays["angles"], parts, strict=True)
    improvements = tuple(
        Improvement(int(at), float(value), int(angle), tuple(actions.tolist())) for at, value, angle, actions in rows
    )
    return SearchState(
        stages=int(about["stages"]),
        outcome=outcome_of(Outcome, improvements, tuple(arrays["start"].tolist()), about),
        seconds=float(about["seconds"]),
        record=tuple(about["record"]),
        searcher={name.removeprefix(_OWN): value for name, value in arrays.items() if name.startswith(_OWN)},
    )


def outcome_of(kind: Any, improvements: tuple[Any, ...], start: tuple[int, ...], about: Mapping[str, Any]) -> Outcome:
    """What a search has found, from its improvements and its counts."""
    best = improvements[-1] if improvements else None
    found: Outcome = kind(
        value=best.value if best else -math.inf,
        angle=best.angle if best else -1,
        actions=best.actions if best else start,
        improvements=improvements,
        succeeded=best is not None,
        **{name: int(about[name]) for name in _COUNTS},
    )
    return found


def read_state(file: Path) -> SearchState | None:
    """The state in a file; None if there is none that can be read."""
    try:
        return state_of_bytes(regular_bytes(file, LARGEST))
    except Exception:  # whatever a damaged archive makes zipfile and numpy raise
        return None


def state_of_row(trial: Path, row: TrialRow) -> SearchState:
    """The state of a trial that has saved none: what its row and its best design say, and no searcher.

    Raises
    ------
    ValueError, KeyError, OSError
        If its design cannot be read.
    """
    from origami_lab.search.problem import Improvement, Outcome

    saved = read_json(trial / ACTIONS)
    actions = tuple(int(action) for action in saved["actions"])
    about = {name: row[name] or 0 for name in _COUNTS}
    improvements: Sequence[Improvement] = ()
    if row.outcome != NO_DESIGN and row.return_ is not None:
        at = int(row.interactions_to_best or 0)
        improvements = (Improvement(at, float(row.return_), int(saved["angle"]), actions),)
    outcome = outcome_of(Outcome, tuple(improvements), actions, about)
    return SearchState(row.stages or 1, outcome, float(row.seconds or 0.0))
