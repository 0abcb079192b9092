"""The commands that made ``fixtures``: run with version 0.1.0 (commit ab7f1f2) checked out, they make such runs again.

    python tests/old_runs/make_fixtures.py FOLDER

Nothing in the tests calls it. FOLDER must be new; what comes out goes to ``tests/old_runs/fixtures`` as it is, but for
three things that name the machine, which stand there as ``/HERE`` (FOLDER), ``/PROJECT`` (the project's folder) and
``@HOST@`` (its host name, boot and process space), and but for MLflow's database, which is kept as SQL text.
"""

from __future__ import annotations

import os
import platform
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

PROJECT = Path(__file__).parents[2]
PARTS = Path(__file__).parent / "fixtures"

ONWARD = "start.path=killed/seed=0"
QUICK = ("tracking=none", "files=designs", "workers=1", "verbosity=quiet")
COMMANDS = {
    "cube": ("target=cube", "search=dfts", "budget=2000"),
    "bowl": ("target=bowl", "search=mcts", "search.simulations=20", "budget=2000"),
    "face": ("target=face", "target.spacing=1.0", "search=rdm", "budget=500"),
    "part": ("target=mesh", "target.path=part.stl", "board=13x13", "symmetry=xy", "search=evo", "budget=1000"),
    "shelf": ("objective=shelf", "search=rdm", "budget=8000"),
    "chair": ("objective=chair", "search=bfts", "budget=1000"),
    "ppo": (
        "target=pyramid",
        "search=ppo",
        "search.layers=[8]",
        "search.batch=60",
        "search.games=3",
        "search.minibatch=20",
        "budget=180",
    ),
    "onward": ("target=pyramid", "start=file", ONWARD, "start.remove=[[-2,1]]", "search=bfts", "budget=3000"),
    "own": ("--config-dir", "options", "objective=height", "search=climb", "budget=1000"),
    "tower": ("--config-dir", "options", "objective=tower", "search=dfts", "budget=1000"),
    "saddle": ("--config-dir", "options", "target=saddle", "search=rdm", "budget=500"),
}
"""Runs of one seed, by their folders."""
PYRAMID = ("target=pyramid", "search=bfts", "budget=12000")
JOBS = ("-m", "objective=bucket,packaging", "search=rdm", "budget=12000", "seed=0..1")


def start(here: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """A command in a process group of its own."""
    command = [sys.executable, "-m", "origami_lab", *arguments]
    return subprocess.Popen(command, cwd=here, env={**os.environ, "PYTHONPATH": str(PROJECT)}, start_new_session=True)


def run(here: Path, *arguments: str) -> None:
    assert start(here, *arguments).wait() == 0


def cut(here: Path, when: Callable[[], bool], how: signal.Signals, *arguments: str, later: float = 0.0) -> None:
    """Start a command and end it as soon as a condition holds, or so many seconds later."""
    process = start(here, *arguments)
    while not when():
        assert process.poll() is None, "it ended before it could be killed"
        time.sleep(0.002)
    time.sleep(later)
    os.killpg(process.pid, how)
    process.wait()
    time.sleep(2)  # its workers notice


def make(here: Path) -> None:
    for part in ("options", "part.stl", "height.py", "climb.py", "tower.py", "saddle.py", "small.yaml"):
        copy = shutil.copytree if (PARTS / part).is_dir() else shutil.copyfile
        copy(PARTS / part, here / part)
    expected = here / "expected"
    expected.mkdir()

    # a run that is killed after two of its four seeds, and what it would have found
    killed = here / "killed"
    cut(here, (killed / "seed=1").is_dir, signal.SIGKILL, *PYRAMID, "seed=0..3", *QUICK, "output=killed")
    run(here, *PYRAMID, "seed=0..4", *QUICK, "output=whole")
    shutil.copyfile(here / "whole/trials.csv", expected / "killed.csv")
    shutil.rmtree(here / "whole")

    for name, words in COMMANDS.items():
        run(here, *words, *QUICK, "seed=0", f"output={name}")

    # a multirun that is killed in its second job, after the first of its seeds
    there = here / "jobs/packaging/seed=0"
    cut(here, there.is_dir, signal.SIGKILL, *JOBS, *QUICK, "output=jobs")
    run(here, *JOBS, *QUICK, "output=whole")
    for job in ("bucket", "packaging"):
        shutil.copyfile(here / "whole" / job / "trials.csv", expected / f"jobs-{job}.csv")
    shutil.rmtree(here / "whole")

    # a sweep that is killed in its third trial, after the first of its seeds
    there = here / "sweep/trials/0002/seed=0"
    cut(here, there.is_dir, signal.SIGKILL, "sweep", "small.yaml", "output=sweep")
    run(here, "sweep", "small.yaml", "output=whole")
    shutil.copyfile(here / "whole/study.json", expected / "sweep.json")
    shutil.rmtree(here / "whole")

    # tracked: while the server is down, and in the store of the working directory, ended there by Ctrl-C
    tracked = ("files=designs", "workers=1", "verbosity=quiet")
    run(here, *PYRAMID, *tracked, "seed=0..1", "tracking.uri=http://127.0.0.1:9", "output=unpushed")
    stopped = here / "pushed/seed=1"
    slow = ("target=cube", "search=rdm", "budget=100000", "seed=0..2")
    cut(here, stopped.is_dir, signal.SIGINT, *slow, *tracked, "output=pushed", later=0.8)
    run(here, *slow, *QUICK, "output=whole")
    shutil.copyfile(here / "whole/trials.csv", expected / "pushed.csv")
    shutil.rmtree(here / "whole")
    with sqlite3.connect(here / "results/mlflow.db") as database:
        (here / "results/mlflow.sql").write_text("\n".join(database.iterdump()) + "\n", encoding="utf-8")
    for file in (here / "results").glob("mlflow.db*"):
        file.unlink()


def hide_machine(here: Path) -> None:
    """Write placeholders for what names this machine."""
    boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()[:8]
    host = f"{platform.node()} {boot} {Path('/proc/self/ns/pid').readlink()}"
    names = {str(here): "/HERE", str(PROJECT): "/PROJECT", host: "@HOST@", platform.node(): "@NODE@"}
    for file in here.rglob("*"):
        if file.is_file():
            old = new = file.read_bytes()
            for name, placeholder in names.items():
                new = new.replace(name.encode(), placeholder.encode())
            if new != old:
                file.write_bytes(new)


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    folder.mkdir(parents=True)
    make(folder)
    hide_machine(folder)
