"""What tracking leaves in a run folder, ``tracking.json``, and who may push the folder."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
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
