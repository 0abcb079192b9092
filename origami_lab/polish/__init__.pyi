"""Public names, and the modules that they live in; each is imported when it is first used."""

from .pattern_measures import PatternFigures, pattern_figures
from .polisher import Polished, polish_design
from .simplifier import GameDesign, PolishedDesign, Simplified, simplify_design

__all__ = [
    "GameDesign",
    "PatternFigures",
    "Polished",
    "PolishedDesign",
    "Simplified",
    "pattern_figures",
    "polish_design",
    "simplify_design",
]
