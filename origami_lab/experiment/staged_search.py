"""The search of a trial in stages: each with its own budget and random numbers, above what those before it found."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.config.instantiate import Parts
from origami_lab.config.physical_size import aimed_return, thickness_in_cells
from origami_lab.config.settings import Settings
from origami_lab.config.stages import Stage
from origami_lab.experiment.kept_design import is_refuted
from origami_lab.experiment.search_state import SearchState, state_of_bytes
from origami_lab.runs.checkpoint import Checkpoint
from origami_lab.runs.trial_row import BUDGET, BY_ITSELF, GOAL, MINUTES, NO_DESIGN, OK, STOPPED
from origami_lab.workers.worker_process import reason_of

if TYPE_CHECKING:
    from origami_lab.search.problem import Outcome, Problem, Searcher


@dataclass(frozen=True)
class Searched:
    """What the stages have come to."""

    outcome: Outcome
    parts: Parts
    """Those of the last stage."""
    seconds: float
    """Time of all searches, without that of compiling kernels."""
    status: str
    ended: str | None
    """What ended the last stage; None if it was stopped."""
    state: SearchState | None
    """From where another stage goes on; None if the first one has not come to its end."""
    record: tuple[Mapping[str, Any], ...]
    warnings: list[str]

    @property
    def stages(self) -> int:
        """Stages that have come to their end."""
        return 0 if self.state is None else self.state.stages


def search_in_stages(
    settings: Settings,
    seed: int,
    parts: Parts,
    make_parts: Callable[[], Parts],
    begun: SearchState | None,
    checkpoints: Checkpoint,
    on_progress: Callable[[Problem, float], None],
    should_stop: Callable[[], bool] | None,
) -> Searched:
    """Search, stage by stage, from where an earlier run has come to.

    Between two stages all goes through the state as it is written to disk, and each has parts of its own: so it is the
    same whether one process has searched in all of them or each in another one.

    Parameters
    ----------
    parts, make_parts
        Fresh parts, and what makes others.
    begun
        The state of the trial; None if it begins.
    checkpoints
        Where the search is saved on the way, if its searcher does so.
    on_progress
        Told a problem that is searched, and the seconds so far.
    """
    stages, state, used = (*settings.stages, settings.stage), begun, False
    warnings: list[str] = []
    while True:
        number = 0 if state is None else state.stages
        parts, used = make_parts() if used else parts, True
        played = _play(settings, stages[number], number, seed, parts, state, checkpoints, on_progress, should_stop)
        warnings += played.warnings
        if played.state is None or played.state.stages == len(stages) or played.status == STOPPED:
            return replace(played, warnings=warnings)
        written = state_of_bytes(played.state.to_bytes())
        state = replace(written, seconds=played.state.seconds, record=played.state.record)


def _play(
    settings: Settings,
    stage: Stage,
    number: int,
    seed: int,
    parts: Parts,
    state: SearchState | None,
    checkpoints: Checkpoint,
    on_progress: Callable[[Problem, float], None],
    should_stop: Callable[[], bool] | None,
) -> Searched:
    """One stage."""
    from origami_lab.jit import compile_clock
    from origami_lab.search.problem import Problem, SearchEnded

    before = 0.0 if state is None else state.seconds
    limit = math.inf if stage.minutes is None else 60.0 * stage.minutes
    aim = stage.target_return
    searcher, warnings = parts.searcher, list[str]()
    saved: Mapping[str, NDArray[Any]] = {} if state is None else state.searcher
    with compile_clock() as clock:
        start = time.perf_counter()

        def seconds() -> float:
            earlier = before if checkpoints.seconds_before is None else checkpoints.seconds_before
            return earlier + time.perf_counter() - start - clock.seconds

        checkpoints.begin(number, seconds)
        problem = Problem(
            parts.game,
            parts.objective,
            stage.budget,
            certify=settings.certify,
            on_progress=lambda problem: on_progress(problem, seconds()),
            should_stop=should_stop,
            goal=math.inf if aim is None else aimed_return(aim, settings, parts.objective, parts.target),
            vets=_vet(settings, parts) if settings.certify else None,
            time_is_up=None if stage.minutes is None else lambda: seconds() >= limit,
            begun=None if state is None else state.outcome,
            checkpoints=checkpoints,
        )
        plays = not problem.done and before < limit
        if plays:
            if saved:
                searcher.load(saved)  # type: ignore[attr-defined]
            with suppress(SearchEnded):  # of one that does not ask for ``done``
                searcher.search(problem, stage_generator(seed, number))
    total = seconds() if plays else before
    on_progress(problem, total)
    outcome = problem.outcome()
    ended = _what_ended(problem, late=problem.is_late or total >= limit)
    # a search that ends by itself before its budget is spent is a finished one
    stopped = problem.stopped and ended == BY_ITSELF
    record = () if state is None else state.record
    if stopped:
        return Searched(outcome, parts, total, STOPPED, None, state, record, warnings)
    if plays:
        saved, warnings = _saved(searcher)
    best = float(outcome.value) if outcome.succeeded else None
    came_to = {"interactions": int(outcome.interactions), "seconds": round(total, 3), "return": best, "ended": ended}
    record = (*record, {**stage.to_node(), **came_to})
    after = SearchState(number + 1, outcome, total, record, saved)
    return Searched(outcome, parts, total, OK if outcome.succeeded else NO_DESIGN, ended, after, record, warnings)


def _vet(settings: Settings, parts: Parts) -> Callable[[Sequence[int], int], bool]:
    """What tells designs that are worth ending a search for from those that the certificate would refute."""
    thickness = thickness_in_cells(settings, parts.target)

    def vets(actions: Sequence[int], angle: int) -> bool:
        return not is_refuted(parts.game.design(actions, angle), thickness)

    return vets


def _what_ended(problem: Problem, late: bool) -> str:
    """What ended a search that nobody has stopped."""
    if problem.best_value >= problem.goal:
        return GOAL
    if problem.interactions >= problem.budget:
        return BUDGET
    return MINUTES if late else BY_ITSELF


def _saved(searcher: Searcher) -> tuple[Mapping[str, NDArray[Any]], list[str]]:
    """What a searcher saves of itself; nothing if it does not, or if what it saves cannot be kept, with a warning."""
    save = getattr(searcher, "save", None)
    if not callable(save):
        return {}, []
    try:
        arrays = {str(name): np.asarray(value) for name, value in save().items()}
        for name, array in arrays.items():
            if array.dtype.hasobject:
                raise TypeError(f"{name} is no array of numbers or text")
        return arrays, []
    except Exception as error:
        return {}, [f"the state of the searcher is not kept, a longer run begins it anew: {reason_of(error)}"]


def stage_generator(seed: int, number: int) -> np.random.Generator:
    """The one source of randomness of a stage; that of the first one is the trial's own."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,) if number else ()))
