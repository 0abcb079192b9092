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
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from benchmarks.faulty import WAYS
from benchmarks.runs import Run, defects, finished, start, statuses, trials

SEEDS = 4
SMALL = ("target=pyramid", "search=rdm", "board=9x9", "budget=400", f"seed=0..{SEEDS - 1}", "workers=2")
LONG = ("target=pyramid", "search=rdm", "board=9x9", "budget=1e9", f"seed=0..{SEEDS - 1}", "workers=2")
UNTRACKED = "tracking=none"
KILLS = 30
MEMORY = 8 * 2**30
LIMIT_SECONDS = 3
TRACEBACK = "Traceback (most recent call last)"
OBJECTIVE = "# @package _global_\ntask: faulty\nobjective:\n  _target_: benchmarks.faulty.Faulty\n  how: ???\n"
OBJECTIVE += "  where: score\n  once: ???\n"
SEARCH = "# @package _global_\nmethod: endless\nsearch:\n  _target_: benchmarks.faulty.Endless\n"

Lines = list[str]


class Report:
    """The lines of the report and whether anything was not as it should be."""

    def __init__(self) -> None:
        self.lines: Lines = []
        self.wrong = 0

    def add(self, *lines: str) -> None:
        """Add lines."""
        self.lines += lines
        print("\n".join(lines), flush=True)

    def table(self, *names: str) -> None:
        """Begin a table; its last column is added here."""
        self.add("", f"| {' | '.join(names)} | as it should be |", "|" + "---|" * (len(names) + 1))

    def row(self, cells: Sequence[object], problems: Sequence[str]) -> None:
        """One case, and what was wrong about it."""
        self.wrong += bool(problems)
        verdict = "yes" if not problems else "**NO**: " + "; ".join(problems)
        self.add("| " + " | ".join(str(cell).replace("|", "\\|") for cell in (*cells, verdict)) + " |")


def problems_of(run: Run, folder: Path, tidy: bool = True) -> list[str]:
    """What is wrong after any ending: a traceback, or something that is not whole."""
    return (["it printed a traceback"] if TRACEBACK in run.text() else []) + defects(folder, tidy)


def expect(what: str, found: object, wanted: object) -> list[str]:
    """One problem if something is not as wanted."""
    return [] if found == wanted else [f"{what} is {found}, not {wanted}"]


# --- kill -9 ----------------------------------------------------------------------------------------------------------


def kills(place: Path, report: Report) -> None:
    """Kill runs at random moments and resume them; then one run again and again until it ends."""
    undisturbed = start(place, [*SMALL, "output=undisturbed"])
    undisturbed.wait()
    seconds = time.monotonic() - undisturbed.began
    wanted = trials(place / "undisturbed")
    report.add(
        "", "## kill -9", "", f"{SEEDS} seeds, 2 workers, tracked by MLflow; undisturbed it takes {seconds:.0f} s."
    )
    report.table("killed", "after s", "on disk then", "after resume=true")
    rng = random.Random(0)
    for number in range(KILLS):
        _kill_once(place, report, number, rng.uniform(0, seconds), wanted)
    _kill_until_done(place, report, rng, seconds, wanted)


def _kill_once(place: Path, report: Report, number: int, after: float, wanted: object) -> None:
    group, folder = number % 2 == 0, place / f"kill-{number}"
    arguments = [*SMALL, f"output={folder.name}", "resume=true"]
    run = start(place, arguments)
    time.sleep(after)
    ended = run.process.poll() is not None
    run.kill(group)
    problems = problems_of(run, folder, tidy=False)
    then, before = _contents(folder), finished(folder)
    again = start(place, arguments)
    problems += expect("the exit code after resuming", again.wait(), 0) + problems_of(again, folder)
    problems += expect("the table", trials(folder), wanted)
    now = finished(folder)
    problems += expect("finished trials run again", [seed for seed in before if before[seed] != now.get(seed)], [])
    who = "(it had ended)" if ended else "parent and workers" if group else "parent alone"
    report.row([who, f"{after:.1f}", then, statuses(folder)], problems)


def _contents(folder: Path) -> str:
    if not folder.exists():
        return "no folder"
    names = sorted(path.name for path in folder.iterdir())
    visible = [name for name in names if not name.startswith(".")]
    hidden = len(names) - len(visible)
    return (", ".join(visible) or "empty") + (f", {hidden} hidden" if hidden else "")


def _kill_until_done(place: Path, report: Report, rng: random.Random, seconds: float, wanted: object) -> None:
    folder = place / "again-and-again"
    problems: Lines = []
    killed, kept = 0, []
    while True:
        run = start(place, [*SMALL, f"output={folder.name}", "resume=true"])
        time.sleep(rng.uniform(0.3, 1.0) * seconds)
        if run.process.poll() is not None:
            break
        before = finished(folder)
        run.kill(group=killed % 2 == 0)
        now = finished(folder)
        problems += problems_of(run, folder, tidy=False)
        problems += expect("finished trials lost", [seed for seed in before if before[seed] != now.get(seed)], [])
        killed += 1
        kept.append(str(len(now)))
    problems += expect("the last exit code", run.wait(), 0) + expect("the table", trials(folder), wanted)
    problems += problems_of(run, folder)
    text = f"the same run killed {killed} times, then left alone; finished trials on disk each time: {', '.join(kept)}"
    report.add(
        "", f"{text}. In the end: {statuses(folder)}. " + (f"**NO**: {problems}" if problems else "As it should be.")
    )
    report.wrong += bool(problems)


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


# --- full and vanishing disks -----------------------------------------------------------------------------------------


@contextmanager
def small_disk(place: Path, kilobytes: int) -> Iterator[Path]:
    """A file system of its own with so much room."""
    mount = place / "disk"
    mount.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "none", str(mount)], check=True)
    try:
        yield mount
    finally:
        subprocess.run(["umount", "-l", str(mount)], check=True)


def disks(place: Path, report: Report) -> None:
    """Fill, lock and remove the output folder."""
    report.add("", "## Full, read-only and vanishing output folders", "")
    if shutil.which("mount") is None or os.getuid() != 0:
        report.add("Not run: mounting a small tmpfs needs root on Linux.")
        return
    wanted = _reference(place)
    report.add("tmpfs mounts with the given room left when the run starts; a trial takes about 1 MB.")
    report.table("what happens", "exit code", "trials.csv", "trials kept", "it says", "resumed with room")
    for left in (0, 4, 8, 16, 256, 1100, 2048):
        _full_from_start(place, report, left, wanted)
    _meanwhile(place, report, "full after the first trial", _fill, wanted)
    _meanwhile(place, report, "read-only after the first trial", _lock, wanted)
    _meanwhile(place, report, "removed after the first trial", _remove, wanted)
    _read_only(place, report)


def _reference(place: Path) -> object:
    run = start(place, [*SMALL, UNTRACKED, "output=reference"])
    run.wait()
    return trials(place / "reference")


def _full_from_start(place: Path, report: Report, left: int, wanted: object) -> None:
    with small_disk(place, 16384) as disk:
        folder = disk / "out"
        folder.mkdir()
        _fill(disk, left)
        run = start(place, [*SMALL, UNTRACKED, f"output={folder}", "resume=true"])
        _full_row(place, report, f"{left} kB left", run, folder, wanted)


def _meanwhile(place: Path, report: Report, name: str, fault: Callable[[Path], None], wanted: object) -> None:
    with small_disk(place, 16384) as disk:
        folder = disk / "out"
        run = start(place, [*SMALL, UNTRACKED, f"output={folder}", "workers=1"])
        run.wait_for(lambda: (folder / "seed=0").exists())
        fault(disk)
        _full_row(place, report, name, run, folder, wanted)


def _full_row(place: Path, report: Report, name: str, run: Run, folder: Path, wanted: object) -> None:
    """Wait for the end of a run whose disk failed, mend the disk and resume."""
    code, kept = run.wait(), finished(folder)
    run.wait_for(lambda: not run.alive())
    says = run.line("could not be written").replace(str(folder.parent), "/disk")
    problems = problems_of(run, folder, tidy=_writable(folder)) + expect("the exit code", code, 1)
    problems += [] if says else [f"it says only: {run.text()[-200:]}"]
    table = statuses(folder)
    (folder.parent / "ballast").unlink(missing_ok=True) if _mend(folder.parent) else None
    again = start(place, [*SMALL, UNTRACKED, f"output={folder}", "resume=true"])
    problems += expect("the exit code after resuming", again.wait(), 0) + problems_of(again, folder)
    problems += expect("the table", trials(folder), wanted)
    lost = [seed for seed, written in kept.items() if finished(folder).get(seed) != written]
    problems += expect("finished trials run again", lost, [])
    report.row([name, code, table, len(kept), says, statuses(folder)], problems)


def _fill(disk: Path, left: int = 0) -> None:
    """Fill a disk up but for some kilobytes."""
    with (disk / "ballast").open("wb", buffering=0) as ballast:
        size = shutil.disk_usage(disk).free - 1024 * left
        os.posix_fallocate(ballast.fileno(), 0, max(size, 4096))


def _lock(disk: Path) -> None:
    while subprocess.run(["mount", "-o", "remount,ro", str(disk)], capture_output=True).returncode:
        time.sleep(0.02)  # a file is being written


def _mend(disk: Path) -> bool:
    return subprocess.run(["mount", "-o", "remount,rw", str(disk)], capture_output=True).returncode == 0


def _remove(disk: Path) -> None:
    while (disk / "out").exists():
        shutil.rmtree(disk / "out", ignore_errors=True)


def _writable(folder: Path) -> bool:
    return os.access(folder, os.W_OK)


def _read_only(place: Path, report: Report) -> None:
    with small_disk(place, 16384) as disk:
        _lock(disk)
        run = start(place, [*SMALL, UNTRACKED, f"output={disk}/out"])
        code = run.wait()
        says = run.text().strip().replace(str(disk), "/disk")
        problems = expect("the exit code", code, 2) + expect("lines", len(says.splitlines()), 1)
        report.row(["read-only from the start", code, "–", "–", says, "–"], problems)


# --- what users bring -------------------------------------------------------------------------------------------------


def objectives(place: Path, report: Report) -> None:
    """Each bad objective spoils one of two trials."""
    report.add("", "## Objectives that misbehave", "")
    report.add(
        f"Two seeds; one bad call in the first trial, objective_seconds={LIMIT_SECONDS}, {MEMORY >> 30} GiB of memory."
    )
    report.table("the objective", "in", "exit code", "seconds", "seed 0", "seed 1")
    for folder, text in (("objective/faulty.yaml", OBJECTIVE), ("search/endless.yaml", SEARCH)):
        file = place / "conf" / folder
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
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
    file = place / "conf/search/endless.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(SEARCH, encoding="utf-8")
    report.table("it ends by", "exit code", "interactions", "trials.csv")
    for name, budget, wanted in (("its budget", "400", 0), ("Ctrl-C", "1e9", 130)):
        folder = f"endless-{wanted}"
        own = ["--config-dir", str(place / "conf"), "target=pyramid", "search=endless", f"budget={budget}", UNTRACKED]
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
    if options.out is not None:
        options.out.write_text("\n".join(report.lines) + "\n", encoding="utf-8")
    return 1 if report.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
