"""What each optimisation is worth: ``python -m benchmarks.pairs [--out benchmarks/pairs.md]``.

Both ways are measured in turns in this run, and the fastest of several rounds counts: so the ratio holds on a busy
machine, too. "Before" is the plain way, kept alive as a test's oracle or written out here.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from benchmarks import write_report
from benchmarks.speed import bowl_game
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from origami_lab.search.problem import Problem, Searcher
from origami_lab.targets.solids import bowl
from tests.search.reference import ReferenceTreeSearch

Work = Callable[[], object]


def paired(before: Work, after: Work, rounds: int = 9, clock: Callable[[], float] = time.process_time) -> list[float]:
    """Seconds of the fastest call of each, called in turns."""
    best = [np.inf, np.inf]
    for work in (before, after):
        work()  # compiles
    for _ in range(rounds):
        for i, work in enumerate((before, after)):
            start = clock()
            work()
            best[i] = min(best[i], clock() - start)
    return best


def search(searcher: Searcher, interactions: int) -> None:
    searcher.search(Problem(bowl_game(), ShapeObjective(bowl()), interactions), np.random.default_rng(3))


def start(*modules: str) -> None:
    subprocess.run([sys.executable, "-c", f"import {', '.join(modules)}"], check=True)


def children_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="write the report there, too")
    options = parser.parse_args()

    n = 20_000
    imported = (
        *("origami_lab.experiment.trial_worker", "origami_lab.search.branch_and_bound"),
        "origami_lab.objectives.shape",
    )
    pairs = {
        f"dfts, {n:,} interactions: positions copied, steps in Python → taken back, in compiled code": paired(
            partial(search, ReferenceTreeSearch(best_first=False), n), partial(search, DepthFirstSearch(restarts=1), n)
        ),
        f"bfts, {n:,} interactions: the same": paired(
            partial(search, ReferenceTreeSearch(best_first=True), n), partial(search, BreadthFirstSearch(restarts=1), n)
        ),
        "imports of a worker: with scipy.spatial → without": paired(
            partial(start, *imported, "scipy.spatial"), partial(start, *imported), clock=children_time
        ),
    }
    lines = [
        "# Pairs",
        "",
        f"Processor time; each pair in turns in one run. Load average before: {os.getloadavg()[0]:.2f}.",
        "",
        "| what | before, ms | after, ms | ratio |",
        "|---|---:|---:|---:|",
        *(f"| {name} | {a * 1e3:.1f} | {b * 1e3:.1f} | {a / b:.2f} |" for name, (a, b) in pairs.items()),
        "",
    ]
    print("\n".join(lines))
    write_report(lines, options.out)


if __name__ == "__main__":
    main()
