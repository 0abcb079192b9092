"""Worker processes: what they hear and say, how they end, and what the parent learns of it."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from origami_lab.workers.call_limit import Calls
from origami_lab.workers.worker_process import ONE_THREAD, STOP, Orders, WorkerProcess, hear

pytestmark = pytest.mark.slow


def serve(orders: Orders, calls: Calls, greeting: str) -> None:
    """Does as it is told, in a process of its own."""
    orders.say((greeting, {name: os.environ.get(name) for name in ONE_THREAD}, sys.stdout is sys.stderr))
    while (order := orders.next()) is not None:
        if order == "wait for a stop":
            while not orders.stop():
                time.sleep(0.01)
            orders.say("stopped")
        elif order == "hang":
            calls(time.sleep)(600.0)
        elif order == "exit":
            os._exit(3)


def serve_and_leave(orders: Orders, calls: Calls, note: Path) -> bool:
    """Leaves at once, and has said what is to be done before."""
    atexit.register(note.write_text, "done")
    sys.stderr.write("with its last words")
    orders.next()
    return True


def answer(worker: WorkerProcess) -> Any:
    """The next word of a worker, which comes within a minute."""
    ((speaker, message),) = hear([worker], 60.0)
    assert speaker is worker
    return message


@contextmanager
def started(objective_seconds: float | None = None) -> Iterator[WorkerProcess]:
    worker = WorkerProcess(serve, ("hello",), objective_seconds)
    try:
        yield worker
    finally:
        worker.kill()
        worker.bury()


def test_orders_and_answers_and_a_quiet_end() -> None:
    with started() as worker:
        assert answer(worker) == ("hello", ONE_THREAD, True)
        assert list(hear([worker], 0.0)) == []
        worker.send("wait for a stop")
        worker.send(STOP)
        assert answer(worker) == "stopped"
        assert worker.hangs() == ""
        worker.send(None)
        assert worker.bury() == "exit code 0"
        worker.send(STOP)  # nobody is there, and nobody minds
        assert worker.bury() == "exit code 0"


def test_who_leaves_at_once_does_before_what_it_was_told_to(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    worker = WorkerProcess(serve_and_leave, (tmp_path / "note",), None)
    worker.send(None)
    assert worker.bury() == "exit code 0"
    assert (tmp_path / "note").read_text() == "done"
    assert "with its last words" in capfd.readouterr().err


def test_a_death_is_heard_and_costs_the_others_nothing() -> None:
    with started() as first, started() as second:
        for worker in (first, second):
            answer(worker)
        first.send("exit")
        assert [(worker is first, message) for worker, message in hear([first, second], 60.0)] == [(True, None)]
        assert first.bury() == "exit code 3"
        second.send("wait for a stop")
        second.send(STOP)
        assert answer(second) == "stopped"


@pytest.mark.skipif(sys.platform == "win32", reason="no signals there")
def test_ctrl_c_is_the_parent_s_matter_and_a_kill_is_named() -> None:
    with started() as worker:
        answer(worker)
        for number in (signal.SIGINT, signal.SIGTERM):
            os.kill(worker.process.pid or 0, number)
        worker.send("wait for a stop")
        worker.send(STOP)
        assert answer(worker) == "stopped"
        os.kill(worker.process.pid or 0, signal.SIGKILL)
        assert answer(worker) is None
        assert worker.bury() == "killed by signal 9"


def test_one_that_hangs_in_a_call_is_found() -> None:
    with started(objective_seconds=0.5) as worker:
        answer(worker)
        assert worker.hangs() == ""
        worker.send("hang")
        end = time.monotonic() + 60.0
        while not (reason := worker.hangs()) and time.monotonic() < end:
            time.sleep(0.05)
        assert reason == "the objective took longer than objective_seconds=0.5 in one call"
