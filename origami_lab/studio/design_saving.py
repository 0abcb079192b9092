"""A design of the studio as a run folder, which all other commands take as they take any other run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from origami_lab.config.instantiate import Parts
from origami_lab.config.settings import Settings
from origami_lab.experiment.run_summary import summarise
from origami_lab.experiment.staged_search import Searched
from origami_lab.experiment.trial import write_trial
from origami_lab.file_names import HISTORY
from origami_lab.game.game import Game
from origami_lab.runs.locks import locked
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import BY_ITSELF, OK
from origami_lab.search.problem import Improvement, Outcome
from origami_lab.studio.by_hand import METHOD, NODE, DesignedByHand

SEED = 0
"""The one trial of a design's run folder."""


@dataclass(frozen=True)
class ToSave:
    """A design with how it came about."""

    path: Path
    actions: tuple[int, ...]
    value: float
    angle: int
    interactions: int
    """Actions that were played, by hand and by partners."""
    seconds: float
    history: Sequence[Mapping[str, Any]]
    """What was done, in order."""


def save_design(settings: Settings, game: Game, objective: Any, target: Any, design: ToSave) -> list[str]:
    """Write a run folder with one trial, or that trial again; returns warnings.

    Raises
    ------
    OSError, FolderError
        If the folder cannot be written.
    """
    settings = _as_saved(settings, design)
    parts = Parts(game, target, objective, DesignedByHand())
    improvement = Improvement(design.interactions, design.value, design.angle, design.actions)
    outcome = Outcome(
        value=design.value,
        angle=design.angle,
        actions=design.actions,
        interactions=design.interactions,
        interactions_to_best=design.interactions,
        improvements=(improvement,),
        succeeded=True,
        episodes=1,
        rejected=0,
    )
    searched = Searched(outcome, parts, design.seconds, OK, BY_ITSELF, None, (), [])
    design.path.mkdir(parents=True, exist_ok=True)
    with locked(design.path):
        folder = RunFolder(design.path)
        folder.clear_leftovers()
        if not folder.has_begun:
            folder.begin(settings.config, target, parts.start_to_keep(settings))
        _, warnings = write_trial(settings, SEED, folder, searched, keep_state=False)
        with folder.more_of_trial(SEED, HISTORY.partition(".")[0]) as path:
            (path / HISTORY).write_text(json.dumps(list(design.history), indent=1) + "\n", encoding="utf-8")
        rows = folder.rows()
        folder.write_trials(rows.values())
        command = ("origami-lab", METHOD, str(design.path))
        folder.write_summary(summarise(settings, rows, command, design.seconds, interrupted=False))
    return warnings


def _as_saved(settings: Settings, design: ToSave) -> Settings:
    """The settings of the run that the design is saved as: a person is its searcher."""
    budget = max(design.interactions, 1)
    config = {
        **settings.config,
        "method": METHOD,
        "search": dict(NODE),
        "report_order": {**settings.config["report_order"], "method": None},
        "budget": budget,
        "seed": str(SEED),
        "stages": [],
        "polish": None,
        "target_return": None,
        "minutes": None,
        "files": "all",
        "output": None,
        "resume": False,
    }
    return replace(
        settings,
        method=METHOD,
        search=dict(NODE),
        seeds=(SEED,),
        budget=budget,
        stages=(),
        polish=None,
        target_return=None,
        minutes=None,
        files="all",
        config=config,
    )
