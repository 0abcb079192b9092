"""The process that writes to MLflow while an experiment runs: ``python -m origami_lab.tracking.push_process DIR URI``.

A line on stdin says that there is something new in the run folder: ``trial 3`` if that is the third seed's, or ``end``
when all is written. The answers are JSON objects, one a line: ``{"pushed": 3}``, ``{"trouble": reason}`` (null when it
is over), ``{"done": true}``. If stdin ends without ``end`` the experiment was killed: a resume or a ``--sync`` takes up
what is left.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from origami_lab.runs.locks import held
from origami_lab.tracking.mlflow_log import MlflowLog
from origami_lab.tracking.store import explain
from origami_lab.workers.interrupts import ignore_interrupts

NICE = 5
"""Trials go first; more would starve it on a machine that others keep busy."""
PAUSE_SECONDS = 2.0


class Pusher:
    """Pushes a folder whenever it is told to; a store that failed is opened anew the next time."""

    def __init__(self, kind: type[MlflowLog], folder: Path, uri: str, answers: TextIO) -> None:
        self.kind, self.folder, self.uri, self.answers = kind, folder, uri, answers
        self.log: MlflowLog | None = None
        """None before the store is opened."""
        self.trouble = False

    def push(self, live: bool, numbers: Collection[int] = ()) -> None:
        """Try to bring the store up to date, and answer how it went.

        Parameters
        ----------
        live
            More trials run.
        numbers
            The trials that ended since the last push.
        """
        try:
            self.log = self.log or self.kind(self.folder, self.uri)
            self.log.push(live, numbers, lambda number: self.answer("pushed", number))
        except Exception as error:
            self.log = None
            self.trouble = True
            self.answer("trouble", explain(error, self.uri))
        else:
            if self.trouble:
                self.answer("trouble", None)
            self.trouble = False

    def answer(self, what: str, value: object) -> None:
        self.answers.write(json.dumps({what: value}) + "\n")
        self.answers.flush()


def serve_pushes(kind: type[MlflowLog], folder: Path, uri: str) -> None:
    """Push one folder until stdin ends."""
    ignore_interrupts()  # batch systems signal every process; the end of stdin says when to leave
    # what others print must not be taken for an answer
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with suppress(AttributeError, OSError):
        os.nice(NICE)
    words: queue.SimpleQueue[str] = queue.SimpleQueue()
    words.put("begin")  # what an interrupted run could not log; and MLflow is imported while the trials run

    def read() -> None:
        for line in sys.stdin:
            words.put(line.strip())
        words.put("")

    threading.Thread(target=read, daemon=True).start()
    pusher = Pusher(kind, folder, uri, answers)
    with held(folder, wait=True):
        while True:
            news = {words.get()}
            while not words.empty():  # one push is enough for all that happened meanwhile
                news.add(words.get())
            if "end" not in news:
                if "" in news:
                    return
                pusher.push(True, {int(word.removeprefix("trial ")) for word in news if word.startswith("trial ")})
                continue
            again = not pusher.trouble
            pusher.push(live=False)
            if pusher.trouble and again:  # the first failure of all, at the very end
                time.sleep(PAUSE_SECONDS)
                pusher.push(live=False)
            pusher.answer("done", True)
            return


if __name__ == "__main__":
    from origami_lab.tracking.experiment_runs import ExperimentRuns

    serve_pushes(ExperimentRuns, Path(sys.argv[1]), sys.argv[2])
