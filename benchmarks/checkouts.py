"""Two checkouts against each other: ``python -m benchmarks.checkouts BEFORE AFTER [--rounds 9] [--out FILE]``.

Each checkout has one process that stays, both on one core, and the same searches are run by each in turn (A B, then
B A), so that what else the machine does falls on both. Figures are processor time; medians over rounds, each with a
seed of its own. A pair is *same* if all its searches came to the same designs by the same improvements, with the same
counts.

    git worktree add --detach ../before HEAD~1
    python -m benchmarks.checkouts ../before .
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from benchmarks import write_report


class Case(NamedTuple):
    """A search: who searches for what, measured how, how long."""

    searcher: str
    target: str
    distance: str
    interactions: int

    @property
    def name(self) -> str:
        return "-".join([self.searcher, self.target, *([] if self.distance == "vertex" else [self.distance])])

    @property
    def overrides(self) -> list[str]:
        return [f"search={self.searcher}", f"target={self.target}", f"objective.distance={self.distance}"]


CASES = (
    Case("rdm", "bowl", "vertex", 200_000),
    Case("dfts", "bowl", "vertex", 100_000),
    Case("bfts", "bowl", "vertex", 60_000),
    Case("mcts", "bowl", "vertex", 60_000),
    Case("evo", "bowl", "vertex", 100_000),
    Case("lns", "bowl", "vertex", 40_000),
    Case("rdm", "face", "vertex", 100_000),
    Case("bfts", "face", "vertex", 30_000),
    Case("evo", "face", "vertex", 60_000),
    Case("bfts", "bowl", "sampled", 20_000),
    Case("evo", "bowl", "sampled", 20_000),
    Case("rdm", "cube", "vertex", 100_000),
    Case("bfts", "cube", "vertex", 40_000),
)


class Side:
    """A checkout and its process."""

    def __init__(self, checkout: Path, core: int) -> None:
        server = Path(__file__).with_name("checkout_server.py")
        self._process = subprocess.Popen(
            [sys.executable, str(server)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=checkout,
            env=os.environ | {"PYTHONPATH": str(checkout)},
        )
        os.sched_setaffinity(self._process.pid, {core})

    def run(self, overrides: list[str], interactions: int = 0, seed: int = 0) -> tuple[float, str]:
        """Seconds of processor time of one search, and the digest of its outcome; nothing to search: calibration."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        order = {"overrides": overrides, "interactions": interactions, "seed": seed}
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        found = json.loads(self._process.stdout.readline())
        return float(found["seconds"]), str(found["digest"])

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def pair(before: Side, after: Side, case: Case, rounds: int) -> str:
    """A row of the table: one case, in turns."""
    sides = (before, after)
    for side in sides:
        side.run(case.overrides, 2_000)  # compiles
    seconds: tuple[list[float], list[float]] = ([], [])
    digests: tuple[list[str], list[str]] = ([], [])
    for seed in range(rounds):
        for i in (0, 1) if seed % 2 == 0 else (1, 0):
            taken, digest = sides[i].run(case.overrides, case.interactions, seed)
            seconds[i].append(taken)
            digests[i].append(digest)
    ratios = sorted(a / b for a, b in zip(*seconds, strict=True))
    rates = [case.interactions / statistics.median(each) for each in seconds]
    same = sum(a == b for a, b in zip(*digests, strict=True))
    return (
        f"| {case.name} | {rates[0]:,.0f} | {rates[1]:,.0f} | {statistics.median(ratios):.2f} "
        f"| {ratios[0]:.2f} to {ratios[-1]:.2f} | {same} of {rounds} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)), help="that both run on")
    parser.add_argument("--only", default="", help="names of cases, comma-separated: rdm-bowl,bfts-bowl-sampled")
    parser.add_argument("--scale", type=float, default=1.0, help="of the lengths of the searches")
    parser.add_argument("--out", type=Path, help="write the report there, too")
    options = parser.parse_args()
    names = options.only.split(",") if options.only else [case.name for case in CASES]
    load = os.getloadavg()[0]
    before, after = (Side(path.resolve(), options.core) for path in (options.before, options.after))
    try:
        before.run([])
        calibrated = statistics.median(before.run([])[0] for _ in range(5))
        lines = [
            "# Checkouts",
            "",
            f"{options.rounds} rounds in turns on one core of {os.cpu_count()}, processor time, medians. Load average "
            f"before: {load:.2f}. Calibration kernel: {calibrated:.3f} s.",
            "",
            "| search | before, interactions/s | after | factor | least to most | same designs |",
            "|---|---:|---:|---:|---:|---:|",
        ]
        print("\n".join(lines), flush=True)
        for case in CASES:
            if case.name in names:
                scaled = case._replace(interactions=int(case.interactions * options.scale))
                lines.append(pair(before, after, scaled, options.rounds))
                print(lines[-1], flush=True)
        lines += ["", f"Load average after: {os.getloadavg()[0]:.2f}."]
        print(lines[-1])
        write_report(lines, options.out)
    finally:
        before.close()
        after.close()


if __name__ == "__main__":
    main()
