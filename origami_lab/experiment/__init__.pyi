"""Public names, and the modules that they live in; each is imported when it is first used."""

from .api import run
from .runner import Experiment, run_experiment
from .trial import run_trial
from .trial_progress import Progress

__all__ = [
    "Experiment",
    "Progress",
    "run",
    "run_experiment",
    "run_trial",
]
