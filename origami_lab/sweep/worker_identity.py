"""Who a worker is, and whether it still lives: a matter of the process table on its own machine only."""

from __future__ import annotations

import os
import platform
import uuid
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Worker:
    """A process that plays trials."""

    host: str
    """The machine, or the container: where its process number means something."""
    pid: int
    began: str
    """When the process began, in the system's words: numbers are used again."""
    key: str

    @classmethod
    def this(cls) -> Worker:
        """The process that asks."""
        return cls(_host(), os.getpid(), _status(os.getpid())[1], uuid.uuid4().hex[:8])


def is_gone(worker: Worker, here: Worker) -> bool:
    """Whether a worker is known to be dead; False where that cannot be known."""
    if worker.host != here.host:
        return False
    try:
        os.kill(worker.pid, 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    state, began = _status(worker.pid)
    return state == "Z" or (began != worker.began and "" not in (began, worker.began))


def _status(pid: int) -> tuple[str, str]:
    """State and start time of a process; empty where the system does not tell."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return fields[0], fields[19]
    except (OSError, IndexError):
        return "", ""


def _host() -> str:
    """The name of the machine, and of the space of its process numbers: containers may share the first."""
    try:
        space = Path("/proc/self/ns/pid").readlink()
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        return platform.node()
    return f"{platform.node()} {boot[:8]} {space}"
