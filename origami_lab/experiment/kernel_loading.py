"""Kernels before the first trial of a process: loaded, and on a fresh installation compiled, all that a run needs.

So the time of a trial is that of its search, and a run can say when compiling has ended. Compiling takes two cores
where there are two: the worker begins with what plays moves and goes on with its search, :func:`compile_beside` begins
with what legal moves are. Neither waits for the other: what one finds on disk it need not compile.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from origami_lab.caches import kernel_cache
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.staged_search import stage_generator
from origami_lab.experiment.trial import run_trial
from origami_lab.machine import container_cores, free_memory, usable_cores
from origami_lab.runs.run_folder import RunFolder
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.worker_process import Orders

if TYPE_CHECKING:
    from origami_lab.search.problem import Problem

COMPILING_BYTES = 2**30
"""Memory of a process that compiles kernels."""
FEW, SOME = 200, 2000
"""Interactions that load what a search needs, and that find a first design, too; FEW steps of a polish load its own."""


def load_kernels(settings: Settings, earlier: Parts) -> None:
    """Play a few interactions whose result nobody sees. What a user's own parts do is left to the trials.

    Parameters
    ----------
    earlier
        Parts made from the same settings: none of them is played with, but what lasts is used.
    """
    from origami_lab.game.kernels.play import replay_unchecked
    from origami_lab.jit import compile_for
    from origami_lab.search.problem import Problem, SearchEnded

    parts = build_parts(settings, earlier)
    compile_for(replay_unchecked, parts.game.new_states(1), 0, parts.game.rules.record, np.empty(0, dtype=np.int32))
    problem = Problem(parts.game, parts.objective, min(settings.budget, FEW), certify=settings.certify)
    if _are_known(parts):
        with suppress(SearchEnded):
            parts.searcher.search(problem, stage_generator(0, 0))


def warm_up(settings: Settings, earlier: Parts, compiles: Callable[[], None]) -> float | None:
    """Load the kernels of a run, and compile those that were never compiled.

    Returns
    -------
    How many seconds compiling took; None if the first trial may go on with it, because it plays parts of a user's.

    Parameters
    ----------
    earlier
        Parts made from the same settings, as for :func:`load_kernels`.
    compiles
        Called when compiling begins, if it does.
    """
    from origami_lab.jit import compile_clock

    with compile_clock(compiles) as clock:
        load_kernels(settings, earlier)
        if clock.seconds and _are_known(earlier):
            steps = min(settings.polish, FEW) if settings.polish else None
            small = replace(settings, budget=min(settings.budget, SOME), polish=steps, target_return=None, stages=())
            _run_unseen(small, build_parts(settings, earlier))
    return clock.seconds if _are_known(earlier) else None


def can_compile_beside() -> bool:
    """Whether a second process would help to compile kernels: it needs a core, memory, and the folder they share."""
    free, _ = free_memory()
    cores = min(usable_cores(), container_cores() or 2)
    return kernel_cache().base is not None and cores >= 2 and (free is None or free > 2 * COMPILING_BYTES)


def compile_beside(orders: Orders, calls: Calls, settings: Settings) -> None:
    """Compile part of what a run needs, in another order than its first worker, which compiles at the same time."""
    with suppress(Exception):  # a user's part may raise anything, and the run goes on without this
        load_beside(settings)


def load_beside(settings: Settings) -> None:
    """Load, or compile, what legal moves are, then what judges designs, then what draws them."""
    from origami_lab.objectives.objective import bind

    parts = build_parts(settings)
    states = parts.game.new_states(1)
    parts.game.legal(states)
    if not _are_known(parts):
        return
    evaluator = bind(parts.objective, parts.game)
    memos = evaluator.new_memos(1)
    evaluator.clear(memos, 0)
    evaluator.bound(states, memos, 0)
    evaluator.score(states, memos, 0)
    if exact := getattr(evaluator, "exact_value", None):
        exact(states, memos, 0)
    small = replace(settings, budget=1, polish=None, target_return=None, stages=())
    _run_unseen(small, replace(parts, searcher=_PlaysNothing()))


class _PlaysNothing:
    """A searcher that leaves a trial with its start pattern."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        """Find nothing."""


def _run_unseen(settings: Settings, parts: Parts) -> None:
    """Run a trial whose files nobody sees."""
    with tempfile.TemporaryDirectory(prefix="origami-lab-") as place:
        folder = RunFolder(Path(place))
        folder.begin(settings.config, parts.target, None)
        run_trial(settings, 0, folder, parts=parts)


def _are_known(parts: Parts) -> bool:
    """Whether the parts are ours, and learn nothing on the way: that takes long."""
    homes = [type(part).__module__ for part in (parts.objective, parts.searcher)]
    return all(home.startswith("origami_lab.") and not home.endswith(".ppo") for home in homes)
