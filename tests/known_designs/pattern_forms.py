"""Crease patterns as other programs read them, brought to one form in which they can be compared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from origami_lab.game.crease_pattern import CreasePattern

Segment = tuple[str, float, float, float, float]
"""Letter and ends; y runs up."""


def normal_form(segments: Sequence[Segment]) -> Counter[Segment]:
    """The same for patterns that differ by a shift and a scale, but not by a mirror or a turn."""
    ends = np.array([segment[1:] for segment in segments]).reshape(-1, 2)
    low = ends.min(axis=0)
    ends = (ends - low) / (ends.max(axis=0) - low).max()
    found = []
    for (letter, *_), (p, q) in zip(segments, ends.reshape(-1, 2, 2), strict=True):
        a, b = sorted([tuple(np.round(p, 5) + 0.0), tuple(np.round(q, 5) + 0.0)])
        found.append((letter, *a, *b))
    return Counter(found)


def true_form(design: CreasePattern, letters: str = "BMVF") -> Counter[Segment]:
    """The design's own creases; of the ``letters``."""
    return normal_form(
        [
            (letter, *design.vertices[u], *design.vertices[v])
            for (u, v), letter in zip(design.edges, design.assignments, strict=True)
            if letter in letters
        ]
    )
