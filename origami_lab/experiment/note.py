"""What tracking reads of a run folder beside its trials: ``tracking.json`` and ``summary.json``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from origami_lab.experiment.folder import write_atomically

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


def summary_of(folder: Path) -> dict[str, Any]:
    """The contents of summary.json; {} if there is none."""
    try:
        content = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}
