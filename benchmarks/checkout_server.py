"""One side of :mod:`benchmarks.checkouts`: searches on demand, in the checkout that ``PYTHONPATH`` names.

It imports nothing of ``benchmarks``: the file of one checkout runs with the package of another.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from origami_lab.config import build_parts, compose_settings
from origami_lab.jit import kernel
from origami_lab.search.problem import Outcome, Problem


@kernel
def calibration(n: int) -> float:
    """A fixed piece of floating-point and memory work."""
    table = np.empty(4096)
    total = 0.0
    for i in range(n):
        x = 0.5 + (i % 977) * 1e-3
        table[i & 4095] = np.sqrt(x) + x * x
        total += table[(i * 31) & 4095]
    return total


def digest(outcome: Outcome) -> str:
    """The same for two searches that came to the same design by the same improvements."""
    curve = [(each.interaction, each.value.hex(), each.angle, each.actions) for each in outcome.improvements]
    counts = outcome.interactions, outcome.episodes, outcome.rejected, outcome.places_evaluated
    return hashlib.sha256(repr((curve, counts)).encode()).hexdigest()[:16]


def answer(order: dict[str, Any]) -> dict[str, Any]:
    """Run what is ordered; processor seconds, and what came out."""
    if not order["overrides"]:
        start = time.process_time()
        calibration(20_000_000)
        return {"seconds": time.process_time() - start, "digest": ""}
    parts = build_parts(compose_settings(order["overrides"]))
    problem = Problem(parts.game, parts.objective, order["interactions"])
    # samples and trees are made before the clock starts
    problem.evaluator.bound(parts.game.new_states(1), problem.evaluator.new_memos(1), 0)
    searcher = parts.searcher
    start = time.process_time()
    searcher.search(problem, np.random.default_rng(order["seed"]))
    return {"seconds": time.process_time() - start, "digest": digest(problem.outcome())}


def main() -> None:
    for line in sys.stdin:
        print(json.dumps(answer(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
