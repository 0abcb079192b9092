"""The server's end of a worker process: orders go there, answers come back to the event loop."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from origami_lab.config.settings import Settings
from origami_lab.game.game import Game
from origami_lab.studio.partner_worker import READY, Done, Heard, Order, serve
from origami_lab.workers.worker_process import STOP, WorkerProcess

POLL_SECONDS = 0.2


class PartnerProcess:
    """One worker process, started anew where it has died, that works on one order at a time.

    Parameters
    ----------
    hear
        Called in the event loop with the order and each answer; where the process dies, with one that says so.
    searches
        Whether to have the searchers ready before there is an order.
    """

    def __init__(
        self, settings: Settings, game: Game, hear: Callable[[Order, Any], None], *, searches: bool = True
    ) -> None:
        self._settings, self._game, self._hear, self._searches = settings, game, hear, searches
        self._loop = asyncio.get_running_loop()
        self._worker: WorkerProcess | None = None
        self.order: Order | None = None
        """What it works on."""
        self.is_ready = False
        """Whether it has loaded, or compiled, what it needs."""

    def start(self) -> None:
        """Have a process ready before there is an order."""
        if self._worker is None:
            worker = WorkerProcess(
                serve, (self._settings, self._game, self._searches), self._settings.objective_seconds
            )
            self._worker, self.is_ready = worker, False
            threading.Thread(target=self._listen, args=(worker,), daemon=True, name="partner").start()

    def give(self, order: Order) -> None:
        """Have it carry out an order; there must be no other one."""
        self.start()
        assert self._worker is not None
        self.order = order
        self._worker.send(order)

    def stop(self) -> None:
        """Ask it to end what it does with what it has."""
        if self._worker is not None and self.order is not None:
            self._worker.send(STOP)

    def close(self) -> None:
        """End the process, whatever it is doing."""
        worker, self._worker, self.order = self._worker, None, None
        if worker is not None:
            worker.kill()
            worker.process.join()

    def _listen(self, worker: WorkerProcess) -> None:
        """The life of a thread: answers one after the other, until the process is gone."""
        while True:
            try:
                if worker.pipe.poll(POLL_SECONDS):
                    self._tell(worker, worker.pipe.recv())
            except (EOFError, OSError):
                break
            if reason := worker.hangs():
                worker.kill()
                self._tell(worker, Heard(-1, Done(error=reason)))
                break
        self._tell(worker, None)

    def _tell(self, worker: WorkerProcess, heard: Heard | None) -> None:
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._take, worker, heard)

    def _take(self, worker: WorkerProcess, heard: Heard | None) -> None:
        if worker is not self._worker:  # closed, or replaced
            return
        order = self.order
        if heard is not None and heard.number == READY:
            self.is_ready = True
            return
        if heard is None or heard.number < 0:
            self._worker = None
            if order is not None:
                self.order = None
                self._hear(order, heard.what if heard is not None else Done(error="its process died"))
            return
        if order is None or heard.number != order.number:
            return
        if isinstance(heard.what, Done):
            self.order = None
        self._hear(order, heard.what)
