"""What many runs cost: ``python -m benchmarks.scaling [--budget 500000] [--rounds 3] [--out benchmarks/scaling.md]``

Runs of the command in processes of their own. Throughputs are compared in turns in one run, because machines are noisy.
What a trial costs beside its search, and what tracking costs, are processor seconds of whole process trees, found as
differences: of few and many trials, of short and long ones. The estimate for a cluster is arithmetic on these figures.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks import write_report
from benchmarks.runs import ROOT
from origami_lab.machine import usable_cores
from origami_lab.runs.trial_row import read_trials
from origami_lab.tracking.store import open_client

TASK = ("target=bowl", "search=bfts", "verbosity=quiet")
SHORT = 20_000
"""Interactions of a trial that is mostly overhead."""
FEW = 1000
"""Interactions of each of very many trials."""
CORES = 1000


@dataclass(frozen=True)
class Spent:
    """What a command took."""

    wall: float
    processor: float
    """Seconds of all its processes."""
    interactions: int = 0
    searching: float = 0.0
    """Seconds of the trials' searches, by their own clocks."""

    @property
    def rate(self) -> float:
        """Interactions per second of the whole command."""
        return self.interactions / self.wall

    @property
    def search_rate(self) -> float:
        """Interactions per second of a trial's search."""
        return self.interactions / self.searching


def spend(command: Sequence[str], place: Path, text: str = "") -> Spent:
    """Run a command of Python's to its end."""
    began = time.perf_counter()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, *command], cwd=place, env=environment, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
    )
    assert process.stdin is not None
    process.stdin.write(text.encode())
    process.stdin.flush()
    _, status, usage = os.wait4(process.pid, 0)  # of its children, too, that it has waited for
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}")
    return Spent(time.perf_counter() - began, usage.ru_utime + usage.ru_stime)


def experiment(place: Path, name: str, trials: int, budget: int, *arguments: str) -> Spent:
    """Run the command; what it did is in place/name."""
    command = ["-m", "origami_lab", *TASK, f"seed=0..{trials - 1}", f"budget={budget}", f"output={name}", *arguments]
    spent = spend(command, place)
    rows = read_trials(place / name / "trials.csv")
    assert [row.status for row in rows] == ["ok"] * trials, rows
    interactions = sum(row.interactions or 0 for row in rows)
    return Spent(spent.wall, spent.processor, interactions, sum(row.seconds or 0.0 for row in rows))


def push(place: Path, name: str) -> Spent:
    """Bring a store up to date with a run folder, as the run's own tracking process does."""
    store = place / f"{name}.db"
    open_client(f"sqlite:///{store}")
    return spend(["-m", "origami_lab.tracking.push_process", name, f"sqlite:///{store}"], place, "end\n")


def middle(values: Sequence[float]) -> str:
    """The median, and the range in brackets."""
    low, high = min(values), max(values)
    return f"{statistics.median(values):,.2f} ({low:,.2f} to {high:,.2f})"


def throughput(place: Path, budget: int, rounds: int) -> list[str]:
    """Interactions per second of one worker and of two, in turns."""
    found: dict[int, list[Spent]] = {1: [], 2: []}
    for turn in range(rounds):
        for workers in (1, 2) if turn % 2 == 0 else (2, 1):
            name = f"workers-{turn}-{workers}"
            found[workers].append(experiment(place, name, 4, budget, f"workers={workers}", "tracking=none"))
    ratio = [two.rate / one.rate for one, two in zip(found[1], found[2], strict=True)]
    own = [two.search_rate / one.search_rate for one, two in zip(found[1], found[2], strict=True)]
    lines = ["", f"## One worker and two: four trials of {budget:,} interactions", ""]
    lines += ["| | one worker | two workers | ratio |", "|---|---|---|---|"]
    rates = [statistics.median(spent.rate for spent in found[workers]) for workers in (1, 2)]
    lines.append(f"| the whole command, interactions/s | {rates[0]:,.0f} | {rates[1]:,.0f} | {middle(ratio)} |")
    rates = [statistics.median(spent.search_rate for spent in found[workers]) for workers in (1, 2)]
    lines.append(f"| the search of a trial, interactions/s | {rates[0]:,.0f} | {rates[1]:,.0f} | {middle(own)} |")
    return lines


@dataclass(frozen=True)
class Overhead:
    """Processor seconds beside the search."""

    command: float
    trial: float
    search: float
    """Of 500,000 interactions."""
    files: int
    size: int
    """Bytes of a trial's folder."""


def overhead(place: Path, budget: int, rounds: int) -> tuple[Overhead, list[str]]:
    """What a command and a trial cost beside the search, by few and many short trials."""
    spent: dict[str, list[float]] = {"one": [], "nine": [], "long": []}
    for turn in range(rounds):
        for kind, trials, interactions in (("one", 1, SHORT), ("nine", 9, SHORT), ("long", 1, budget)):
            done = experiment(place, f"{kind}-{turn}", trials, interactions, "workers=1", "tracking=none")
            spent[kind].append(done.processor)
    one, nine, long = (statistics.median(spent[kind]) for kind in ("one", "nine", "long"))
    interaction = (long - one) / (budget - SHORT)
    trial = (nine - one) / 8 - SHORT * interaction
    files = list((place / "long-0/seed=0").iterdir())
    size = sum(file.stat().st_size for file in files)
    found = Overhead(one - trial - SHORT * interaction, trial, 500_000 * interaction, len(files), size)
    lines = ["", "## Beside the search", "", "| processor seconds | |", "|---|---|"]
    lines += [
        f"| a command: starting, importing, loading kernels, reading its input | {found.command:.2f} |",
        f"| a trial: {found.files} files ({size / 1e6:.2f} MB), three of them pictures | {trial:.2f} |",
        f"| the search of a trial of 500,000 interactions | {found.search:.2f} |",
    ]
    return found, lines


@dataclass(frozen=True)
class Tracking:
    """Processor seconds of the process that writes to MLflow."""

    command: float
    trial: float
    interaction: float


def tracking(place: Path, budget: int, rounds: int, search: float) -> tuple[Tracking, list[str]]:
    """What tracking costs, by pushing finished run folders; and whether a search that runs beside it is slower."""
    experiment(place, "nine-long", 9, budget, "tracking=none")
    names = {"one": "one-0", "nine": "nine-0", "long": "nine-long"}
    spent: dict[str, list[float]] = {kind: [] for kind in names}
    for turn in range(max(rounds, 3)):
        for kind, name in names.items():
            copy = f"push-{kind}-{turn}"
            shutil.copytree(place / name, place / copy)
            spent[kind].append(push(place, copy).processor)
    one, nine = (statistics.median(spent[kind]) for kind in ("one", "nine"))
    trial = (nine - one) / 8
    slopes = [(long - short) / 9 / (budget - SHORT) for long, short in zip(spent["long"], spent["nine"], strict=True)]
    slope = statistics.median(slopes)
    found = Tracking(one - trial, trial, slope)
    pairs = []
    for turn in range(rounds):
        store = f"tracking.uri=sqlite:///{place}/live.db"
        kinds = [("mlflow", ("tracking=mlflow", store)), ("none", ("tracking=none",))]
        rates = {}
        for kind, arguments in kinds if turn % 2 == 0 else kinds[::-1]:
            rates[kind] = experiment(place, f"{kind}-{turn}", 2, budget, "workers=1", *arguments)
        with_it, without = rates["mlflow"], rates["none"]
        pairs.append((with_it.search_rate / without.search_rate, with_it.wall - without.wall))
    share = f"{slope * 500_000 / search:.2%}" if min(slopes) > 0 else "not distinguishable from 0"
    lines = ["", "## Tracking", ""]
    lines += ["| processor seconds of its process | | of a search of 500,000 interactions |", "|---|---|---|"]
    lines += [
        f"| a command: importing MLflow, the parent run | {found.command:.2f} | {found.command / search:.1%}, once |",
        f"| a trial: its run, metrics, curve and files | {trial:.3f} | {trial / search:.2%} |",
        f"| an interaction more, in nanoseconds | {middle([1e9 * each for each in slopes])} | {share} |",
    ]
    rate, wall = (middle([pair[which] for pair in pairs]) for which in (0, 1))
    text = f"Two trials with tracking against without, in turns: search rate {rate} times, wall time {wall} s longer."
    return found, [*lines, "", text]


def many(place: Path, trials: int, part: int = 100) -> list[str]:
    """Whether the last of many short trials take longer than the first, with and without tracking."""
    lines = ["", f"## {trials:,} trials of {FEW:,} interactions, two workers", ""]
    lines += [
        f"| tracking | whole command, s | the second {part}, s | the last {part}, s | last to second |",
        "|---|---|---|---|---|",
    ]
    for kind in ("none", f"mlflow tracking.uri=sqlite:///{place}/many.db"):
        name = f"many-{kind.split()[0]}"
        words = ("workers=2", "files=designs", *f"tracking={kind}".split())
        spent = experiment(place, name, trials, FEW, *words)
        ended = sorted(file.stat().st_mtime for file in (place / name).glob("seed=*/best.fold"))
        second, last = ended[2 * part - 1] - ended[part - 1], ended[-1] - ended[-part - 1]
        lines.append(f"| {kind.split()[0]} | {spent.wall:.1f} | {second:.2f} | {last:.2f} | {last / second:.2f} |")
    lines += [
        "",
        "Crease patterns only (`files=designs`): what is measured is what grows, tables, page and records of the run.",
    ]
    return lines


def estimate(own: Overhead, tracked: Tracking) -> list[str]:
    """What a thousand cores would do, on paper."""
    trial = own.search + own.trial
    rate = CORES / trial
    busy, day = rate * tracked.trial, rate * 86_400
    texts = [
        f"Trials share nothing but the file system and the tracking store: {CORES:,} such cores play",
        f"{rate * 500_000 / 1e6:,.1f} million interactions a second, which is {rate:,.1f} trials of 500,000 a second,",
        f"{day:,.0f} a day with {day * own.files / 1e6:,.1f} million files and {day * own.size / 1e12:,.2f} TB.",
        f"Writing to MLflow takes {tracked.trial:.3f} processor seconds a trial, {tracked.trial / trial:.1%} of it;",
        f"if a server needed as much for it, that were {busy:,.1f} of its cores.",
    ]
    if busy > 1:
        texts += [
            f"One SQLite file takes one writer at a time: beyond {CORES / busy:,.0f} cores of such short trials it is",
            "the limit. Then: a server on PostgreSQL with several workers, longer trials, or `tracking=none` and",
            "`origami-lab dashboard --sync` afterwards.",
        ]
    return ["", f"## On paper: {CORES:,} cores", "", *texts]


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure what many runs cost.")
    parser.add_argument("--budget", type=int, default=500_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--trials", type=int, default=1000, help="very many")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        experiment(place, "warm", 1, SHORT, "workers=1", f"tracking.uri=sqlite:///{place}/live.db")
        lines = ["# What many runs cost", ""]
        lines.append(f"`{' '.join(TASK[:2])}`, {options.rounds} rounds on {usable_cores()} cores, load average before:")
        lines.append(f"{os.getloadavg()[0]:.2f}. Medians, with ranges in brackets; ratios are of runs in turns.")
        lines += throughput(place, options.budget, options.rounds)
        own, more = overhead(place, options.budget, options.rounds)
        tracked, last = tracking(place, options.budget, options.rounds, own.search)
        lines += more + last + many(place, options.trials) + estimate(own, tracked)
    print("\n".join(lines))
    write_report(lines, options.out)


if __name__ == "__main__":
    main()
