"""One trial: one seed's search, its best design, and the design's files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.physical_size import is_distance, thickness_in_cells
from origami_lab.config.settings import Settings
from origami_lab.experiment.kept_design import Kept, keep_design
from origami_lab.experiment.search_state import SearchState, read_state, state_of_row
from origami_lab.experiment.staged_search import Searched, search_in_stages
from origami_lab.experiment.trial_files import write_files
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.file_names import POLISHED, RESULT, STATE
from origami_lab.runs.checkpoint import Checkpoint
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.trial_row import FAILED, STOPPED, TrialRow, beside_row
from origami_lab.workers.worker_process import reason_of

if TYPE_CHECKING:
    from origami_lab.game.crease_pattern import CreasePattern
    from origami_lab.search.problem import Outcome, Problem


Report = Callable[[Progress | Polishing], None]


def is_done(row: TrialRow | None, settings: Settings) -> bool:
    """Whether there is nothing left to do for a trial, given its row if it has one."""
    return row is not None and is_searched(row, settings) and not (settings.polish and row.may_be_polished)


def is_searched(row: TrialRow, settings: Settings) -> bool:
    """Whether a trial has gone through all stages of its run."""
    return row.has_gone_through(len(settings.stages) + 1, settings.budget)


def run_trial(
    settings: Settings,
    seed: int,
    folder: RunFolder,
    report: Report | None = None,
    should_stop: Callable[[], bool] | None = None,
    parts: Parts | None = None,
    make_parts: Callable[[], Parts] | None = None,
    keep_state: bool = True,
) -> tuple[TrialRow, list[str]]:
    """Search with one seed and write ``seed=N`` into the run folder, then polish its best design if that is asked for.

    A trial that is there as a whole is not searched for again; one of a run that goes on is searched for what it has
    not come to yet. The result depends on the settings and the seed only, not on the process or on what ran in it
    before: ``parts`` may be given where they are built already, but not used; ``make_parts`` makes others. Without
    ``keep_state`` a longer run has to begin the searcher anew.

    Returns
    -------
    The trial's row of trials.csv, and warnings: pictures that could not be drawn, designs that are refuted.

    Raises
    ------
    FolderError
        If its files cannot be written; nothing is left of those that could not.
    """
    make_parts = make_parts or (lambda: build_parts(settings))
    parts, warnings = parts or make_parts(), list[str]()
    row = folder.rows([seed]).get(seed)
    if row is None or not is_searched(row, settings):
        begun, warnings = _begun(folder, row)

        def on_progress(problem: Problem, seconds: float) -> None:
            if report is not None:
                best = problem.best_value
                report(Progress(seed, problem.interactions, best if math.isfinite(best) else None, seconds))

        checkpoints = Checkpoint(folder.path, seed)
        searched = search_in_stages(settings, seed, parts, make_parts, begun, checkpoints, on_progress, should_stop)
        row, more = write_trial(settings, seed, folder, searched, keep_state)
        warnings += [*searched.warnings, *more]
        if searched.status != STOPPED:
            checkpoints.remove()
    if settings.polish and row.may_be_polished and not (should_stop and should_stop()):
        row, more = _polish(settings, settings.polish, folder, parts, row, report, should_stop)
        warnings += more
    return row, warnings


def write_trial(
    settings: Settings,
    seed: int,
    folder: RunFolder,
    searched: Searched,
    keep_state: bool,
) -> tuple[TrialRow, list[str]]:
    """Write the files of what a search has found into the run folder; returns its row, and warnings."""
    from origami_lab.objectives.objective import pose

    parts, status = searched.parts, searched.status

    def make(found: Outcome) -> CreasePattern:
        design = parts.game.design(found.actions, found.angle)
        facts: dict[str, object] = {"task": settings.task, "search": settings.method, "seed": seed}
        facts |= {"board": parts.game.board_fact}
        facts |= {"return": _return(parts, found), "driving_angle": _driving_angle(parts, found)}
        facts |= {"interactions": int(found.interactions), "status": status}
        if parts.target is not None and parts.target.units_per_cell is not None:
            facts["units_per_cell"] = parts.target.units_per_cell
        if settings.cell is not None:
            facts |= {"cell_mm": settings.cell} | ({"sheet_mm": list(settings.sheet)} if settings.sheet else {})
            facts |= {"return_in": "cells"} if is_distance(parts.objective) else {}
        return replace(design, metadata=MappingProxyType(facts | pose(parts.objective, design)))

    with folder.new_trial(seed) as path:
        thickness = thickness_in_cells(settings, parts.target)
        verifies = settings.files == "all" and settings.certify
        kept = keep_design(path, searched.outcome, make, verifies, thickness)
        row = _row(seed, searched, kept, settings.cell)
        if searched.state is not None and keep_state:
            (path / STATE).write_bytes(searched.state.to_bytes())
        return row, write_files(path, folder, settings, parts, kept, row, searched.record)


def _begun(folder: RunFolder, row: TrialRow | None) -> tuple[SearchState | None, list[str]]:
    """The state that a trial goes on from, None if it has come to the end of no stage, and warnings."""
    if row is None or row.has_failed:
        return None, []
    trial = folder.trial(row.seed)
    state = read_state(trial)
    if state is not None or row.outcome == STOPPED:
        return state, []
    says = f"no {STATE} can be read in {trial}: the searcher begins anew, above the best"
    return state_of_row(trial, row), [says] if row.stages is not None else []


def _polish(
    settings: Settings,
    steps: int,
    folder: RunFolder,
    parts: Parts,
    row: TrialRow,
    report: Report | None,
    should_stop: Callable[[], bool] | None,
) -> tuple[TrialRow, list[str]]:
    """The row with what came of the polish of the trial's best design; one that fails costs no more than itself."""
    from origami_lab.experiment.reworked_designs import PolishOptions, polish_trial
    from origami_lab.experiment.saved_design import saved_in

    options = PolishOptions(
        steps,
        seconds=settings.polish_seconds,
        simplify=settings.polish_simplify,
        thickness=thickness_in_cells(settings, parts.target),
    )
    if report is not None:
        report(Polishing(row.seed, 0, row["return"]))
    try:
        done, polished = polish_trial(
            saved_in(folder.trial(row.seed), parts.game, parts.objective, parts.target),
            folder,
            options,
            pictures=settings.files == "all",
            on_progress=report and (lambda laid, best: report(Polishing(row.seed, laid, best))),
            should_stop=should_stop,
        )
    except FolderError:
        raise
    except Exception as error:
        reason = reason_of(error)
        row = replace(row, polish=f"{FAILED}: {reason}")
        with folder.more_of_trial(row.seed, POLISHED) as path:
            row.write(path / RESULT, beside_row(folder.trial(row.seed) / RESULT))
        return row, [f"its best design is not polished: {reason}"]
    return polished or row, list(done.warnings)


def _return(parts: Parts, outcome: Outcome) -> float:
    """The best return; if no episode succeeded all of them brought the penalty."""
    return float(outcome.value) if outcome.succeeded else parts.game.penalty


def _driving_angle(parts: Parts, outcome: Outcome) -> float | None:
    """That of the best design, in degrees."""
    return math.degrees(parts.game.angles[outcome.angle]) if outcome.succeeded else None


def _row(seed: int, searched: Searched, kept: Kept, cell: float | None) -> TrialRow:
    from origami_lab.objectives.objective import report as report_figures

    outcome, design, parts, seconds = kept.outcome, kept.design, searched.parts, searched.seconds
    figures = report_figures(parts.objective, parts.game, outcome.actions, outcome.angle)
    own = _finite(figures.get("return_own"))
    return TrialRow(
        seed=seed,
        return_=_return(parts, outcome),
        return_vertex=_finite(figures.get("return_vertex")),
        return_surface=_finite(figures.get("return_surface")),
        return_sampled=_finite(figures.get("return_sampled")),
        driving_angle=_driving_angle(parts, outcome),
        interactions=int(outcome.interactions),
        interactions_to_best=int(outcome.interactions_to_best),
        seconds=round(seconds, 3),
        interactions_per_second=round(outcome.interactions / max(seconds, 1e-9), 1),
        vertices=len(design.vertices),
        creases=int(np.count_nonzero(~design.boundary)),
        panels=len(design.panels),
        reach=len(design.driving_angles),
        status=searched.status,
        episodes=int(outcome.episodes),
        rejected=int(outcome.rejected),
        places_evaluated=int(outcome.places_evaluated),
        certificate=kept.verdict,
        return_percent=_finite(figures.get("return_percent")),
        return_units=_finite(figures.get("return_units")),
        chamfer=_finite(figures.get("chamfer")),
        likeness=_finite(figures.get("likeness")),
        cell_mm=cell,
        return_mm=None if cell is None or own is None else own * cell,
        width_mm=None if cell is None else float(np.ptp(design.vertices[:, 0])) * cell,
        height_mm=None if cell is None else float(np.ptp(design.vertices[:, 1])) * cell,
        ended=searched.ended,
        stages=searched.stages,
    )


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
