"""How fast does PPO learn? ``python -m benchmarks.ppo [--updates 8] [--out benchmarks/ppo.md]``

Interactions per second with updates, on one core, compact against tensor; and how fast the environment alone is. Wall
and processor time stand beside each other: where they differ something else was running.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import torch

from benchmarks import write_report
from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.game.observation import view_of
from origami_lab.search.ppo import ProximalPolicyOptimization
from origami_lab.search.problem import Problem
from origami_lab.search.rl_episodes import Episodes

TARGETS = ("pyramid", "cube", "bowl", "face")
CASES: tuple[tuple[str, str, int | None], ...] = (
    ("pyramid", "compact", None),
    ("pyramid", "tensor", None),
    ("cube", "compact", None),
    ("bowl", "compact", None),
    ("bowl", "tensor", 25),
    ("face", "compact", None),
)
"""Task, observation, cap on the tensor's vertex axis."""


def parts_of(target: str) -> Parts:
    return build_parts(compose_settings([f"target={target}", "search=rdm"]))


def training(target: str, observation: str, vertices: int | None, updates: int) -> str:
    """One row: a search of that many batches, each followed by an update but the last."""
    parts = parts_of(target)
    searcher = ProximalPolicyOptimization(observation, vertices)
    budget = updates * searcher.batch + 1  # the update after the last batch included
    problem = Problem(parts.game, parts.objective, budget)
    wall, busy = time.perf_counter(), time.process_time()
    searcher.search(problem, np.random.default_rng(0))
    wall, busy = time.perf_counter() - wall, time.process_time() - busy
    shape = view_of(parts.game, observation, vertices).shape
    return (
        f"| {target} | {observation} | {' × '.join(map(str, shape))} | {np.prod(shape):,} | {budget:,} "
        f"| {budget / wall:,.0f} | {budget / busy:,.0f} |"
    )


def playing(target: str, observation: str, vertices: int | None, interactions: int) -> str:
    """One row: uniformly random play through the episodes, without a network."""
    parts = parts_of(target)
    problem = Problem(parts.game, parts.objective, 10**9, certify=False)
    episodes = Episodes(problem, 1, view_of(parts.game, observation, vertices))
    rng = np.random.default_rng(0)
    wall, busy = time.perf_counter(), time.process_time()
    while problem.interactions < interactions:
        episodes.reset(0)
        while not episodes.step(0, int(rng.choice(np.flatnonzero(episodes.masks[0]))))[1]:
            pass
    wall, busy = time.perf_counter() - wall, time.process_time() - busy
    return f"| {target} | {observation} | {interactions / wall:,.0f} | {interactions / busy:,.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--updates", type=int, default=8, help="in each search")
    parser.add_argument("--out", type=Path, help="write the report there, too")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    for target in TARGETS:  # compiles what there is to compile, imports the learner
        parts = parts_of(target)
        ProximalPolicyOptimization(batch=100).search(
            Problem(parts.game, parts.objective, 200), np.random.default_rng(0)
        )
        playing(target, "tensor", 8, 200)
    lines = [
        "# PPO",
        "",
        f"Python {platform.python_version()}, PyTorch {torch.__version__}, one thread of {os.cpu_count()} cores; "
        f"load average before: {load:.2f}. Per second of wall and of processor time.",
        "",
        "## Learning: the paper's numbers (batch 2050, minibatch 64, 2 × 256), 10 epochs, 10 games",
        "",
        "| task | observation | shape | numbers | interactions | per second | per processor second |",
        "|---|---|---|---:|---:|---:|---:|",
        *(training(*case, options.updates) for case in CASES),
        "",
        "## Playing alone: uniformly random, with masks, observations and rewards",
        "",
        "| task | observation | per second | per processor second |",
        "|---|---|---:|---:|",
        *(playing(*case, 10_000) for case in CASES),
    ]
    print("\n".join(lines))
    write_report(lines, options.out)


if __name__ == "__main__":
    main()
