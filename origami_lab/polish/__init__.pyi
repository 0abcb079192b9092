"""Public names, and the modules that they live in; each is imported when it is first used."""

from .pattern_measures import PatternFigures, pattern_figures
from .polisher import Polished, polish_design
from .simplifier import Simplified, simplify_design

__all__ = [
    "PatternFigures",
    "Polished",
    "Simplified",
    "pattern_figures",
    "polish_design",
    "simplify_design",
]
