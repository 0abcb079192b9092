"""Whole searches with small budgets, as JSON: run with and without the compiler by test_without_the_compiler.py.

The seeds are some on which no two returns that decide are closer than 1e-9: there the compiler, which may fuse
operations, decides as plain Python does.
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import build_parts
from origami_lab.game.observation import view_of
from origami_lab.objectives import shape
from origami_lab.objectives.objective import report
from origami_lab.search import Episodes, Problem, SearchEnded

FEW = 300
"""Samples of a target: plain Python measures some thousand distances a second."""
SEARCHES = (
    *(f"target=pyramid search={name} budget=50" for name in ("rdm", "dfts", "bfts", "mcts", "evo")),
    "target=pyramid search=lns budget=15",
    "target=cube search=rdm budget=20",
    "target=pyramid search=rdm budget=10 objective.distance=surface +objective.tolerance=0.5",
    f"target=bowl search=rdm budget=30 objective.distance=sampled +objective.samples={FEW}",
    "target=pyramid search=rdm budget=30 symmetry=x objective.compactness=0.1",
    "objective=bucket search=evo budget=40 symmetry=xyd",
    "objective=shelf search=mcts budget=40 symmetry=xy",
    "objective=table search=rdm budget=60 max_crease_length=2.9 source_action=false",
    "objective=chair search=rdm budget=8",
    "objective=packaging search=dfts budget=40 symmetry=xyd",
    "objective=packaging search=mcts budget=40 objective.compactness=0.1",
    "objective=packaging search=lns budget=60",
)


def played(overrides: Sequence[str]) -> dict[str, Any]:
    """The improvements of a search, and what its objective reports of the best design."""
    settings = compose_settings([*overrides, "tracking=none"])
    parts = build_parts(settings)
    problem = Problem(parts.game, parts.objective, settings.budget)
    with suppress(SearchEnded):
        parts.searcher.search(
            problem, np.random.default_rng(3 if "target" in overrides[0] else np.random.SeedSequence(0))
        )
    found = problem.outcome()
    return {
        "actions": [[step.interaction, step.angle, *map(int, step.actions)] for step in found.improvements],
        "counts": [found.interactions, found.episodes, found.rejected, found.places_evaluated],
        "returns": [step.value for step in found.improvements],
        "report": report(parts.objective, parts.game, found.actions, found.angle)
        if "chair" not in overrides[0]
        else {},
    }


def shaped() -> dict[str, Any]:
    """Rewards and observations of an agent's episodes."""
    parts = build_parts(compose_settings(["target=pyramid", "search=rdm", "tracking=none"]))
    problem = Problem(parts.game, parts.objective, 10**6)
    episodes, rng = Episodes(problem, 1, view_of(parts.game)), np.random.default_rng(3)
    episodes.reset(0)
    actions, rewards = [], []
    for _ in range(12):
        action = int(rng.choice(np.flatnonzero(episodes.masks[0])))
        reward, over = episodes.step(0, action)
        actions.append([action, bool(over)])
        rewards.append(float(reward))
        if over:
            episodes.reset(0)
    return {"actions": actions, "returns": rewards}


def main() -> None:
    if os.environ.get("NUMBA_DISABLE_JIT") == "1":
        warnings.simplefilter("error", RuntimeWarning)  # a kernel's integers are wider than numpy's scalars
    shape.TARGET_SAMPLES = FEW
    results = {words: played(words.split()) for words in SEARCHES} | {"episodes": shaped()}
    Path(sys.argv[1]).write_text(json.dumps(results), encoding="utf-8")


if __name__ == "__main__":
    main()
