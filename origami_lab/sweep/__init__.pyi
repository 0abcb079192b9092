"""Public names, and the modules that they live in; each is imported when it is first used."""

from .sweep_config import Declaration, read_declaration
from .sweep_runner import SweepResult, run_sweep

__all__ = [
    "Declaration",
    "SweepResult",
    "read_declaration",
    "run_sweep",
]
