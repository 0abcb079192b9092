"""What a trial's files cost: ``python -m benchmarks.trial_files BEFORE AFTER [--rounds 3] [--out FILE]``.

Whole commands of two checkouts in turns: one trial and eight, with all files and with ``files=designs``. What those
differ by is the certificate, the motion, the pictures and the viewer; processor time of all processes, medians over
rounds.

    git worktree add --detach ../before HEAD~1
    python -m benchmarks.trial_files ../before .
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks import write_report

BUDGETS = (3_000, 500_000)
"""Interactions of a trial: of few come designs of some 40 panels, of many such of 150."""
MORE = 8


def seconds(checkout: Path, trials: int, budget: int, files: str) -> tuple[float, float]:
    """Processor time and time by the clock of one command, with one worker."""
    begun, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as place:
        settings = [f"seed=0..{trials - 1}", f"budget={budget}", f"files={files}", f"output={place}/run"]
        subprocess.run(
            [
                sys.executable,
                "-m",
                "origami_lab",
                "target=bowl",
                "search=bfts",
                "workers=1",
                "tracking=none",
                *settings,
            ],
            env={**os.environ, "PYTHONPATH": str(checkout)},
            cwd=place,
            check=True,
            capture_output=True,
        )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.perf_counter() - begun


def cost(checkout: Path, budget: int) -> tuple[float, float, float]:
    """Processor time of each further trial's files, that of the first one's, and seconds of the whole command."""
    alone, several = (
        {files: seconds(checkout, trials, budget, files) for files in ("all", "designs")} for trials in (1, MORE)
    )
    first = alone["all"][0] - alone["designs"][0]
    return (several["all"][0] - several["designs"][0] - first) / (MORE - 1), first, several["all"][1]


def main() -> None:
    """Measure and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    sides = {"before": options.before.absolute(), "after": options.after.absolute()}
    load = os.getloadavg()[0]
    rows = []
    for checkout in sides.values():  # kernels are compiled and loaded once
        seconds(checkout, 1, BUDGETS[0], "all")
    for budget in BUDGETS:
        found: dict[str, list[tuple[float, float, float]]] = {name: [] for name in sides}
        for turn in range(options.rounds):
            for name in sorted(sides, reverse=turn % 2 == 0):
                found[name].append(cost(sides[name], budget))
        medians = [[statistics.median(column) for column in zip(*found[name], strict=True)] for name in sides]
        cells = [f"{one:.2f} | {other:.2f} | {one / other:.2f}" for one, other in zip(*medians, strict=True)]
        rows.append(f"| {budget:,} | {' | '.join(cells)} |")
    head = "interactions | each, before, s | after | factor | the first, before, s | after | factor"
    head += f" | {MORE} trials by the clock, before, s | after | factor"
    text = f"""# The files of a trial

Certificate, motion, pictures and viewer of trials of bfts on the bowl, one worker: processor time of whole commands
with `files=all` beyond that with `files=designs`, of each further trial and of the first one; medians of
{options.rounds} rounds in turns. Load average before: {load:.2f}.

| {head} |
|{"---:|" * 10}
""" + "\n".join(rows)
    write_report(text.splitlines(), options.out)
    print(text)


if __name__ == "__main__":
    main()
