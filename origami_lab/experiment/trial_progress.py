"""How far a trial is, as its worker says now and then."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """How far a trial is."""

    seed: int
    interactions: int
    best: float | None
    """Best return so far, None before the first."""
    seconds: float = 0.0
    """Time of the search so far, without that of compiling kernels."""


@dataclass(frozen=True)
class Polishing:
    """How far the polish of a trial's best design is."""

    seed: int
    steps: int
    best: float
    """Best return so far."""
