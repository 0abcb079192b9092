"""The two parts of a sweep: its trials, and then the comparison of the best on seeds that no trial played."""

from __future__ import annotations

import hashlib
import json
import statistics
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

import optuna
from optuna.pruners import BasePruner
from optuna.storages import BaseStorage
from optuna.trial import FrozenTrial, Trial, TrialState, create_trial

from origami_lab.config.instantiate import build_parts
from origami_lab.config.node import flatten
from origami_lab.config.option_files import groups
from origami_lab.config.resumed_settings import like_begun
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.runs.run_folder import RunFolder
from origami_lab.sweep.samplers import ask_all, suggest
from origami_lab.sweep.search_space import Point, corners, diagonals, overrides_of
from origami_lab.sweep.storage import open_study
from origami_lab.sweep.sweep_config import LEARNING, Declaration, Pruner
from origami_lab.sweep.trial_queue import HeldTrial, Slot, TrialQueue
from origami_lab.sweep.worker_identity import Worker
from origami_lab.text import nearest

QUICK = "files=designs"
"""Setting of every trial's run whose task does not say which files it leaves."""
OF_A_TRIAL = ("tracking=none", "workers=1", "verbosity=quiet", "resume=true")
"""Settings of every trial's run: resumed where its folder is there already."""
POINT, RETURNS = "point", "returns"
"""Attributes of a trial: its parameters and values, and the return of each of its seeds."""


class Job(ABC):
    """A study whose trials each play a configuration with the same seeds."""

    declaration: Declaration
    name: str
    """The study's name in the storage."""
    count: int
    seeds: Sequence[int]
    folder: Path
    pruner: BasePruner | None = None
    _composed: tuple[list[str] | None, Settings | None] = (None, None)

    @abstractmethod
    def fixed(self) -> dict[str, Any]:
        """Parts of the declaration that may not change while the study goes on."""

    @abstractmethod
    def begin(self, held: HeldTrial) -> tuple[Trial, list[str]]:
        """A trial for a slot, and the overrides that it plays; raises InputError if it cannot be played."""

    def queue(self, storage: BaseStorage, worker: Worker) -> TrialQueue:
        """Open its study, or create it."""
        study = open_study(storage, self.name, self.fixed(), self.pruner)
        return TrialQueue(study, self.count, worker)

    @abstractmethod
    def path(self, number: int) -> Path:
        """The run folder of a slot."""

    def why_pruned(self, held: HeldTrial, step: int) -> str:
        """The pruner's reason, in words; empty where there is no pruner."""
        return ""

    @cached_property
    def _begun(self) -> dict[str, Any]:
        """The configuration of the study's first trial, which this version need not have played; empty before it."""
        first = min(self.declaration.folder.glob("trials/*/config.yaml"), default=None)
        with suppress(InputError):  # a damaged one is said where it is played
            return {} if first is None else RunFolder(first.parent).config()
        return {}

    def settings(self, overrides: Sequence[str]) -> Settings:
        """The settings of a trial's run, without its folder. Composing takes a tenth of a second: not done twice."""
        if overrides != self._composed[0]:
            seeds = str(format_seeds(self.seeds)).replace(" ", "")
            composed = self.declaration.compose([QUICK, *overrides, f"seed={seeds}", *OF_A_TRIAL])
            self._composed = (list(overrides), like_begun(composed, self._begun))
        settings = self._composed[1]
        assert settings is not None
        return settings


class SearchJob(Job):
    """The trials of a sweep."""

    def __init__(self, declaration: Declaration) -> None:
        self.declaration = declaration
        self.name, self.count, self.seeds = declaration.study, declaration.trials, declaration.seeds
        self.folder = declaration.folder / "trials"
        self.pruner = make_pruner(declaration.pruner)

    def fixed(self) -> dict[str, Any]:
        return self.declaration.fixed

    def path(self, number: int) -> Path:
        return self.folder / f"{number:04d}"

    def begin(self, held: HeldTrial) -> tuple[Trial, list[str]]:
        system = dict(held.frozen().system_attrs)
        if "fixed_params" not in system:
            learns = self.declaration.sampler.name in LEARNING
            slots = held.queue.look() if learns else []
            history = [frozen for slot in slots if (frozen := _known(slot, held)) is not None]
            point, found = suggest(self.declaration, held.number, history, self.refusal)
            system = {**found, "fixed_params": dict(point)}
        trial = held.begin(system)
        point = ask_all(trial, self.declaration.space)
        held.note(POINT, point)
        return trial, [*self.declaration.base, *overrides_of(point)]

    def why_pruned(self, held: HeldTrial, step: int) -> str:
        complete = [slot.trial for slot in held.queue.look() if slot.state == "complete" and slot.trial]
        median = statistics.median(trial.intermediate_values[step] for trial in complete)
        return f"below {median:z.4f}, the median of the complete trials after as many seeds"

    def refusal(self, point: Point) -> InputError | None:
        """Why a point cannot be played: values that exclude each other, say."""
        try:
            build_parts(self.settings([*self.declaration.base, *overrides_of(point)]))
        except InputError as error:
            return error
        return None


class HeldOutJob(Job):
    """The best, the searcher's defaults and what else was asked for, on seeds that the sweep never saw."""

    def __init__(self, declaration: Declaration, best: Point) -> None:
        held_out = declaration.held_out
        self.declaration, self.best = declaration, best
        self.seeds = held_out.seeds
        base = declaration.base_with(held_out.budget)
        self.overrides: Mapping[str, list[str]] = {
            "best": [*base, *overrides_of(best)],
            "defaults": base,
            **{name: [*base, *overrides] for name, overrides in held_out.against.items()},
        }
        self.names, self.count = list(self.overrides), len(self.overrides)
        text = json.dumps([self.overrides, list(self.seeds)], sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:8]
        # another best, after more trials, is another comparison
        self.name = f"{declaration.study} held out {digest}"
        self.folder = declaration.folder / "held_out" / digest

    def fixed(self) -> dict[str, Any]:
        return {"settings": dict(self.overrides), "seeds": format_seeds(self.seeds)}

    def path(self, number: int) -> Path:
        return self.folder / self.names[number]

    def begin(self, held: HeldTrial) -> tuple[Trial, list[str]]:
        name = self.names[held.number]
        held.note("settings", name)
        return held.begin({}), self.overrides[name]


def _known(slot: Slot, held: HeldTrial) -> FrozenTrial | None:
    """The trial of a slot that a sampler may learn from; running trials tell it where not to look."""
    trial = slot.trial
    if trial is None or slot.number == held.number or not trial.params:
        return None
    if slot.state not in ("complete", "pruned", "running"):
        return None
    running = trial.state == TrialState.RUNNING
    return create_trial(
        state=trial.state,
        value=None if running else trial.value,
        params=trial.params,
        distributions=trial.distributions,
        intermediate_values=trial.intermediate_values,
        system_attrs=trial.system_attrs,
    )


def make_pruner(pruner: Pruner) -> BasePruner:
    """Optuna's pruner of that name; seeds are its steps, from 0."""
    if pruner.name == "median":
        return optuna.pruners.MedianPruner(n_startup_trials=pruner.startup, n_warmup_steps=pruner.warmup - 1)
    return optuna.pruners.NopPruner()


def best_slot(slots: Sequence[Slot]) -> Slot | None:
    """The trial with the highest mean return over all seeds, the first among equals."""
    complete = [slot for slot in slots if slot.state == "complete" and slot.trial is not None]
    return max(complete, key=lambda slot: (_value(slot), -slot.number), default=None)


def point_of(slot: Slot) -> dict[str, Any]:
    """A slot's parameters and their values."""
    return {} if slot.trial is None else dict(slot.trial.user_attrs.get(POINT, {}))


def returns_of(slot: Slot) -> list[float]:
    """The return of each seed that was played there."""
    return [] if slot.trial is None else list(slot.trial.user_attrs.get(RETURNS, []))


def mean_of(returns: Sequence[float]) -> float:
    return statistics.fmean(returns)


def _value(slot: Slot) -> float:
    assert slot.trial is not None
    assert slot.trial.value is not None
    return slot.trial.value


def check_comparison(declaration: Declaration) -> None:
    """Compose and build what the best is to be compared with; raises InputError."""
    for overrides in declaration.held_out.against.values():
        build_parts(declaration.compose([*declaration.base, *overrides]))


def check_space(declaration: Declaration) -> None:
    """Compose and build the ends of all ranges and all choices, before anything is played.

    Raises
    ------
    InputError
        If the task or the searcher cannot be played, or a value of a parameter cannot.
    """
    refusal = SearchJob(declaration).refusal
    base = declaration.compose(declaration.base)
    build_parts(base)
    known = sorted({*flatten(base.config), *groups()})
    for parameter in declaration.space:
        if parameter.name not in known and not parameter.name.startswith("+"):
            expected = f"there is no such setting of this task and searcher{nearest(parameter.name, known)}"
            raise InputError(f"space.{parameter.name}", parameter.plain(), expected)
    seen = set()
    for point in diagonals(declaration.space):
        if refusal(point) is None:
            seen |= {(name, repr(value)) for name, value in point.items()}
    for parameter, value, points in corners(declaration.space):
        if (parameter.name, repr(value)) in seen:
            continue
        refusals: list[InputError] = []
        for point in points:
            if (found := refusal(point)) is None:
                break
            refusals.append(found)
        else:
            raise InputError(f"space.{parameter.name}", value, f"cannot be played: {refusals[0]}")
