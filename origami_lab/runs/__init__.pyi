"""Public names, and the modules that they live in; each is imported when it is first used."""

from .result import Result, TrialDesign, load, replay_design
from .run_finder import find_runs
from .run_folder import RunFolder
from .trial_row import Spread, best_row, read_trials, spreads

__all__ = [
    "Result",
    "RunFolder",
    "Spread",
    "TrialDesign",
    "best_row",
    "find_runs",
    "load",
    "read_trials",
    "replay_design",
    "spreads",
]
