"""The worker processes of this machine: each joins the study by itself, plays what is free, and may die."""

from __future__ import annotations

import multiprocessing
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from origami_lab.errors import InputError
from origami_lab.runs.run_folder import FolderError
from origami_lab.sweep.play_trials import Player
from origami_lab.sweep.search_space import Point
from origami_lab.sweep.storage import PATIENCE, TROUBLE, StorageError, explain, open_storage, storage_name
from origami_lab.sweep.studies import HeldOutJob, SearchJob, best_place, point_of
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.worker_identity import Worker
from origami_lab.workers.call_limit import CallLimit, Calls
from origami_lab.workers.interrupts import ignore_interrupts
from origami_lab.workers.worker_process import JOIN_SECONDS, STOP_CHECK_SECONDS, leave_with_parent, start_apart

MOST_DEATHS = 20
"""Workers that are replaced before something must be wrong with the machine."""


@dataclass(frozen=True)
class Warm:
    """A worker plays: the kernels are compiled."""


@dataclass(frozen=True)
class Ended:
    """A worker ended by itself."""

    error: str | None = None
    """Why, if not because all is done or it was told to."""
    traceback: str = ""


class _Orders:
    """The worker's end of the pipe."""

    def __init__(self, pipe: Connection) -> None:
        self.pipe, self.stopped, self.checked, self.warm = pipe, False, 0.0, False

    def stop(self) -> bool:
        """Whether to stop. Called often: looks at the pipe ten times a second."""
        now = time.monotonic()
        if not self.stopped and now - self.checked >= STOP_CHECK_SECONDS:
            self.checked = now
            self.stopped = self.pipe.poll()
        return self.stopped

    def playing(self) -> None:
        if not self.warm:
            self.warm = True
            self.pipe.send(Warm())


def serve(pipe: Connection, declaration: Declaration, call_number: object) -> None:
    """A worker's life: the trials that it gets, then its part of the comparison."""
    ignore_interrupts()  # the parent hears them and tells its workers
    threading.Thread(target=leave_with_parent, daemon=True, name="parent").start()
    sys.stdout = sys.stderr  # what a user's objective prints
    orders = _Orders(pipe)
    end = Ended()
    try:
        player = Player(orders.stop, orders.playing, Calls(call_number))
        work(declaration, player)
    except (InputError, StorageError) as error:
        end = Ended(str(error))
    except FolderError as error:
        end = Ended(f"{declaration.folder} could not be written: {error.why}")
    except TROUBLE as error:
        end = Ended(explain(error, storage_name(declaration)), traceback.format_exc())
    except Exception as error:
        end = Ended(f"{type(error).__name__}: {error}", traceback.format_exc())
    with suppress(OSError):
        pipe.send(end)


def work(declaration: Declaration, player: Player) -> None:
    """Join the study and play until all is done or the player is told to stop."""
    storage, worker = open_storage(declaration, PATIENCE), Worker.this()
    search = SearchJob(declaration)
    places = search.places(storage, worker)
    best: Point | None = None
    while player.work(search, places):
        found = best_place(places.look())
        if found is None or point_of(found) == best:
            return
        best = point_of(found)
        comparison = HeldOutJob(declaration, best)
        if not player.work(comparison, comparison.places(storage, worker)):
            return
        # once more around: others may have added trials meanwhile


@dataclass(eq=False)
class _Member:
    process: SpawnProcess
    pipe: Connection
    limit: CallLimit
    ended: bool = False
    hung: bool = False
    """Whether it was killed for the time of one call."""


class Crew:
    """So many workers. The first one goes ahead until its search has begun: it may have to compile the kernels.

    Parameters
    ----------
    objective_seconds
        Longest that one call of a user's objective may take.
    say
        Takes lines about what went wrong.
    hung
        Told the process number of a worker that is killed for its objective's time, and why.
    """

    def __init__(
        self,
        declaration: Declaration,
        objective_seconds: float | None,
        say: Callable[[str], None],
        hung: Callable[[int, str], None],
    ) -> None:
        self.declaration, self.say, self.hung = declaration, say, hung
        self.objective_seconds = objective_seconds
        self.errors: list[Ended] = []
        """Of workers that could not go on."""
        self.warm = self.stopping = False
        self.deaths = 0
        self._context = multiprocessing.get_context("spawn")
        self._members: list[_Member] = []

    def __enter__(self) -> Crew:
        self._members.append(self._start())
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    @property
    def at_work(self) -> bool:
        """Whether any worker has not ended yet."""
        return any(not member.ended for member in self._members)

    def listen(self, seconds: float) -> None:
        """Take in what the workers say, and replace those that died, for so long at most."""
        pipes: dict[object, _Member] = {member.pipe: member for member in self._members if not member.ended}
        for pipe in wait(list(pipes), seconds):  # type: ignore[arg-type]
            member = pipes[pipe]
            try:
                message = member.pipe.recv()
            except (EOFError, OSError):
                self._bury(member)
                continue
            if isinstance(message, Ended):
                member.ended = True
                if message.error is not None:
                    self.errors.append(message)
            else:
                self.warm = True
        for member in pipes.values():
            if not member.ended and not member.hung and member.limit.exceeded():
                limit = f"the objective took longer than objective_seconds={member.limit.seconds:g} in one call"
                member.hung = True
                self.hung(int(member.process.pid or 0), limit)
                member.process.kill()
        if self.errors and not self.stopping:
            self.stop()
        if self.warm and not self.stopping and self.at_work:
            while len(self._members) < self.declaration.workers:
                self._members.append(self._start())

    def stop(self) -> None:
        """Ask all workers to leave what they play for later."""
        self.stopping = True
        for member in self._members:
            if not self.warm:  # loading or compiling: nothing to save
                member.process.kill()
                member.ended = True
            with suppress(OSError):
                member.pipe.send("stop")

    def kill(self) -> None:
        """End all workers, whatever they are doing."""
        for member in self._members:
            if not member.ended:
                member.process.kill()
        for member in self._members:
            member.process.join(JOIN_SECONDS)
            if member.process.is_alive():
                member.process.kill()
                member.process.join()
            member.pipe.close()
        self._members = []

    def _start(self) -> _Member:
        ours, theirs = self._context.Pipe()
        limit = CallLimit(self._context, self.objective_seconds)
        process = self._context.Process(target=serve, args=(theirs, self.declaration, limit.number), daemon=True)
        start_apart(process)
        theirs.close()
        return _Member(process, ours, limit)

    def _bury(self, member: _Member) -> None:
        """A worker died. Another takes its place, and sees by itself what it has left."""
        member.process.join(JOIN_SECONDS)
        if member.process.is_alive():
            member.process.kill()
            member.process.join()
        member.ended = True
        code = member.process.exitcode
        if self.stopping:
            return
        cause = f"killed by signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        if not member.hung:  # what happened is said of its trial otherwise
            self.deaths += 1
            self.say(f"warning: a worker died ({cause}); another one plays its trial again")
        if self.deaths > MOST_DEATHS:
            self.errors.append(Ended(f"{self.deaths} workers died, the last one {cause}"))
            return
        self._members[self._members.index(member)] = self._start()
        member.pipe.close()
