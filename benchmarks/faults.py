"""What is kept when things go wrong? ``python -m benchmarks.faults [--out benchmarks/faults.md] [--only kills …]``

Real processes meet real faults: SIGKILL at random moments, Ctrl-C, full and vanishing disks (small tmpfs mounts, which
need root on Linux), objectives that raise, hang or crash. Each row of the report is what happened in this run.
"""

from __future__ import annotations

import argparse
import os
import platform
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from benchmarks import write_report
from benchmarks.disks import disks
from benchmarks.faulty import WAYS
from benchmarks.runs import (
    LONG,
    ROOT,
    SEEDS,
    SMALL,
    UNTRACKED,
    Lines,
    Report,
    expect,
    finished,
    problems_of,
    start,
    statuses,
    trials,
)

KILLS = 30
MEMORY = 8 * 2**30
LIMIT_SECONDS = 3
OBJECTIVE = "# @package _global_\ntask: faulty\nobjective:\n  _target_: faulty.Faulty\n  how: ???\n"
OBJECTIVE += "  where: score\n  once: ???\n"

# --- kill -9 ----------------------------------------------------------------------------------------------------------


def kills(place: Path, report: Report) -> None:
    """Kill runs at random moments, each one again and again until it ends."""
    undisturbed = start(place, [*SMALL, "output=undisturbed"])
    undisturbed.wait()
    seconds = time.monotonic() - undisturbed.began
    wanted = trials(place / "undisturbed")
    report.add("", "## kill -9", "")
    report.add(f"{SEEDS} seeds, 2 workers, tracked by MLflow; undisturbed it takes {seconds:.0f} s. The same command")
    report.add("with resume=true is given again and again, and killed each time, until it ends. Each time all that is")
    report.add("visible is read to its end.")
    report.table("run", "killed", "after s", "on disk then")
    killer = _Killer(place, report, wanted, seconds)
    while killer.killed < KILLS:
        killer.kill_until_done()


class _Killer:
    """Kills runs until there were enough."""

    def __init__(self, place: Path, report: Report, wanted: object, seconds: float) -> None:
        self.place, self.report, self.wanted, self.seconds = place, report, wanted, seconds
        self.rng = random.Random(0)
        self.number = self.killed = 0

    def kill_until_done(self) -> None:
        """Kill one run until it ends, or enough were killed."""
        folder = self.place / f"kill-{self.number}"
        kept: dict[int, int] = {}
        while True:
            run = start(self.place, [*SMALL, f"output={folder.name}", "resume=true"])
            after = self.rng.uniform(0.02, 1.0) * self.seconds if self.killed < KILLS else None
            with suppress(subprocess.TimeoutExpired):
                run.process.wait(after)
                if not kept:  # the machine may be busier or less so than it was
                    self.seconds = time.monotonic() - run.began
                break
            group = self.killed % 2 == 0
            run.kill(group)
            self.killed += 1
            now = finished(folder)
            problems = problems_of(run, folder, tidy=False) + _lost(kept, now)
            kept = now
            who = "with workers" if group else "parent alone"
            self.report.row([self.number, who, f"{after:.1f}", _contents(folder)], problems)
        problems = expect("the last exit code", run.wait(), 0) + expect("the table", trials(folder), self.wanted)
        problems += problems_of(run, folder) + _lost(kept, finished(folder))
        cells = [self.number, "no more", "–", f"{statuses(folder)}; the table of the undisturbed run"]
        self.report.row(cells, problems)
        self.number += 1


def _lost(before: dict[int, int], now: dict[int, int]) -> Lines:
    """Finished trials that are gone or were run again."""
    return expect("what is lost or ran again", [seed for seed in before if before[seed] != now.get(seed)], [])


def _contents(folder: Path) -> str:
    if not folder.exists():
        return "no folder"
    names = sorted(path.name for path in folder.iterdir())
    visible = [name for name in names if not name.startswith(".")]
    hidden = len(names) - len(visible)
    return (", ".join(visible) or "empty") + (f", {hidden} hidden" if hidden else "")


# --- Ctrl-C and other signals -----------------------------------------------------------------------------------------


def interrupts(place: Path, report: Report) -> None:
    """Ask a run to stop in every usual way."""
    report.add("", "## Ctrl-C and other signals", "")
    report.add("Sent to the whole process group, as terminals and batch systems do, while two of four long trials run.")
    report.table("signals", "exit code", "left after s", "trials.csv", "summary.json", "table printed", "MLflow runs")
    cases: dict[str, list[tuple[int, float]]] = {
        "Ctrl-C": [(signal.SIGINT, 0.0)],
        "Ctrl-C twice": [(signal.SIGINT, 1.0), (signal.SIGINT, 0.0)],
        "SIGTERM": [(signal.SIGTERM, 0.0)],
        "SIGTERM twice within a moment, as `timeout` does": [(signal.SIGTERM, 0.01), (signal.SIGTERM, 0.0)],
        "SIGTERM twice": [(signal.SIGTERM, 1.0), (signal.SIGTERM, 0.0)],
        "SIGHUP": [(signal.SIGHUP, 0.0)],
    }
    for number, (name, signals) in enumerate(cases.items()):
        _interrupt(place, report, f"signal-{number}", name, signals)


def _interrupt(place: Path, report: Report, folder: str, name: str, signals: Sequence[tuple[int, float]]) -> None:
    run = start(place, [*LONG, f"output={folder}", f"tracking.experiment={folder}"])
    run.wait_for(lambda: (place / folder / "tracking.json").exists())
    run.wait_for(lambda: "seed 1:" in run.text())
    time.sleep(3)
    for each, pause in signals:
        os.killpg(run.process.pid, each)
        time.sleep(pause)
    began = time.monotonic()
    code = run.wait()
    seconds = time.monotonic() - began
    run.wait_for(lambda: not run.alive())
    mlflow = _mlflow(place, folder)
    table = "mean" in run.text()
    at_once = "leaving at once" in run.text()
    twice = len(signals) > 1 and signals[0][1] > 0.3
    problems = problems_of(run, place / folder) + expect("the exit code", code, 130)
    problems += expect("leaving at once", at_once, twice)
    rows = trials(place / folder)
    problems += expect("trials", [row["status"] for row in rows], [] if twice else ["stopped"] * 2)
    problems += expect("RUNNING in MLflow", "RUNNING" in mlflow, False)
    summary = (place / folder / "summary.json").exists()
    problems += expect("summary.json", summary, True)
    cells = [name, code, f"{seconds:.1f}", statuses(place / folder), summary, table, mlflow]
    report.row(cells, problems)


def _mlflow(place: Path, experiment: str) -> str:
    """The statuses of an experiment's runs, the parent's first."""
    from mlflow import MlflowClient

    client = MlflowClient(f"sqlite:///{place}/results/mlflow.db")
    found = client.get_experiment_by_name(experiment)
    if found is None:
        return "none"
    runs = client.search_runs([found.experiment_id], order_by=["attributes.start_time ASC"])
    return ", ".join(f"{run.info.run_name}: {run.info.status}" for run in runs)


# --- what users bring -------------------------------------------------------------------------------------------------


def objectives(place: Path, report: Report) -> None:
    """Each bad objective spoils one of two trials."""
    report.add("", "## Objectives that misbehave", "")
    report.add(
        f"Two seeds; one bad call in the first trial, objective_seconds={LIMIT_SECONDS}, {MEMORY >> 30} GiB of memory."
    )
    report.table("the objective", "in", "exit code", "seconds", "seed 0", "seed 1")
    file = place / "conf/objective/faulty.yaml"
    file.parent.mkdir(parents=True)
    file.write_text(OBJECTIVE, encoding="utf-8")
    shutil.copy(ROOT / "benchmarks/faulty.py", place)  # what lies where the command is typed is trusted
    for number, how in enumerate(WAYS):
        _bad_objective(place, report, f"objective-{number}", how, "score")
    for number, how in enumerate(("raises", "returns None", "returns NaN", "blocks for ever in C")):
        _bad_objective(place, report, f"bound-{number}", how, "bound")


def _bad_objective(place: Path, report: Report, folder: str, how: str, where: str) -> None:
    own = [
        "--config-dir",
        str(place / "conf"),
        "objective=faulty",
        f"objective.how='{how}'",
        f"objective.where={where}",
    ]
    own += [
        f"objective.once={place / folder}.once",
        "board=9x9",
        "symmetry=xy",
        "seed=0..1",
        "budget=2000",
        "workers=1",
    ]
    own += [f"objective_seconds={LIMIT_SECONDS}", UNTRACKED, f"output={folder}"]
    own += [f"search={'dfts' if where == 'bound' else 'rdm'}"]
    run = start(place, own, partial(resource.setrlimit, resource.RLIMIT_AS, (MEMORY, MEMORY)))
    code, seconds = run.wait(), time.monotonic() - run.began
    rows = trials(place / folder)
    problems = problems_of(run, place / folder) + expect("the exit code", code, 1)
    found = [str(row["status"]) for row in rows]
    problems += expect("statuses", [status.partition(":")[0] for status in found], ["failed", "ok"])
    first, second = (*found, "", "")[:2]
    report.row([how, where, code, f"{seconds:.0f}", first, second], problems)


def searchers(place: Path, report: Report) -> None:
    """A searcher that never ends of itself."""
    report.add("", "## A searcher that never asks whether it is done", "")
    report.table("it ends by", "exit code", "interactions", "trials.csv")
    shutil.copy(ROOT / "tests/experiment/fakes.py", place)
    for name, budget, wanted in (("its budget", "400", 0), ("Ctrl-C", "1e9", 130)):
        folder = f"endless-{wanted}"
        own = ["target=pyramid", "search=rdm", "search._target_=fakes.Endless", UNTRACKED]
        own += [f"budget={budget}"]
        run = start(place, [*own, f"output={folder}"])
        if wanted:
            run.wait_for(lambda run=run: "seed 0:" in run.text())  # type: ignore[misc]
            time.sleep(2)
            os.killpg(run.process.pid, signal.SIGINT)
        code = run.wait()
        rows = trials(place / folder)
        problems = problems_of(run, place / folder) + expect("the exit code", code, wanted)
        report.row([name, code, [row["interactions"] for row in rows], statuses(place / folder)], problems)


SECTIONS: dict[str, Callable[[Path, Report], None]] = {
    "kills": kills,
    "interrupts": interrupts,
    "disks": disks,
    "objectives": objectives,
    "searchers": searchers,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the sections; 1 if anything was not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, help="where to write the report (default: printed only)")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=list(SECTIONS), help="some sections only")
    options = parser.parse_args(arguments)
    report = Report()
    report.add(
        "# Faults",
        "",
        f"Written by `python -m benchmarks.faults`, {platform.system()}, Python {platform.python_version()}.",
    )
    place = Path(tempfile.mkdtemp(prefix="faults-"))
    try:
        start(place, [*SMALL, UNTRACKED, "seed=0", "output=warm"]).wait()  # compiles, on a fresh installation
        for name in options.only:
            SECTIONS[name](place, report)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    report.add(
        "",
        "Everything was as it should be." if not report.wrong else f"{report.wrong} cases were not as they should be.",
    )
    write_report(report.lines, options.out)
    return 1 if report.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
