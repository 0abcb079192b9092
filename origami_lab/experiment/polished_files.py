"""Polishing saved designs: their results stand beside them, under names of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from origami_lab.drawing.scene import TargetSurface
from origami_lab.experiment.saved_design import read_saved
from origami_lab.experiment.simplified_files import simplified_figures
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.polish.design_writer import write_design
from origami_lab.polish.measured import all_returns
from origami_lab.polish.polisher import FINER, STEPS, Polished, polish_design
from origami_lab.polish.simplifier import PolishedDesign, simplify_design

POLISHED = "polished"
"""How the names of a polished design's files begin."""


@dataclass(frozen=True, eq=False)
class PolishedTrial:
    """A polished design and its files."""

    polished: Polished
    source: Path
    """The FOLD file of the design that was polished."""
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def polish_trial(
    file: Path,
    overrides: Sequence[str] = (),
    *,
    steps: int = STEPS,
    seed: int = 0,
    seconds: float | None = None,
    finer: int = FINER,
    pictures: bool = True,
    simplify: float | None = None,
    on_progress: Callable[[int, float], None] | None = None,
) -> PolishedTrial:
    """Polish a saved design and write the result beside it.

    A trial's ``best.fold`` gets ``polished.fold``, ``polished.json`` (returns, driving angle, steps),
    ``polished.certificate.json``, ``polished.png``, ``polished_pattern.png`` and ``polished.html``; any other file
    ``NAME.polished.fold`` and so on.

    Parameters
    ----------
    file, overrides
        See :func:`~origami_lab.experiment.saved_design.read_saved`.
    steps, seed, seconds, finer, on_progress
        See :func:`~origami_lab.polish.polisher.polish_design`.

    simplify
        A tolerance in cells: what the design does not need is taken out at the end, see
        :func:`~origami_lab.polish.simplifier.simplify_design`. None leaves all of it.

    Raises
    ------
    InputError
        If the design cannot be read or cannot be polished.
    """
    saved = read_saved(file, overrides)
    polished = polish_design(
        saved.game,
        saved.objective,
        saved.actions,
        saved.angle,
        steps=steps,
        seed=seed,
        seconds=seconds,
        finer=finer,
        metadata=saved.facts,
        on_progress=on_progress,
    )
    figures = figures_of(polished, seed)
    if simplify is not None:
        polished, figures = _simplified(polished, saved.objective, seed, simplify)
    surface = None if saved.target is None else TargetSurface(saved.target.vertices, saved.target.faces)
    folder, stem = saved.beside(POLISHED)
    files, warnings = write_design(
        folder, stem, polished.design, polished.certificate, figures, surface, pictures=pictures
    )
    return PolishedTrial(polished, file, files, warnings)


def _simplified(
    polished: Polished, objective: ShapeObjective, seed: int, tolerance: float
) -> tuple[Polished, Mapping[str, Any]]:
    """A polished design without what it does not need, and its figures."""
    angle = float(polished.design.driving_angles[-1])
    facts = polished.design.metadata
    left = simplify_design(PolishedDesign(polished.board, angle, objective, facts), tolerance)
    assert left.board is not None
    returns = all_returns(left.board, angle, objective, objective.bind(left.board.game))
    whole = replace(polished, design=left.design, returns=returns, certificate=left.certificate, board=left.board)
    return whole, {**figures_of(whole, seed), "simplified": simplified_figures(left, tolerance)}


def figures_of(polished: Polished, seed: int) -> Mapping[str, Any]:
    """What ``polished.json`` says: plain JSON values, angles in degrees."""
    board = polished.board
    moves = board.layout.moves
    return {
        **polished.returns,
        "driving_angle": polished.driving_angle,
        "certificate": polished.certificate.verdict,
        "before": {**polished.returns_before, "driving_angle": polished.driving_angle_before},
        "steps": polished.steps,
        "seed": seed,
        "whole": polished.whole,
        "seconds": round(polished.seconds, 3),
        "parts_of_a_cell": board.finer,
        "symmetry": board.game.symmetry.name,
        "points": board.points.tolist(),
        "moves": [{name: int(move[name]) for name in moves.dtype.names or ()} for move in moves],
    }
