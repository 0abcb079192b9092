"""The worker processes of this machine: each joins the study by itself, plays what is free, and may die."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from origami_lab.errors import InputError
from origami_lab.runs.run_folder import FolderError
from origami_lab.sweep.play_trials import Player
from origami_lab.sweep.search_space import Point
from origami_lab.sweep.storage import PATIENCE, TROUBLE, StorageError, explain, open_storage, storage_name
from origami_lab.sweep.studies import HeldOutJob, SearchJob, best_slot, point_of
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.worker_identity import Worker
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.worker_process import STOP, Orders, WorkerProcess, hear

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


def serve(orders: Orders, calls: Calls, declaration: Declaration) -> None:
    """Play the trials that this worker gets, then its part of the comparison; tell the parent when kernels are warm."""
    end, warm = Ended(), False

    def playing() -> None:
        nonlocal warm
        if not warm:
            warm = True
            orders.say(Warm())

    try:
        work(declaration, Player(orders.stop, playing, calls))
    except (InputError, StorageError) as error:
        end = Ended(str(error))
    except FolderError as error:
        end = Ended(f"{declaration.folder} could not be written: {error.why}")
    except TROUBLE as error:
        end = Ended(explain(error, storage_name(declaration)), traceback.format_exc())
    except Exception as error:
        end = Ended(f"{type(error).__name__}: {error}", traceback.format_exc())
    with suppress(OSError):
        orders.say(end)


def work(declaration: Declaration, player: Player) -> None:
    """Join the study and play until all is done or the player is told to stop."""
    storage, worker = open_storage(declaration, PATIENCE), Worker.this()
    search = SearchJob(declaration)
    queue = search.queue(storage, worker)
    best: Point | None = None
    while player.work(search, queue):
        found = best_slot(queue.look())
        if found is None or point_of(found) == best:
            return
        best = point_of(found)
        comparison = HeldOutJob(declaration, best)
        if not player.work(comparison, comparison.queue(storage, worker)):
            return
        # once more around: others may have added trials meanwhile


class _Member(WorkerProcess):
    """A worker process of the pool."""

    ended = False
    hung = False
    """Whether it was killed for the time of one call."""


class WorkerPool:
    """The worker processes of one machine. The first one goes ahead until its search has begun: it may have to compile
    the kernels.

    Parameters
    ----------
    objective_seconds
        Longest that one call of a user's objective may take.
    say
        Takes lines about workers that died.
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
        self._members: list[_Member] = []

    def __enter__(self) -> WorkerPool:
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
        busy = [member for member in self._members if not member.ended]
        for member, message in hear(busy, seconds):
            if message is None:
                self._bury(member)
            elif isinstance(message, Ended):
                member.ended = True
                if message.error is not None:
                    self.errors.append(message)
            else:
                self.warm = True
        for member in busy:
            if not member.ended and not member.hung and (reason := member.hangs()):
                member.hung = True
                self.hung(int(member.process.pid or 0), reason)
                member.kill()
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
                member.kill()
                member.ended = True
            member.send(STOP)

    def kill(self) -> None:
        """End all workers, whatever they are doing."""
        for member in self._members:
            if not member.ended:
                member.kill()
        for member in self._members:
            member.bury()
        self._members = []

    def _start(self) -> _Member:
        return _Member(serve, (self.declaration,), self.objective_seconds)

    def _bury(self, member: _Member) -> None:
        """A worker died. Another takes its place, and sees by itself what it has left."""
        cause = member.bury()
        member.ended = True
        if self.stopping:
            return
        if not member.hung:  # what happened is said of its trial otherwise
            self.deaths += 1
            self.say(f"warning: a worker died ({cause}); another one plays its trial again")
        if self.deaths > MOST_DEATHS:
            self.errors.append(Ended(f"{self.deaths} workers died, the last one {cause}"))
            return
        self._members[self._members.index(member)] = self._start()
