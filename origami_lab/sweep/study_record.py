"""The study as files: a table for people, and the same with everything for tracking."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from datetime import UTC
from pathlib import Path
from typing import Any

from optuna.trial import FrozenTrial

from origami_lab.config.checked_values import shown
from origami_lab.files import read_json, write_whole
from origami_lab.sweep.studies import best_slot, point_of, returns_of
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.trial_queue import Slot

TABLE, RECORD = "trials.csv", "study.json"


def record_of(declaration: Declaration, key: str, slots: Sequence[Slot]) -> dict[str, Any]:
    """The record of a study: its declaration, and each trial that has ended."""
    best = best_slot(slots)
    return {
        "study": declaration.study,
        "key": key,
        "declaration": declaration.fixed,
        "trials": len(slots),
        "best": None if best is None else best.number,
        "ended": [ended_trial(declaration, slot) for slot in slots if slot.done],
    }


def ended_trial(declaration: Declaration, slot: Slot) -> dict[str, Any]:
    """The record of a trial that has ended."""
    trial = slot.trial
    assert trial is not None
    returns = returns_of(slot)
    return {
        "trial": slot.number,
        "state": slot.state,
        "value": trial.value if slot.state in ("complete", "pruned") else None,
        "point": point_of(slot),
        "returns": dict(zip(map(str, declaration.seeds), returns, strict=False)),
        "lost_before": slot.losses,
        "reason": slot.reason,
        "began": _moment(trial, "datetime_start"),
        "ended": _moment(trial, "datetime_complete"),
        "folder": trial.user_attrs.get("folder", ""),
        "host": trial.user_attrs.get("host", ""),
    }


def _moment(trial: FrozenTrial, name: str) -> float:
    """Seconds since 1970; Optuna's times are local ones without a zone."""
    moment = getattr(trial, name)
    return 0.0 if moment is None else float(moment.astimezone(UTC).timestamp())


def write_record(folder: Path, record: Mapping[str, Any]) -> None:
    """Write both files."""
    write_whole(folder / RECORD, json.dumps(record, indent=1) + "\n", sync=True)
    write_whole(folder / TABLE, table_text(record), sync=True)


def table_text(record: Mapping[str, Any]) -> str:
    """The text of trials.csv: one row a trial that has ended; empty where a parameter was not searched."""
    text, names = io.StringIO(), list(record["declaration"]["space"])
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["trial", "state", "value", "seeds", "seconds", "lost_before", *names, "reason"])
    for trial in record["ended"]:
        point = trial["point"]
        writer.writerow(
            [
                trial["trial"],
                trial["state"],
                "" if trial["value"] is None else trial["value"],
                len(trial["returns"]),
                round(trial["ended"] - trial["began"], 3),
                trial["lost_before"],
                *(shown(point[name]) if name in point else "" for name in names),
                trial["reason"],
            ]
        )
    return text.getvalue()


def read_record(folder: Path) -> dict[str, Any]:
    """The record of a study's folder.

    Raises
    ------
    OSError
        If it is not there.
    """
    found = read_json(folder / RECORD)
    assert isinstance(found, dict)
    return found
