"""Public names, and the modules that they live in; each is imported when it is first used."""

from .report_builder import Report, build_report
from .run_reader import Run, Trial, read_runs

__all__ = [
    "Report",
    "Run",
    "Trial",
    "build_report",
    "read_runs",
]
