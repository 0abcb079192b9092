"""What an experiment orders a worker process to do."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from origami_lab.config.settings import Settings
    from origami_lab.runs.run_folder import RunFolder


@dataclass(frozen=True)
class Begin:
    """The first order: which experiment the trials are of."""

    settings: Settings
    kernels: bool
    """Whether to load all kernels at once: on a fresh installation one worker compiles them."""
    importable: list[str] = field(default_factory=lambda: list(sys.path))
    """Where the parent finds modules by now."""


@dataclass(frozen=True)
class Task:
    """The order to run one trial."""

    settings: Settings
    folder: RunFolder
    seed: int
