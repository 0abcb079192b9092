"""Kernels before the first trial of a process: loaded, and on a fresh installation compiled, all that a run needs.

So the time of a trial is that of its search, and a run can say when compiling has ended.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.staged_search import stage_generator
from origami_lab.experiment.trial import run_trial
from origami_lab.runs.run_folder import RunFolder

FEW, SOME = 200, 2000
"""Interactions that load what a search needs, and that find a first design, too; FEW steps of a polish load its own."""


def load_kernels(settings: Settings, earlier: Parts) -> None:
    """Play a few interactions whose result nobody sees. What a user's own parts do is left to the trials.

    Parameters
    ----------
    earlier
        Parts made from the same settings: none of them is played with, but what lasts is used.
    """
    from origami_lab.search.problem import Problem, SearchEnded

    parts = build_parts(settings, earlier)
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
            with tempfile.TemporaryDirectory(prefix="origami-lab-") as place:
                folder = RunFolder(Path(place))
                folder.begin(settings.config, earlier.target, None)
                run_trial(small, 0, folder, parts=build_parts(settings, earlier))
    return clock.seconds if _are_known(earlier) else None


def _are_known(parts: Parts) -> bool:
    """Whether the parts are ours, and learn nothing on the way: that takes long."""
    homes = [type(part).__module__ for part in (parts.objective, parts.searcher)]
    return all(home.startswith("origami_lab.") and not home.endswith(".ppo") for home in homes)
