"""Public names, and the modules that they live in; each is imported when it is first used."""

from .mlflow_server import serve_dashboard
from .sync import sync_folders
from .tracker import MlflowTracker, NullTracker, Tracker, make_tracker

__all__ = [
    "MlflowTracker",
    "NullTracker",
    "Tracker",
    "make_tracker",
    "serve_dashboard",
    "sync_folders",
]
