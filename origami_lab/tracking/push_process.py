"""The process that writes to MLflow while an experiment runs: ``python -m origami_lab.tracking.push_process DIR URI``.

A line on stdin says that there is something new in the run folder: ``trial``, or ``end`` when all is written. What
it answers is a JSON object a line: ``{"pushed": seed}``, ``{"trouble": reason}`` (null when it is over), ``{"done":
true}``. If stdin ends without ``end`` the experiment was killed: a resume or a ``--sync`` takes up what is left.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from origami_lab.runs.locks import held
from origami_lab.tracking.experiment_runs import Runs
from origami_lab.tracking.store import explain
from origami_lab.tracking.sync import read_run
from origami_lab.workers.interrupts import ignore_interrupts

NICE = 5
"""Trials go first; more would starve it on a machine that others keep busy."""
PAUSE_SECONDS = 2.0


class Pusher:
    """Pushes a run folder whenever it is told to; a store that failed is opened anew the next time."""

    def __init__(self, folder: Path, uri: str, answers: TextIO) -> None:
        self.folder, self.uri, self.answers = folder, uri, answers
        self.runs: Any = None
        """What is known of the store; None before it is opened."""
        self.trouble = False

    def push(self, live: bool) -> None:
        """Try to bring the store up to date, and answer how it went."""
        try:
            self.add_missing(live)
        except Exception as error:
            self.runs = None
            self.trouble = True
            self.answer("trouble", explain(error, self.uri))
        else:
            if self.trouble:
                self.answer("trouble", None)
            self.trouble = False

    def add_missing(self, live: bool) -> None:
        """Add what the store does not have yet."""
        settings = read_run(self.folder)
        self.runs = self.runs or Runs(settings, self.folder, self.uri)
        self.runs.settings = settings
        self.runs.push(live, lambda seed: self.answer("pushed", seed))

    def answer(self, what: str, value: object) -> None:
        self.answers.write(json.dumps({what: value}) + "\n")
        self.answers.flush()


def main(folder: Path, uri: str, kind: type[Pusher] = Pusher) -> None:
    """Serve one experiment."""
    ignore_interrupts()  # batch systems signal every process; the end of stdin says when to leave
    # what others print must not be taken for an answer
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with suppress(AttributeError, OSError):
        os.nice(NICE)
    words: queue.SimpleQueue[str] = queue.SimpleQueue()
    words.put("trial")  # what an interrupted run could not log; and MLflow is imported while the trials run

    def read() -> None:
        for line in sys.stdin:
            words.put(line.strip())
        words.put("")

    threading.Thread(target=read, daemon=True).start()
    pusher = kind(folder, uri, answers)
    with held(folder, wait=True):
        while True:
            news = {words.get()}
            while not words.empty():  # one push is enough for all that happened meanwhile
                news.add(words.get())
            if "end" not in news:
                if "" in news:
                    return
                pusher.push(live=True)
                continue
            again = not pusher.trouble
            pusher.push(live=False)
            if pusher.trouble and again:  # the first failure of all, at the very end
                time.sleep(PAUSE_SECONDS)
                pusher.push(live=False)
            pusher.answer("done", True)
            return


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
