"""Polishing and simplifying saved designs: results stand beside them, under names of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

from origami_lab.errors import InputError
from origami_lab.experiment.run_page import write_run_page
from origami_lab.experiment.run_summary import refresh_tables
from origami_lab.experiment.saved_design import SavedDesign, read_saved
from origami_lab.file_names import POLISHED, RESULT, SIMPLIFIED
from origami_lab.polish.design_writer import write_design
from origami_lab.polish.measured import all_returns
from origami_lab.polish.polisher import FINER, STEPS, Polished, polish_design
from origami_lab.polish.simplifier import TOLERANCE, GameDesign, PolishedDesign, Simplified, simplify_design
from origami_lab.runs.locks import locked
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.trial_row import (
    LIKENESSES,
    OK,
    POLISHED_RETURNS,
    RETURNS,
    STOPPED,
    TIME_LIMIT,
    TrialRow,
    beside_row,
)

Made = TypeVar("Made", Polished, Simplified)


@dataclass(frozen=True)
class PolishOptions:
    """What a polish is asked for; see :func:`~origami_lab.polish.polisher.polish_design`."""

    steps: int = STEPS
    seed: int = 0
    seconds: float | None = None
    finer: int = FINER
    simplify: float | None = None
    """A tolerance in cells: what the design does not need is taken out at the end. None leaves all of it."""
    thickness: float = 0.0
    """In board cells: panels that share no vertex must keep this distance in the certificate."""


@dataclass(frozen=True, eq=False)
class Reworked(Generic[Made]):
    """What was made of a saved design, and its files."""

    made: Made
    source: Path
    """The FOLD file of the design that it was made of."""
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def polish_saved(
    file: Path,
    overrides: Sequence[str] = (),
    options: PolishOptions | None = None,
    *,
    pictures: bool = True,
    on_progress: Callable[[int, float], None] | None = None,
) -> Reworked[Polished]:
    """Polish a saved design and write the result beside it.

    A trial's ``best.fold`` gets ``polished.fold``, ``polished.json`` (returns, driving angle, steps),
    ``polished.certificate.json``, ``polished.png``, ``polished_pattern.png`` and ``polished.html``, its row in the
    tables of the run the figures; any other file gets ``NAME.polished.fold`` and so on.

    Parameters
    ----------
    file, overrides
        See :func:`~origami_lab.experiment.saved_design.read_saved`.

    Raises
    ------
    InputError
        If the design cannot be read or cannot be polished, or its folder cannot be written.
    """
    saved, options = read_saved(file, overrides), options or PolishOptions()
    if saved.run is None:
        polished, figures = _polish(saved, options, on_progress)
        with _to_be_written(file.parent):
            return _written(polished, figures, saved, POLISHED, file.parent, pictures)
    with _to_be_written(saved.run), locked(saved.run):
        folder = RunFolder(saved.run)
        done, _ = polish_trial(saved, folder, options, pictures=pictures, on_progress=on_progress)
        refresh_tables(folder)
        write_run_page(saved.run)
    return done


def polish_trial(
    saved: SavedDesign,
    folder: RunFolder,
    options: PolishOptions,
    *,
    pictures: bool = True,
    on_progress: Callable[[int, float], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> tuple[Reworked[Polished], TrialRow | None]:
    """Polish the design of a trial that is on disk, and add the result to the trial's folder and its row.

    Returns
    -------
    What was made, and the trial's row with it; None for a trial without a readable one.

    Raises
    ------
    InputError
        If the design cannot be polished.
    FolderError
        If the files cannot be written; nothing is left of them.
    """
    polished, figures = _polish(saved, options, on_progress, should_stop)
    seed = saved.seed
    row = folder.rows([seed]).get(seed)
    with folder.more_of_trial(seed, POLISHED) as path:
        done = _written(polished, figures, saved, POLISHED, path, pictures)
        if done.warnings:
            folder.require_room()
        if row is not None:
            stopped = should_stop is not None and should_stop()
            row = _with_polish(row, polished, OK if polished.whole else STOPPED if stopped else TIME_LIMIT)
            row.write(path / RESULT, beside_row(folder.trial(seed) / RESULT))
    return replace(done, files=tuple(folder.trial(seed) / file.name for file in done.files)), row


def simplify_saved(
    file: Path, overrides: Sequence[str] = (), *, tolerance: float = TOLERANCE, pictures: bool = True
) -> Reworked[Simplified]:
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
        If the design cannot be read, not even the whole design is certified, or its folder cannot be written.
    """
    saved = read_saved(file, overrides)
    whole = GameDesign(saved.game, saved.objective, saved.actions, saved.facts)
    simplified = simplify_design(whole, tolerance, saved.thickness)
    figures = {"certificate": simplified.certificate.verdict, **simplified_figures(simplified, tolerance)}
    with _to_be_written(file.parent):
        return _written(simplified, figures, saved, SIMPLIFIED, file.parent, pictures)


@contextmanager
def _to_be_written(folder: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, FolderError) as error:
        reason = error.why if isinstance(error, FolderError) else error.strerror or str(error)
        raise InputError("path", folder, f"cannot be written: {reason}") from error


def _written(
    made: Made, figures: Mapping[str, Any], saved: SavedDesign, what: str, folder: Path, pictures: bool
) -> Reworked[Made]:
    """Write the files of what was made of a saved design to a folder."""
    stem = saved.stem(what)
    files, warnings = write_design(
        folder, stem, made.design, made.certificate, figures, saved.surface, pictures=pictures
    )
    return Reworked(made, saved.file, files, warnings)


def _polish(
    saved: SavedDesign,
    options: PolishOptions,
    on_progress: Callable[[int, float], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> tuple[Polished, Mapping[str, Any]]:
    """The polished design, simplified if that is asked for, and what ``polished.json`` says of it."""
    polished = polish_design(
        saved.game,
        saved.objective,
        saved.actions,
        saved.angle,
        steps=options.steps,
        seed=options.seed,
        seconds=options.seconds,
        finer=options.finer,
        metadata=saved.facts,
        thickness=options.thickness or saved.thickness,
        on_progress=on_progress,
        should_stop=should_stop,
    )
    if options.simplify is None:
        return polished, polished_figures(polished, options.seed)
    angle = float(polished.design.driving_angles[-1])
    whole = PolishedDesign(polished.board, angle, saved.objective, polished.design.metadata)
    left = simplify_design(whole, options.simplify, options.thickness or saved.thickness)
    assert left.board is not None
    returns = all_returns(left.board, angle, saved.objective, saved.objective.bind(left.board.game))
    simple = replace(polished, design=left.design, returns=returns, certificate=left.certificate, board=left.board)
    figures = polished_figures(simple, options.seed)
    return simple, {**figures, "simplified": simplified_figures(left, options.simplify)}


def _with_polish(row: TrialRow, polished: Polished, ended: str) -> TrialRow:
    """A trial's row with what its polish came to."""
    returns = {column: polished.returns[name] for column, name in zip(POLISHED_RETURNS, RETURNS, strict=True)}
    returns |= {f"polished_{name}": polished.returns[name] for name in LIKENESSES}
    found = {
        "polish": ended,
        "polish_steps": polished.steps,
        "polished_driving_angle": polished.driving_angle,
        "polished_certificate": polished.certificate.verdict,
    }
    return TrialRow.from_values({**row.values(), **returns, **found})


def polished_figures(polished: Polished, seed: int) -> Mapping[str, Any]:
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


def simplified_figures(simplified: Simplified, tolerance: float) -> Mapping[str, Any]:
    """What became of a design, as plain JSON values: lengths in cells, angles in degrees."""
    return {
        "tolerance": tolerance,
        "removed": simplified.removed,
        "after": {"return": simplified.value, **simplified.figures.to_json()},
        "before": {"return": simplified.value_before, **simplified.figures_before.to_json()},
    }
