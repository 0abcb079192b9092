"""Progress of a sweep: a line that moves in a terminal, a line a trial in a log, or nothing."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from origami_lab.sweep.studies import best_slot, returns_of
from origami_lab.sweep.trial_queue import Slot
from origami_lab.text import command_text, duration

if TYPE_CHECKING:
    from rich.console import Console
    from rich.status import Status


ANNOUNCE_AFTER = 8.0
"""Seconds without kernels after which a word is said about them."""


class SweepDisplay:
    """Says what has ended; in a terminal also how far it is, the best so far and the time left."""

    def __init__(self, console: Console, quiet: bool, seeds: int) -> None:
        self.console, self.quiet, self.seeds = console, quiet, seeds
        self.stopping = False
        """Whether workers are being told to leave what they play."""
        self.told: set[int] = set()
        self.compared: set[str] | None = None
        """Settings of the comparison that were played; None before it begins."""
        self.losses: dict[int, int] = {}
        self.began = time.monotonic()
        self.first = 0
        """How many were done at the start."""
        self.announced = False
        self._status: Status | None = None

    def __enter__(self) -> SweepDisplay:
        if self.console.is_terminal and not self.console.is_dumb_terminal and not self.quiet:
            self._status = self.console.status("starting")
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()

    def say(self, line: str) -> None:
        """Show one line of text as it is."""
        self.console.print(line, highlight=False, markup=False, soft_wrap=True)

    def note(self, line: str) -> None:
        """Show what can be done without."""
        if not self.quiet:
            self.say(line)

    def resume(self, slots: Sequence[Slot], asked: int) -> None:
        """Take in what was done before, and how many trials this command asks for."""
        self.told = {slot.number for slot in slots if slot.done}
        self.losses = {slot.number: slot.losses for slot in slots}
        self.first = len(self.told)
        if self.told:
            self.note(f"{self.first} of {len(slots)} trials are done")
        if len(slots) > asked:
            self.note(f"the study was given {len(slots)} trials before, which trials={asked} does not take back")

    def stopped(self, slots: Sequence[Slot], command: Sequence[str]) -> None:
        """Say how far it came before it was interrupted, and how it goes on."""
        done = sum(slot.done for slot in slots)
        self.note(f"{done} of {len(slots)} trials are done; to go on: {command_text(command)}")

    def show(self, slots: Sequence[Slot], warm: bool) -> None:
        """Take in how it stands."""
        waited = time.monotonic() - self.began
        if not warm and not self.announced and waited > ANNOUNCE_AFTER:
            self.announced = True
            self.note("loading the kernels; they are compiled the first time on a machine")
        for slot in slots:
            if slot.losses > self.losses.get(slot.number, 0) and not slot.done and not self.stopping:
                self.note(f"trial {slot.number}: its worker is gone; it is played again")
            self.losses[slot.number] = slot.losses
            if slot.done and slot.number not in self.told:
                self.told.add(slot.number)
                self.note(self._line(slot))
        if self._status is not None:
            self._status.update(self._progress(slots))

    def compare(self, settings: Mapping[str, Slot]) -> None:
        """Show how far the comparison is."""
        done = {name for name, slot in settings.items() if slot.done}
        if self.compared is None:
            self.compared = done
            if settings.keys() - done:
                self.note(f"comparing on held-out seeds: {', '.join(settings)}")
        for name in done - self.compared:
            trial = settings[name].trial
            value = f"mean return {trial.value:z.4f}" if trial is not None and trial.value is not None else "failed"
            self.note(f"{name}: {settings[name].reason or value} on held-out seeds")
        self.compared |= done
        if self._status is not None:
            self._status.update(f"comparing on held-out seeds: {len(done)} of {len(settings)} settings played")

    def _line(self, slot: Slot) -> str:
        trial = slot.trial
        if trial is None or slot.state == "failed":
            return f"trial {slot.number}: {slot.reason}"
        played = len(returns_of(slot))
        pruned = f", given up after {played} of {self.seeds} seeds: {slot.reason}" if slot.state == "pruned" else ""
        again = f", interrupted {slot.losses}×" if slot.losses else ""
        return f"trial {slot.number}: {trial.value:z.4f}{pruned}{again}"

    def _progress(self, slots: Sequence[Slot]) -> str:
        done = sum(slot.done for slot in slots)
        running = sum(slot.state == "running" for slot in slots)
        parts = [f"{done} of {len(slots)} trials done", f"{running} running"]
        best = best_slot(slots)
        if best is not None and best.trial is not None:
            parts.append(f"best {best.trial.value:z.4f} (trial {best.number})")
        if done > self.first:
            left = (time.monotonic() - self.began) / (done - self.first) * (len(slots) - done)
            parts.append(f"about {duration(left)} left")
        return " · ".join(parts)
