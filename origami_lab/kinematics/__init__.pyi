"""Public names, and the modules that they live in; each is imported when it is first used."""

from .three_units import hinge, lift, middle_crease, triangle_slack

__all__ = [
    "hinge",
    "lift",
    "middle_crease",
    "triangle_slack",
]
