"""The files of a trial beside its design: what that looks like, how it was found, and what came of it."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from origami_lab.config.instantiate import Parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.kept_design import Kept
from origami_lab.experiment.search_state import RECORD
from origami_lab.file_names import (
    ACTIONS,
    BEST,
    CURVE,
    CUT_SHEETS,
    FILM,
    FOLDED_PNG,
    MOTION,
    PATTERN_DXF,
    PATTERN_PNG,
    PATTERN_SVG,
    RESULT,
    VIEWER,
)
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import TrialRow

if TYPE_CHECKING:
    from origami_lab.game.crease_pattern import CreasePattern
    from origami_lab.search.problem import Outcome
    from origami_lab.targets.target import Target


MOTION_STEPS = 24
"""Folded states in motion.fold and motion.gif."""


def write_files(
    path: Path,
    folder: RunFolder,
    settings: Settings,
    parts: Parts,
    kept: Kept,
    row: TrialRow,
    record: Sequence[Mapping[str, Any]] = (),
) -> list[str]:
    """Write all files of a trial beside its ``best.fold``.

    Parameters
    ----------
    record
        What the stages of its search were given and have come to, for ``result.json``.

    Returns
    -------
    Warnings: what was refuted, pictures that could not be drawn.
    """
    from origami_lab.fold_format.writer import write_fold

    _write_actions(path / ACTIONS, settings, parts, kept.outcome, row)
    _write_curve(path / CURVE, parts, kept.outcome, row)
    warnings: list[str] = []
    if settings.files == "all":
        motion, warnings = _motion(parts, kept.outcome, kept.design)
        write_fold(path / MOTION, motion)
        warnings += [*kept.warnings, *_draw(path, folder, parts.target, on_paper=settings.cell is not None)]
    beside = {"passed_over": kept.passed_over, RECORD: list(record)}
    row.write(path / RESULT, {name: value for name, value in beside.items() if value})
    return warnings


def _motion(parts: Parts, outcome: Outcome, design: CreasePattern) -> tuple[CreasePattern, list[str]]:
    """The design's motion up to its best driving angle, in steps fine enough to be watched, and warnings."""
    if not outcome.succeeded:
        return design, []
    angles = np.linspace(0.0, parts.game.angles[outcome.angle], MOTION_STEPS + 1)[1:]
    try:
        return parts.game.motion(outcome.actions, angles, design.metadata), []
    except ValueError as error:  # certify=none: between the game's driving angles nothing was looked at
        return design, [f"its motion breaks off between the game's driving angles, which are all it shows: {error}"]


def _write_actions(path: Path, settings: Settings, parts: Parts, outcome: Outcome, row: TrialRow) -> None:
    """The best design's actions and moves, and all that the game needs to replay them."""
    from origami_lab.game.moves import move_to_dict
    from origami_lab.game.start_from_moves import saved_start

    document = {
        "game": {
            **vars(settings.game),
            "driving_angle_fixed": parts.game.driving_angle_fixed,
            "start": saved_start(settings.start, parts.game),
        },
        "seed": row.seed,
        "return": row.return_,
        "angle": int(outcome.angle),
        "driving_angle": row.driving_angle,
        "actions": [int(action) for action in outcome.actions],
        "moves": [move_to_dict(move) for move in parts.game.moves(outcome.actions)],
    }
    path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def _write_curve(path: Path, parts: Parts, outcome: Outcome, row: TrialRow) -> None:
    """Best return over interactions: one row an improvement, and one at the end."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("interactions", "return", "driving_angle"))
        for step in outcome.improvements:
            angle = math.degrees(parts.game.angles[step.angle])
            writer.writerow((int(step.interaction), float(step.value), angle))
        writer.writerow((row.interactions, row.return_, row.driving_angle))


def _draw(path: Path, folder: RunFolder, surface: Target | None, on_paper: bool) -> list[str]:
    """Draw the pictures. One that fails is a warning, the design is what counts; a full disk is an OSError."""
    warnings = []
    try:
        from origami_lab.drawing import TargetSurface, draw_folded, draw_motion, draw_pattern
        from origami_lab.export.formats import export_design
        from origami_lab.fold_format.motion_frames import with_motion
        from origami_lab.fold_format.writer import read_fold

        fold, motion = read_fold(path / BEST), read_fold(path / MOTION)
        both = with_motion(fold, motion) if fold.frames and motion.frames else fold
        target = None if surface is None else TargetSurface(surface.vertices, surface.faces)
    except Exception as error:
        return [f"no pictures: {type(error).__name__}: {error}"]
    pictures: list[tuple[str, Callable[[Path], object]]] = [
        (PATTERN_PNG, lambda file: draw_pattern(fold, file)),
        (FOLDED_PNG, lambda file: draw_folded(fold, file, target)),
        (FILM, lambda file: draw_motion(motion, file, target)),
        (PATTERN_SVG, lambda file: export_design(both, "svg", file)),
        (VIEWER, lambda file: export_design(both, "html", file, target=target)),
    ]
    if on_paper:
        pictures.append((PATTERN_DXF, lambda file: export_design(both, "dxf", file)))
        pictures += [(name, lambda file: export_design(both, "cut", file)) for name in CUT_SHEETS]
    for name, draw in pictures:
        try:
            draw(path / name)
        except Exception as error:
            written = (path / name).stat().st_size if (path / name).exists() else 0
            (path / name).unlink(missing_ok=True)
            # Pillow does not say what the system said
            folder.require_room(written)
            warnings.append(f"no {name}: {type(error).__name__}: {error}")
    return warnings
