"""The state of a trial's search, as a file beside its design: from it a longer run goes on.

It holds what was found so far, improvement by improvement, and what the searcher saves of itself. It says nothing of
time, which is in the trial's result: so the same search leaves the same bytes.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.file_names import ACTIONS, RESULT, STATE
from origami_lab.files import read_json, regular_bytes
from origami_lab.runs.trial_row import NO_DESIGN, TrialRow, beside_row

if TYPE_CHECKING:
    from origami_lab.search.problem import Outcome

RECORD = "stages_of_search"
"""The key of what each stage has come to, in a trial's ``result.json``."""
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
    seconds: float = 0.0
    """Time of the search so far; not in the file."""
    record: tuple[Mapping[str, Any], ...] = ()
    """What each stage was given and has come to; not in the file."""
    searcher: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """What the searcher has saved; empty if it begins anew."""

    def to_bytes(self) -> bytes:
        """The contents of the file; the same for the same state."""
        improvements = self.outcome.improvements
        numbers = {name: int(getattr(self.outcome, name)) for name in _COUNTS}
        about = {"stages": self.stages, **numbers}
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


def read_state(trial: Path) -> SearchState | None:
    """The state in a trial's folder, with the times that its result says; None if there is none that can be read."""
    try:
        state = state_of_bytes(regular_bytes(trial / STATE, LARGEST))
        record = beside_row(trial / RESULT).get(RECORD) or [{"seconds": 0.0}]
        return replace(state, seconds=float(record[-1]["seconds"]), record=tuple(record))
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
