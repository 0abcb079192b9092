"""Public names, and the modules that they live in; each is imported when it is first used."""

from .analysis import PartAnalysis, analyse_part
from .flat_region import FlatRegion
from .setup import PartSetup

__all__ = [
    "FlatRegion",
    "PartAnalysis",
    "PartSetup",
    "analyse_part",
]
