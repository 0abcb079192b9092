"""Ctrl-C in a multirun: what runs saves its best, what has not begun does not, and the end says how to go on."""

from __future__ import annotations

import io
import os
import signal
import threading
import time
from pathlib import Path

import pytest
from rich.console import Console

from origami_lab.multirun.job_interrupts import LOOK_SECONDS, MARK, LauncherInterrupts, clear_mark, following, marked
from origami_lab.multirun.jobs_table import table_of_jobs
from origami_lab.multirun.launchers import LAUNCHERS
from origami_lab.runs.multirun_folder import JobResult, PlannedJob
from origami_lab.runs.trial_row import Spread, read_trials
from origami_lab.workers.interrupts import NUMBERS, SAME_SECONDS, Interrupts
from tests.experiment.test_runner import background, wait_for, wait_for_group_to_end
from tests.multirun.test_launchers import table
from tests.small_runs import trial_row

in_posix = pytest.mark.skipif(not hasattr(signal, "sigwait"), reason="no thread can wait for signals")


def handlers() -> list[object]:
    return [*map(signal.getsignal, NUMBERS), signal.pthread_sigmask(signal.SIG_BLOCK, ())]


def until(condition: object, seconds: float = 10.0) -> None:
    """Let threads run, in steps in which Python's handlers run, too."""
    deadline = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < deadline
        time.sleep(0.01)


def killed() -> None:
    """Ctrl-C, and time for what it does."""
    os.kill(os.getpid(), signal.SIGINT)
    until(lambda: False)


@in_posix
def test_the_first_signal_leaves_a_mark_and_the_second_one_raises(tmp_path: Path) -> None:
    before, said = handlers(), list[str]()
    with LauncherInterrupts(tmp_path, lambda: True, said.append) as interrupts:
        assert set(NUMBERS) <= signal.pthread_sigmask(signal.SIG_BLOCK, ())  # which processes inherit
        os.kill(os.getpid(), signal.SIGTERM)
        until(lambda: marked(tmp_path) == 1)
        assert interrupts.count == len(said) == 1
        time.sleep(SAME_SECONDS)
        with pytest.raises(KeyboardInterrupt):
            killed()
        assert (interrupts.count, marked(tmp_path)) == (2, 2)
    assert handlers() == before
    assert marked(tmp_path) == 2  # jobs on their way out may still look
    clear_mark(tmp_path)
    clear_mark(tmp_path)
    with LauncherInterrupts(tmp_path, lambda: True, said.append):
        os.kill(os.getpid(), signal.SIGINT)
        until(lambda: marked(tmp_path) == 1)
    assert marked(tmp_path) == 0
    assert handlers() == before


@in_posix
def test_before_the_jobs_are_checked_the_first_signal_ends_the_command(tmp_path: Path) -> None:
    with LauncherInterrupts(tmp_path, lambda: False, lambda line: None), pytest.raises(KeyboardInterrupt):
        killed()
    assert list(tmp_path.iterdir()) == []


@in_posix
def test_a_job_hears_what_the_command_heard_and_what_came_before_it_listened(tmp_path: Path) -> None:
    before = handlers()
    with following(tmp_path) as interrupts, interrupts:
        interrupts.limit = None
        (tmp_path / MARK).write_text("1")
        until(lambda: interrupts.count == 1)
        time.sleep(3 * LOOK_SECONDS)
        assert interrupts.count == 1
        time.sleep(SAME_SECONDS)
        signal.raise_signal(signal.SIGINT)  # the second one came to the group, and the mark says so, too
        (tmp_path / MARK).write_text("2")
        time.sleep(3 * LOOK_SECONDS)
        assert interrupts.count == 2
    assert handlers() == before
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, NUMBERS)
    try:
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)  # to this thread: others here do not block it
        with pytest.raises(KeyboardInterrupt), Interrupts():
            pass
        assert set(NUMBERS) <= signal.pthread_sigmask(signal.SIG_BLOCK, ())
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    assert handlers() == before


def test_each_job_has_one_line_of_a_narrow_table() -> None:
    spread = Spread(-2.5394, 0.0612, 2)
    row = trial_row(1, -2.4961)
    long = {"max_crease_length": "2.9"}
    for kinds in (("rdm",), ("rdm", "dfts")):
        found = [
            JobResult(
                PlannedJob("x", (), {**long, "seed": f"{n}..9"}, "pyramid", method), begun, 2, 2, 0, spread, row, 10
            )
            for method in kinds
            for n, begun in enumerate((True, False))
        ]
        console = Console(file=io.StringIO(), width=80)
        console.print(table_of_jobs(found, console))
        text = console.file.getvalue()  # type: ignore[attr-defined]
        lines = [line for line in text.splitlines() if line.strip()]
        assert len(lines) == 2 + len(found)
        assert text.count("not run") == len(kinds)
        assert text.count("-2.54 ± 0.06") == len(found)
        assert text.count("max_crease_length=2.9 · seed=") == len(found)


@in_posix
@pytest.mark.slow
@pytest.mark.parametrize(("launcher", "number"), [("joblib", signal.SIGINT), ("submitit_local", signal.SIGTERM)])
def test_ctrl_c_saves_what_runs_and_says_how_to_go_on(launcher: str, number: int, tmp_path: Path) -> None:
    pytest.importorskip(LAUNCHERS[launcher].package, reason="the extra cluster is not installed")
    few = ("hydra.launcher.n_jobs=1",) if launcher == "joblib" else ()
    several = launcher == "submitit_local"  # which starts all jobs at once
    grid = ("-m", "target=pyramid", f"search={'rdm' if several else 'rdm,dfts'}", "seed=0..1", "budget=2000000000")
    rest = ("tracking=none", "files=designs", "workers=1", "output=out", f"hydra/launcher={launcher}", *few)
    with (tmp_path / "said").open("w") as said:
        process = background(tmp_path, *grid, *rest, before=lambda: os.dup2(said.fileno(), 1))
    wait_for(lambda: list((tmp_path / "out").glob("*/config.yaml")), process)
    time.sleep(5.0)  # until the trial has reported
    os.killpg(process.pid, number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in err
    wait_for_group_to_end(process.pid)
    first, *others = table(tmp_path / "out")
    assert (first["status"], first["trials"], first["asked"]) == ("stopped", "0", "2")
    (row,) = read_trials(tmp_path / "out" / first["folder"] / "trials.csv")
    assert row.status == "stopped"
    assert (tmp_path / "out" / first["folder"] / "seed=0/best.fold").is_file()
    assert (tmp_path / "out" / first["folder"] / "summary.json").is_file()
    assert [(other["status"], other["asked"]) for other in others] == ([] if several else [("not run", "2")])
    names = {"multirun.csv", "multirun.json", "multirun.yaml", "index.html", first["folder"]}
    names |= {".submitit"} if several else set()
    assert {file.name for file in (tmp_path / "out").iterdir()} == names
    assert not list((tmp_path / "out").glob(".submitit/*%j*"))
    go_on = f"to go on: origami-lab {' '.join(grid)} tracking=none files=designs workers=1 hydra/launcher={launcher}"
    assert " ".join([go_on, *few, "output=out resume=true\n"]) in (tmp_path / "said").read_text(encoding="utf-8")
