"""The slots of a study, one for each trial that is to be played, and who plays them.

A study has a number of slots from the start. Each is held by trials of Optuna's that wait, run or have ended: by the
first in order of their numbers that was not lost. Who plays keeps a lease, which he renews while he plays. If it is
not renewed, or his process is gone, anybody may declare the trial lost and put another one in its place, with the
same parameters. Should two do so at once, the one with the higher number is surplus, and whoever takes it up finds
that out. So every slot is played to its end once, whatever the storage, and however many workers and machines join.
"""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Container, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

import optuna
from optuna.exceptions import UpdateFinishedTrialError
from optuna.trial import FrozenTrial, Trial, TrialState, create_trial

from origami_lab.sweep.storage import TROUBLE
from origami_lab.sweep.worker_identity import Worker, is_gone

LEASE_SECONDS = 60.0
"""A lease that was not renewed for so long is over."""
MOST_LOSSES = 5
"""Trials that may be lost in one slot, one after the other, without a seed more than the one before."""
PLACE, LEASE, END, RETRY_OF = "place", "lease", "end", "retry_of"
"""Attributes of a trial: the number of its slot, under the name that studies had for it first, and so on."""
PRUNED = "pruned"
"""Attribute of a trial: why it was given up."""
LOST, STOPPED, SURPLUS, FAILED = "lost", "stopped", "surplus", "failed"
"""Why a trial of Optuna's has the state FAIL. Only the last one ends its slot."""


@dataclass(frozen=True)
class Slot:
    """A slot, and the trial that counts there."""

    number: int
    trial: FrozenTrial | None
    """None before there was any."""
    losses: int
    """Trials that were lost or stopped there before it."""
    given_up: bool
    """Whether too many were."""

    @property
    def state(self) -> str:
        """waiting, running, complete, pruned or failed."""
        if self.trial is None:
            return "waiting"
        if self.trial.state == TrialState.FAIL:
            return "failed" if self.given_up or end_of(self.trial) == FAILED else "waiting"
        return self.trial.state.name.lower()

    @property
    def done(self) -> bool:
        return self.state in ("complete", "pruned", "failed")

    @property
    def reason(self) -> str:
        """Why it failed, or was given up."""
        if self.trial is None:
            return ""
        if self.state == "pruned":
            return str(self.trial.user_attrs.get(PRUNED, ""))
        if self.state != "failed":
            return ""
        return f"{self.losses} workers were lost with it" if self.given_up else str(self.trial.user_attrs.get(END, ""))


def end_of(trial: FrozenTrial) -> str:
    """Why a trial has the state FAIL; one that somebody else made fail was lost."""
    return str(trial.user_attrs.get(END, LOST)).partition(":")[0]


class TrialQueue:
    """The slots of one study, for one worker or for a look at them.

    Parameters
    ----------
    count
        How many there are, unless the study has more already.
    worker
        Who takes trials up.
    """

    def __init__(self, study: optuna.Study, count: int, worker: Worker, lease_seconds: float = LEASE_SECONDS) -> None:
        self.study, self.count, self.worker = study, count, worker
        self.lease_seconds = lease_seconds
        self._storage = study._storage
        self._seen: dict[int, tuple[object, float]] = {}
        """Leases of others by trial: the last one, and since when it is the same on our clock."""

    def look(self) -> list[Slot]:
        """All slots, in order."""
        trials: dict[int, list[FrozenTrial]] = defaultdict(list)
        for trial in self.study.get_trials(deepcopy=False):
            if trial.user_attrs.get(PLACE) is not None and end_of_failed(trial) != SURPLUS:
                trials[trial.user_attrs[PLACE]].append(trial)
        count = max(self.count, 1 + max(trials, default=0))
        return [_slot(number, trials[number]) for number in range(count)]

    def fill(self) -> None:
        """Put a waiting trial where none is, or where the last one was lost."""
        while True:
            empty = [slot for slot in self.look() if slot.state == "waiting" and not _is_waiting(slot.trial)]
            if not empty:
                return
            for slot in empty:
                attributes: dict[str, Any] = {PLACE: slot.number}
                system: Mapping[str, Any] = {}
                if slot.trial is not None:
                    attributes[RETRY_OF] = slot.trial.number
                    system = slot.trial.system_attrs  # with the parameters, if it had any
                self.study.add_trial(
                    create_trial(state=TrialState.WAITING, user_attrs=attributes, system_attrs=dict(system))
                )

    def claim(self, without: Container[int] = ()) -> HeldTrial | None:
        """Take up the waiting trial with the lowest slot; None if none waits, but in slots to be left alone."""
        slots = [slot for slot in self.look() if slot.number not in without]
        waiting = [trial for slot in slots if _is_waiting(trial := slot.trial) and trial is not None]
        for frozen in [*waiting, *self._surplus()]:
            try:
                if not self._storage.set_trial_state_values(frozen._trial_id, TrialState.RUNNING):
                    continue
                held = HeldTrial(self, frozen._trial_id, frozen.user_attrs[PLACE])
                counts = self.look()[held.number].trial
            except UpdateFinishedTrialError:
                continue
            if counts is None or counts.number != frozen.number:
                held.fail(SURPLUS)
                continue
            return held
        return None

    def _surplus(self) -> list[FrozenTrial]:
        """Waiting trials in slots that others hold."""
        holders = {slot.number: slot.trial.number for slot in self.look() if slot.trial is not None}
        waiting = self.study.get_trials(deepcopy=False, states=(TrialState.WAITING,))
        return [
            trial for trial in waiting if trial.number != holders.get(trial.user_attrs.get(PLACE, -1), trial.number)
        ]

    def reap(self, why: str = LOST) -> list[int]:
        """Declare trials lost whose workers are gone, or stopped if we ended them; their slots."""
        lost, running = [], set[int]()
        for trial in self.study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            running.add(trial.number)
            if trial.user_attrs.get(PLACE) is not None and self._is_lost(trial):
                try:
                    self._storage.set_trial_user_attr(trial._trial_id, END, why)
                    self._storage.set_trial_state_values(trial._trial_id, TrialState.FAIL)
                except UpdateFinishedTrialError:  # somebody else was quicker, or it lives and has just ended
                    continue
                lost.append(trial.user_attrs[PLACE])
        self._seen = {number: seen for number, seen in self._seen.items() if number in running}
        return lost

    def condemn(self, pid: int, reason: str) -> None:
        """Let the trial fail that a process of this machine plays."""
        for trial in self.study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            worker = (trial.user_attrs.get(LEASE) or {}).get("worker", {})
            if worker.get("host") == self.worker.host and worker.get("pid") == pid:
                with suppress(UpdateFinishedTrialError):
                    self._storage.set_trial_user_attr(trial._trial_id, END, f"{FAILED}: {reason}")
                    self._storage.set_trial_state_values(trial._trial_id, TrialState.FAIL)

    def _is_lost(self, trial: FrozenTrial) -> bool:
        lease = trial.user_attrs.get(LEASE) or {}
        if lease and is_gone(Worker(**lease["worker"]), self.worker):
            return True
        now = time.monotonic()  # of our own: clocks of machines differ
        before, since = self._seen.get(trial.number, (None, now))
        if before != lease:
            self._seen[trial.number] = (lease, now)
            return False
        return now - since > self.lease_seconds


@dataclass
class HeldTrial:
    """A trial that this worker plays. As a context it renews its lease."""

    queue: TrialQueue
    trial_id: int
    number: int
    """Of its slot, not of the trial."""
    lost: bool = False
    """Whether others have declared it lost."""
    _beat: int = 0
    _over: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def __post_init__(self) -> None:
        self.renew()

    def renew(self) -> None:
        """Write the lease anew; what others see is that it changes."""
        self._beat += 1
        self._set_attribute(LEASE, {"worker": vars(self.queue.worker), "beat": self._beat})

    def note(self, key: str, value: Any) -> None:
        """Keep a fact with the trial."""
        self._set_attribute(key, value)

    def begin(self, system_attrs: Mapping[str, Any]) -> Trial:
        """The trial, with attributes of Optuna's that it is to have."""
        for key, value in system_attrs.items():
            self.queue._storage.set_trial_system_attr(self.trial_id, key, value)
        return Trial(self.queue.study, self.trial_id)

    def frozen(self) -> FrozenTrial:
        """The trial as the storage has it."""
        return self.queue._storage.get_trial(self.trial_id)

    def end(self, state: TrialState, value: float) -> None:
        """The trial was played."""
        try:
            self.queue._storage.set_trial_state_values(self.trial_id, state, [value])
        except UpdateFinishedTrialError:
            self.lost = True

    def fail(self, why: str) -> None:
        """The trial was not played to its end: SURPLUS, STOPPED, or FAILED with a reason behind a colon."""
        try:
            self._set_attribute(END, why)
            self.queue._storage.set_trial_state_values(self.trial_id, TrialState.FAIL)
        except UpdateFinishedTrialError:
            self.lost = True

    def __enter__(self) -> HeldTrial:
        self._thread = threading.Thread(target=self._keep, daemon=True, name="lease")
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()

    def _keep(self) -> None:
        while not self._over.wait(self.queue.lease_seconds / 4):
            try:
                self.renew()
            except UpdateFinishedTrialError:
                self.lost = True
                return
            except TROUBLE:  # the storage may come back before the lease is over
                continue

    def _set_attribute(self, key: str, value: Any) -> None:
        self.queue._storage.set_trial_user_attr(self.trial_id, key, value)


def end_of_failed(trial: FrozenTrial) -> str | None:
    """Why a trial has the state FAIL; None if it has not."""
    return end_of(trial) if trial.state == TrialState.FAIL else None


def _is_waiting(trial: FrozenTrial | None) -> bool:
    return trial is not None and trial.state == TrialState.WAITING


def _slot(number: int, trials: Sequence[FrozenTrial]) -> Slot:
    """The first trial that was not lost counts; where all were, the last one."""
    trials = sorted(trials, key=lambda trial: trial.number)
    for index, trial in enumerate(trials):
        if end_of_failed(trial) in (None, FAILED):
            return Slot(number, trial, index, given_up=False)
    lost = [trial for trial in trials if end_of(trial) == LOST]
    played = len(lost[-1].intermediate_values) if lost else 0
    in_vain = sum(len(trial.intermediate_values) >= played for trial in lost)
    return Slot(number, trials[-1] if trials else None, len(trials), given_up=in_vain >= MOST_LOSSES)
