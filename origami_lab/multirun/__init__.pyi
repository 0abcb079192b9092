"""Public names, and the modules that they live in; each is imported when it is first used."""

from .check_jobs import CheckJobs
from .run_jobs import Multirun

__all__ = [
    "CheckJobs",
    "Multirun",
]
