"""Simplifying saved designs: the results stand beside them, under names of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from origami_lab.drawing.scene import TargetSurface
from origami_lab.experiment.saved_design import read_saved
from origami_lab.polish.design_writer import write_design
from origami_lab.polish.simplifier import TOLERANCE, GameDesign, Simplified, simplify_design

SIMPLIFIED = "simplified"
"""How the names of a simplified design's files begin."""


@dataclass(frozen=True, eq=False)
class SimplifiedTrial:
    """A simplified design and its files."""

    simplified: Simplified
    source: Path
    """The FOLD file of the design that was simplified."""
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def simplify_trial(
    file: Path, overrides: Sequence[str] = (), *, tolerance: float = TOLERANCE, pictures: bool = True
) -> SimplifiedTrial:
    """Simplify a saved design and write the result beside it.

    The files are ``simplified.fold`` and so on beside a trial's ``best.fold``, ``NAME.simplified.fold`` beside another.

    Parameters
    ----------
    file, overrides
        See :func:`~origami_lab.experiment.saved_design.read_saved`.
    tolerance
        See :func:`~origami_lab.polish.simplifier.simplify_design`.

    Raises
    ------
    InputError
        If the design cannot be read, or not even the whole design is certified.
    """
    saved = read_saved(file, overrides)
    design = GameDesign(saved.game, saved.objective, saved.actions, saved.facts)
    simplified = simplify_design(design, tolerance)
    surface = None if saved.target is None else TargetSurface(saved.target.vertices, saved.target.faces)
    folder, stem = saved.beside(SIMPLIFIED)
    figures = {"certificate": simplified.certificate.verdict, **simplified_figures(simplified, tolerance)}
    files, warnings = write_design(
        folder, stem, simplified.design, simplified.certificate, figures, surface, pictures=pictures
    )
    return SimplifiedTrial(simplified, file, files, warnings)


def simplified_figures(simplified: Simplified, tolerance: float) -> Mapping[str, Any]:
    """What became of a design, as plain JSON values: lengths in cells, angles in degrees."""
    return {
        "tolerance": tolerance,
        "removed": simplified.removed,
        "after": {"return": simplified.value, **simplified.figures.to_json()},
        "before": {"return": simplified.value_before, **simplified.figures_before.to_json()},
    }
