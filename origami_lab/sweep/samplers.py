"""Which parameters a trial gets: a function of the declaration, the trial's slot, and what has finished before.

Optuna's samplers are asked in a study in memory that holds the finished trials in order of their slots. So nothing
depends on the storage, on the worker that asks, or on trials that were lost on the way.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from origami_lab.config.checked_values import Value
from origami_lab.errors import InputError
from origami_lab.sweep.search_space import Parameter, Point, grid_points
from origami_lab.sweep.sweep_config import Declaration, Sampler

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution
    from optuna.samplers import BaseSampler
    from optuna.trial import FrozenTrial, Trial

ATTEMPTS, LEARNED_ATTEMPTS = 30, 10
"""Points that are drawn before a slot is given up whose points the searcher refuses; and how many of them the sampler
draws before chance does: it does not hear of refusals, and may go on about the same point."""


def distribution(parameter: Parameter) -> BaseDistribution:
    """The parameter in Optuna's words."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if parameter.choices:
        return CategoricalDistribution(parameter.choices)
    if parameter.whole:
        return IntDistribution(int(parameter.low), int(parameter.high), parameter.log, int(parameter.step or 1))
    return FloatDistribution(parameter.low, parameter.high, parameter.log, parameter.step)


def suggest(
    declaration: Declaration, number: int, history: Sequence[FrozenTrial], refusal: Callable[[Point], InputError | None]
) -> tuple[dict[str, Value], dict[str, Any]]:
    """Choose the parameters of one trial.

    With the samplers random and grid the history plays no part.

    Parameters
    ----------
    number
        The trial's slot in the study, from 0.
    history
        Finished trials, and running ones that have parameters, in order of their slots.
    refusal
        Says why a point cannot be played; then another one is drawn.

    Returns
    -------
    The point, and what the sampler wants to find with this trial later (Optuna's system attributes).

    Raises
    ------
    InputError
        If no point was found that can be played.
    """
    import optuna

    if declaration.sampler.name == "grid":
        return next(itertools.islice(shuffled_grid(declaration), number, None)), {}
    why: InputError | None = None
    for attempt in range(ATTEMPTS):
        words = (declaration.sampler.seed, number, attempt)
        seed = int(np.random.SeedSequence(words).generate_state(1)[0])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what is experimental
            learned = attempt < LEARNED_ATTEMPTS
            sampler = make_sampler(declaration.sampler, seed) if learned else optuna.samplers.RandomSampler(seed)
            study = optuna.create_study(direction="maximize", sampler=sampler)
            study.add_trials(history)
            trial = study.ask()
            point = ask_all(trial, declaration.space)
        why = refusal(point)
        if why is None:
            return point, dict(study.get_trials(deepcopy=False)[-1].system_attrs)
    raise InputError("space", f"trial {number}", f"none of {ATTEMPTS} points that were drawn can be played: {why}")


def ask_all(trial: Trial, space: Sequence[Parameter]) -> dict[str, Value]:
    """Have a trial suggest all parameters whose conditions hold."""
    point: dict[str, Value] = {}
    for parameter in space:
        if not parameter.active(point):
            continue
        if parameter.choices:
            point[parameter.name] = trial.suggest_categorical(parameter.name, parameter.choices)
        elif parameter.whole:
            low, high, step = int(parameter.low), int(parameter.high), int(parameter.step or 1)
            point[parameter.name] = trial.suggest_int(parameter.name, low, high, step=step, log=parameter.log)
        else:
            low_end, high_end = float(parameter.low), float(parameter.high)
            point[parameter.name] = trial.suggest_float(
                parameter.name, low_end, high_end, step=parameter.step, log=parameter.log
            )
    return point


def shuffled_grid(declaration: Declaration) -> list[dict[str, Value]]:
    """The points of the grid in the order in which they are played."""
    points = list(grid_points(declaration.space))
    order = np.random.default_rng(np.random.SeedSequence(declaration.sampler.seed)).permutation(len(points))
    return [points[number] for number in order]


def make_sampler(sampler: Sampler, seed: int) -> BaseSampler:
    """Optuna's sampler of that name."""
    from optuna.samplers import CmaEsSampler, RandomSampler, TPESampler

    if sampler.name == "tpe":
        return TPESampler(n_startup_trials=sampler.startup, seed=seed, multivariate=True, group=True)
    if sampler.name == "cmaes":
        return CmaEsSampler(n_startup_trials=sampler.startup, seed=seed, warn_independent_sampling=False)
    return RandomSampler(seed)
