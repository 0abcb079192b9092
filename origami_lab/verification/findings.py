"""What a sweep of the motion finds: panels that meet, intervals that are left open, contacts, the least distance."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Meeting:
    """Two panels and the driving angle (radians) at which something is the matter with them."""

    panels: tuple[int, int]
    angle: float
    how: str


@dataclass(frozen=True)
class Gap:
    """An interval of driving angles (radians) that could not be certified."""

    low: float
    high: float
    why: str


@dataclass
class Findings:
    """What a sweep found."""

    crossing: Meeting | None = None
    gaps: list[Gap] = field(default_factory=list)
    contacts: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    """Panels that touch over an interval, first and last driving angle at which they do."""
    clearance: float = float("inf")
    closest: Meeting | None = None
    intervals: int = 0
    states: int = 0
    looks: int = 0
    """Pairs of triangles over intervals that were looked at."""
    residual: float = 0.0
    thin: Meeting | None = None
    """Panels that are closer than the thickness."""
    unsure: Meeting | None = None
    """Panels that are closer than what the file rounds off."""
