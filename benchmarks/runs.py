"""Real runs of the command in processes of their own, and a look at what they leave: for :mod:`benchmarks.faults`."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from PIL import Image

from origami_lab.file_names import STATE
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import read_trials
from tests.small_runs import TIMINGS

ROOT = Path(__file__).parents[1]
TRIAL_FILES = {
    *("best.fold", "motion.fold", "actions.json", "curve.csv", "result.json"),
    *("pattern.png", "folded.png", "motion.gif", "pattern.svg", "best.html", "certificate.json", STATE),
}
FOLDER_FILES = {"config.yaml", "target.ply", "trials.csv", "summary.json", "tracking.json"}
PATIENCE = 300.0
TRACEBACK = "Traceback (most recent call last)"
SEEDS = 4
SMALL = ("target=pyramid", "search=rdm", "board=9x9", "budget=400", f"seed=0..{SEEDS - 1}", "workers=2")
LONG = ("target=pyramid", "search=rdm", "board=9x9", "budget=1e9", f"seed=0..{SEEDS - 1}", "workers=2")
UNTRACKED = "tracking=none"

Lines = list[str]


@dataclass
class Run:
    """One command that runs, or has run."""

    process: subprocess.Popen[bytes]
    log: Path
    began: float = field(default_factory=time.monotonic)

    def wait(self) -> int:
        """Its exit code; negative for a signal, also for the one that ends it when it takes for ever."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            return self.process.wait()

    def kill(self, group: bool) -> None:
        """``kill -9``, also of its workers or of the parent alone; returns when all are gone."""
        with suppress(ProcessLookupError):
            (os.killpg if group else os.kill)(self.process.pid, signal.SIGKILL)
        self.wait()
        self.wait_for(lambda: not self.alive())

    def alive(self) -> bool:
        """Whether any process of its group is left."""
        try:
            os.killpg(self.process.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def wait_for(self, condition: Callable[[], object]) -> bool:
        """Wait for a condition while it runs; whether it came."""
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(self.text())
            if self.process.poll() is not None and not self.alive():
                return bool(condition())
            time.sleep(0.01)
        return True

    def text(self) -> str:
        """All that it printed."""
        return self.log.read_text(encoding="utf-8", errors="replace")

    def line(self, word: str) -> str:
        """The last line that it printed with a word in it."""
        return next((line for line in reversed(self.text().splitlines()) if word in line), "")


def start(place: Path, arguments: Sequence[str], before: Callable[[], None] | None = None) -> Run:
    """Start the command in a working directory, as the leader of a process group."""
    log = place / f"log-{time.monotonic_ns()}.txt"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-m", "origami_lab", *arguments]

    def prepare() -> None:
        for number in (signal.SIGINT, signal.SIGHUP):  # a shell's background jobs ignore them
            signal.signal(number, signal.SIG_DFL)
        if before is not None:
            before()

    with log.open("wb") as out:
        process = subprocess.Popen(
            command, cwd=place, env=environment, stdout=out, stderr=out, start_new_session=True, preexec_fn=prepare
        )
    return Run(process, log)


def trials(folder: Path) -> list[dict[str, Any]]:
    """The table of trials without what the clock says; empty if there is none."""
    with suppress(FileNotFoundError):
        return [
            {k: v for k, v in row.values().items() if k not in TIMINGS} for row in read_trials(folder / "trials.csv")
        ]
    return []


def statuses(folder: Path) -> str:
    """The status of each trial in the table, in short."""
    rows = trials(folder)
    empty = "no rows" if (folder / "trials.csv").exists() else "no file"
    return ", ".join(f"{row['seed']}: {str(row['status']).partition(':')[0]}" for row in rows) or empty


def finished(folder: Path) -> dict[int, int]:
    """When each finished trial on disk was written."""
    rows = RunFolder(folder).rows()
    return {seed: (folder / f"seed={seed}/result.json").stat().st_mtime_ns for seed in sorted(rows)}


def defects(folder: Path, tidy: bool = True) -> list[str]:
    """What is not whole in a run folder.

    Parameters
    ----------
    tidy
        Whether hidden files are a defect, too; they are none after a kill.
    """
    found = []
    for path in sorted(folder.iterdir()) if folder.exists() else []:
        if path.name.startswith("."):
            found += [f"{path.name} is left over"] if tidy else []
        elif path.is_dir():
            names = {file.name for file in path.iterdir()}  # a trial that was stopped has no state to go on from
            found += [f"{path.name} holds {sorted(names)}"] if names | {STATE} != TRIAL_FILES else []
            found += _unreadable(path)
        elif path.name not in FOLDER_FILES and not path.name.endswith(".error.txt"):
            found.append(f"{path.name} should not be there")
    return found + (_unreadable(folder) if folder.exists() else [])


def _unreadable(folder: Path) -> list[str]:
    found = []
    for file in folder.iterdir():
        if file.is_dir() or file.name.startswith("."):
            continue
        try:
            _read(file)
        except Exception as error:
            found.append(f"{folder.name}/{file.name}: {type(error).__name__}: {error}")
    return found


def _read(file: Path) -> None:
    """Read a file to its end, in its format."""
    if file.suffix in (".json", ".fold"):
        json.loads(file.read_text(encoding="utf-8"))
    elif file.suffix == ".csv":
        with file.open(newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
        if len(rows) < 1 or len({len(row) for row in rows}) != 1:
            raise ValueError("rows of different lengths")
    elif file.suffix == ".yaml":
        if "budget" not in OmegaConf.load(file):
            raise ValueError("no budget in it")
    elif file.suffix == ".ply":
        import trimesh

        trimesh.load(file, process=False)
    elif file.suffix in (".png", ".gif"):
        with Image.open(file) as image:
            for frame in range(getattr(image, "n_frames", 1)):
                image.seek(frame)
                image.load()


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
