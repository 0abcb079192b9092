"""One trial: one seed's search, its best design, and the design's files."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.kept_design import Kept, keep_design
from origami_lab.experiment.trial_files import write_files
from origami_lab.file_names import POLISHED, RESULT
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.saved_search import SavedSearch
from origami_lab.runs.trial_row import FAILED, NO_DESIGN, OK, STOPPED, TrialRow, beside_row
from origami_lab.workers.worker_process import reason_of

if TYPE_CHECKING:
    from origami_lab.game.crease_pattern import CreasePattern
    from origami_lab.search.problem import Outcome, Problem


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


Report = Callable[[Progress | Polishing], None]


def is_done(row: TrialRow | None, settings: Settings) -> bool:
    """Whether there is nothing left to do for a trial, given its row if it has one."""
    return row is not None and row.spent_budget and not (settings.polish and row.may_be_polished)


def run_trial(
    settings: Settings,
    seed: int,
    folder: RunFolder,
    report: Report | None = None,
    should_stop: Callable[[], bool] | None = None,
    parts: Parts | None = None,
) -> tuple[TrialRow, list[str]]:
    """Search with one seed and write ``seed=N`` into the run folder, then polish its best design if that is asked for.

    A trial that is there as a whole is not searched for again. The result depends on the settings and the seed only,
    not on the process or on what ran in it before: ``parts`` may be given where they are built already, but not used.

    Returns
    -------
    The trial's row of trials.csv, and warnings: pictures that could not be drawn, designs that are refuted.

    Raises
    ------
    FolderError
        If its files cannot be written; nothing is left of those that could not.
    """
    parts, warnings = parts or build_parts(settings), list[str]()
    row = folder.rows([seed]).get(seed)
    if row is None or not row.spent_budget:
        row, warnings = _search(settings, seed, folder, parts, report, should_stop)
    if settings.polish and row.may_be_polished and not (should_stop and should_stop()):
        row, more = _polish(settings, settings.polish, folder, parts, row, report, should_stop)
        warnings += more
    return row, warnings


def _search(
    settings: Settings,
    seed: int,
    folder: RunFolder,
    parts: Parts,
    report: Report | None,
    should_stop: Callable[[], bool] | None,
) -> tuple[TrialRow, list[str]]:
    """The search of a trial, and its files."""
    from origami_lab.jit import compile_clock
    from origami_lab.objectives.objective import pose
    from origami_lab.search.problem import Problem, SearchEnded

    def on_progress(problem: Problem) -> None:
        if report is not None:
            best = problem.best_value
            found = best if math.isfinite(best) else None
            report(Progress(seed, problem.interactions, found, elapsed()))

    def elapsed() -> float:
        return saves.seconds_before + time.perf_counter() - start - clock.seconds

    saves = SavedSearch(folder.path, seed, elapsed)
    problem = Problem(
        parts.game,
        parts.objective,
        settings.budget,
        certify=settings.certify,
        on_progress=on_progress,
        should_stop=should_stop,
        saves=saves,
    )
    start = time.perf_counter()
    # a searcher that does not ask for ``done`` ends by SearchEnded
    with compile_clock() as clock, suppress(SearchEnded):
        parts.searcher.search(problem, random_generator(seed))
    seconds = elapsed()
    on_progress(problem)

    outcome = problem.outcome()
    # a search that ends by itself before its budget is spent is a finished one
    stopped = problem.stopped and outcome.interactions < settings.budget
    status = STOPPED if stopped else OK if outcome.succeeded else NO_DESIGN

    def make(found: Outcome) -> CreasePattern:
        design = parts.game.design(found.actions, found.angle)
        facts: dict[str, object] = {"task": settings.task, "search": settings.method, "seed": seed}
        facts |= {"board": parts.game.board_fact}
        facts |= {"return": _return(parts, found), "driving_angle": _driving_angle(parts, found)}
        facts |= {"interactions": int(found.interactions), "status": status}
        if parts.target is not None and parts.target.units_per_cell is not None:
            facts["units_per_cell"] = parts.target.units_per_cell
        return replace(design, metadata=MappingProxyType(facts | pose(parts.objective, design)))

    with folder.new_trial(seed) as path:
        kept = keep_design(path, outcome, make, verifies=settings.files == "all" and settings.certify)
        row = _row(seed, parts, kept, seconds, status)
        warnings = write_files(path, folder, settings, parts, kept, row)
    if row.spent_budget:
        saves.remove()
    return row, warnings


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

    options = PolishOptions(steps, seconds=settings.polish_seconds, simplify=settings.polish_simplify)
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


def random_generator(seed: int) -> np.random.Generator:
    """The one source of randomness of a trial."""
    return np.random.default_rng(np.random.SeedSequence(seed))


def _return(parts: Parts, outcome: Outcome) -> float:
    """The best return; if no episode succeeded all of them brought the penalty."""
    return float(outcome.value) if outcome.succeeded else parts.game.penalty


def _driving_angle(parts: Parts, outcome: Outcome) -> float | None:
    """That of the best design, in degrees."""
    return math.degrees(parts.game.angles[outcome.angle]) if outcome.succeeded else None


def _row(seed: int, parts: Parts, kept: Kept, seconds: float, status: str) -> TrialRow:
    from origami_lab.objectives.objective import report as report_figures

    outcome, design = kept.outcome, kept.design
    figures = report_figures(parts.objective, parts.game, outcome.actions, outcome.angle)
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
        status=status,
        episodes=int(outcome.episodes),
        rejected=int(outcome.rejected),
        places_evaluated=int(outcome.places_evaluated),
        certificate=kept.verdict,
    )


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
