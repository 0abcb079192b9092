"""A run folder as tracking sees it: what was recorded, what is noted in ``tracking.json``, and who may push it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from origami_lab.experiment.folder import RunFolder, write_atomically
from origami_lab.reporting.tables import FAILED, Row, read_trials, spent_budget

NOTE = "tracking.json"


def read_note(folder: Path) -> dict[str, Any]:
    """What tracking.json says of a run folder: its ``key``, and the ``uri`` of its store; {} if there is none."""
    try:
        content = json.loads((folder / NOTE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def write_note(folder: Path, content: Mapping[str, Any]) -> None:
    write_atomically(folder / NOTE, json.dumps(content, indent=1) + "\n")


@contextmanager
def held(folder: Path, wait: bool) -> Iterator[bool]:
    """Keep other processes from pushing a run folder; whether it could be had (always, where locks are unknown)."""
    try:
        import fcntl
    except ImportError:  # Windows
        yield True
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        except OSError:  # a file system without locks
            yield True
        else:
            yield True
    finally:
        os.close(descriptor)


def rows_of(folder: Path) -> dict[int, Row]:
    """The trials on disk by seed. Those that failed are in the table only, beside what was saved when stopped."""
    results = RunFolder(folder).rows()
    table = folder / "trials.csv"
    rows: dict[int, Row] = dict(results)
    for row in read_trials(table) if table.is_file() else []:
        if str(row["status"]).startswith(FAILED) and not spent_budget(results.get(row["seed"], {})):
            rows[row["seed"]] = row
    return rows


def summary_of(folder: Path) -> dict[str, Any]:
    """The contents of summary.json; {} if there is none."""
    try:
        content = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}
