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
from origami_lab.experiment.trial_files import write_files
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import NO_DESIGN, OK, STOPPED, TrialRow

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


def run_trial(
    settings: Settings,
    seed: int,
    folder: RunFolder,
    report: Callable[[Progress], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
    parts: Parts | None = None,
) -> tuple[TrialRow, list[str]]:
    """Search with one seed and write ``seed=N`` into the run folder.

    The result depends on the settings and the seed only, not on the process or on what ran in it before:
    ``parts`` may be given where they are built already, but not used.

    Returns
    -------
    The trial's row of trials.csv, and warnings (pictures that could not be drawn).

    Raises
    ------
    FolderError
        If its files cannot be written; nothing is left of them.
    """
    from origami_lab.jit import compile_clock
    from origami_lab.objectives.objective import pose
    from origami_lab.search.problem import Problem, SearchEnded

    def on_progress(problem: Problem) -> None:
        if report is not None:
            best = problem.best_value
            found = best if math.isfinite(best) else None
            report(Progress(seed, problem.interactions, found, time.perf_counter() - start - clock.seconds))

    parts = parts or build_parts(settings)
    problem = Problem(
        parts.game,
        parts.objective,
        settings.budget,
        certify=settings.certify,
        on_progress=on_progress,
        should_stop=should_stop,
    )
    start = time.perf_counter()
    # a searcher that does not ask for ``done`` ends by SearchEnded
    with compile_clock() as clock, suppress(SearchEnded):
        parts.searcher.search(problem, random_generator(seed))
    seconds = time.perf_counter() - start - clock.seconds
    on_progress(problem)

    outcome = problem.outcome()
    design = parts.game.design(outcome.actions, outcome.angle)
    # a search that ends by itself before its budget is spent is a finished one
    stopped = problem.stopped and outcome.interactions < settings.budget
    row = _row(seed, parts, outcome, design, seconds, stopped)
    facts = {"task": settings.task, "search": settings.method, "board": parts.game.board_size}
    facts |= {name: row[name] for name in ("seed", "return", "driving_angle", "interactions", "status")}
    if parts.target is not None and parts.target.units_per_cell is not None:
        facts["units_per_cell"] = parts.target.units_per_cell
    facts |= pose(parts.objective, design)
    design = replace(design, metadata=MappingProxyType(facts))
    with folder.new_trial(seed) as path:
        return write_files(path, folder, settings, parts, outcome, design, row)


def random_generator(seed: int) -> np.random.Generator:
    """The one source of randomness of a trial."""
    return np.random.default_rng(np.random.SeedSequence(seed))


def _row(seed: int, parts: Parts, outcome: Outcome, design: CreasePattern, seconds: float, stopped: bool) -> TrialRow:
    from origami_lab.objectives.objective import report as report_figures

    figures = report_figures(parts.objective, parts.game, outcome.actions, outcome.angle)
    best = outcome.angle if outcome.succeeded else None
    return TrialRow(
        seed=seed,
        # no episode succeeded: then all of them brought the penalty
        return_=float(outcome.value) if outcome.succeeded else parts.game.penalty,
        return_vertex=_finite(figures.get("return_vertex")),
        return_surface=_finite(figures.get("return_surface")),
        return_sampled=_finite(figures.get("return_sampled")),
        driving_angle=None if best is None else math.degrees(parts.game.angles[best]),
        interactions=int(outcome.interactions),
        interactions_to_best=int(outcome.interactions_to_best),
        seconds=round(seconds, 3),
        interactions_per_second=round(outcome.interactions / max(seconds, 1e-9), 1),
        vertices=len(design.vertices),
        creases=int(np.count_nonzero(~design.boundary)),
        panels=len(design.panels),
        reach=len(design.driving_angles),
        status=STOPPED if stopped else OK if outcome.succeeded else NO_DESIGN,
        episodes=int(outcome.episodes),
        rejected=int(outcome.rejected),
    )


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
