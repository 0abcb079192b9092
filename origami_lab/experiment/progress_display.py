"""Progress of the trials: a live table in a terminal, plain lines in a log, or nothing."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from origami_lab.experiment.terminal_table import NARROW
from origami_lab.experiment.trial_pool import Event, Started
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.experiment.trial_worker import Compiled, Compiling, Failed, Finished
from origami_lab.runs.trial_row import NO_DESIGN
from origami_lab.text import duration

if TYPE_CHECKING:
    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

LINE_EVERY = 10.0
SHOWN = 12
"""Trials that the live table shows at a time."""
MANY = 10
"""Trials from which it is worth saying how long their pictures took."""


@dataclass
class _Trial:
    """The state of one trial, as it is shown."""

    interactions: int = 0
    best: float | None = None
    status: str = "waiting"
    rate: float = 0.0
    searched: float = 0.0
    """Seconds of its search."""
    draws_since: float | None = None
    """When its search had ended."""
    polished: tuple[int, float] = (0, 0.0)
    """Steps of its polish, and the best return so far."""

    @property
    def ended(self) -> bool:
        return self.status != "waiting" and not self.running

    @property
    def running(self) -> bool:
        return self.status in ("running", "drawing", "polishing")

    def begins_drawing(self, budget: int) -> bool:
        """Whether its search has just ended: what is left are its files and pictures, a few seconds."""
        begins = self.status == "running" and self.interactions >= budget
        if begins:
            self.status = "drawing"
        return begins


class Display(Protocol):
    """Shows events as they come."""

    def __enter__(self) -> Display: ...
    def __exit__(self, *_: object) -> None: ...
    def show(self, event: Event) -> None: ...
    def say(self, line: str) -> None: ...
    def note(self, line: str) -> None: ...


class QuietDisplay:
    """Shows nothing but what is said."""

    def __init__(self, console: Console) -> None:
        self.console = console

    def __enter__(self) -> QuietDisplay:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def show(self, event: Event) -> None:
        pass

    def say(self, line: str) -> None:
        """Show one line of text as it is."""
        self.console.print(line, highlight=False, markup=False, soft_wrap=True)

    def note(self, line: str) -> None:
        """Show what can be done without."""


class PlainDisplay(QuietDisplay):
    """One line a finished trial, and one for the running ones every few seconds: for logs."""

    def __init__(
        self,
        console: Console,
        seeds: Sequence[int],
        budget: int,
        draws: bool = True,
        minutes: float | None = None,
        workers: int = 1,
    ) -> None:
        super().__init__(console)
        self.budget, self.draws, self.minutes, self.workers = budget, draws, minutes, workers
        self.drawn: list[float] = []
        """Seconds from the end of a trial's search until it was on disk."""
        self.trials = {seed: _Trial() for seed in seeds}
        self.last_line = time.monotonic()
        self.warm = self.announced = self.compiled = False
        self.compiles_since = 0.0

    def note(self, line: str) -> None:
        """Show one line of text as it is."""
        self.say(line)

    def show(self, event: Event) -> None:
        """Take in an event."""
        self._update(event)
        if isinstance(event, Finished | Failed) or (
            isinstance(event, Progress) and self.draws and self.trials[event.seed].begins_drawing(self.budget)
        ):
            self.say(self._line(event.seed))
        now = time.monotonic()
        shown = ("running", "polishing")
        running = [seed for seed, trial in self.trials.items() if trial.status in shown and self.warm]
        compiles = self.announced and not self.compiled and not self.warm
        if (running or compiles) and now - self.last_line >= LINE_EVERY:
            self.last_line = now
            if compiles:
                self.say(f"compiling for {now - self.compiles_since:.0f} s")
            for seed in running:
                self.say(self._line(seed))

    def _update(self, event: Event) -> None:
        match event:
            case Started(seed):
                self.trials[seed].status = "running"
            case Compiling():
                self.announced = True
                self.compiles_since = self.last_line = time.monotonic()
                self.say("compiling the kernels, the first time only")
            case Compiled(seconds):
                self.warm = True
                self._say_compiled(f" in {seconds:.0f} s")
            case Progress(seed, interactions, best, seconds):
                trial = self.trials[seed]
                self.warm = True
                trial.interactions, trial.best, trial.searched = interactions, best, seconds
                trial.rate = interactions / max(seconds, 1e-3)
                if interactions >= self.budget and trial.draws_since is None:
                    trial.draws_since = time.monotonic()
            case Polishing(seed, steps, best):
                self.trials[seed].status, self.trials[seed].polished = "polishing", (steps, best)
                self.warm = self.warm or steps > 0
            case Finished(seed, row, warnings):
                trial = self.trials[seed]
                trial.interactions, trial.best, trial.status = (
                    row.interactions or 0,
                    row.return_,
                    row.status,
                )
                trial.rate, trial.searched = row.interactions_per_second or 0.0, row.seconds or 0.0
                if trial.draws_since is not None and row.polish is None:
                    self.drawn.append(time.monotonic() - trial.draws_since)
                self._say_compiled()
                for warning in warnings:
                    self.say(f"warning: seed {seed}: {warning}")
                if all(trial.ended for trial in self.trials.values()):
                    self._say_what_pictures_took()
            case Failed(seed, reason):
                self.trials[seed].status = f"failed: {reason}"

    def _say_what_pictures_took(self) -> None:
        """Say how to do without pictures, where many trials spent most of their time on them."""
        searched = sum(trial.searched for trial in self.trials.values())
        if self.draws and len(self.drawn) >= MANY and sum(self.drawn) > searched:
            each, whole = sum(self.drawn) / len(self.drawn), searched / len(self.trials)
            self.note(
                f"pictures, viewer and certificate took {each:.1f} s a trial, its search {whole:.1f} s: files=designs"
                " leaves them out; export, verify and report make them later"
            )

    def seconds_left(self) -> float | None:
        """How long the trials will take from now on, about; None before anything can be said of it."""
        paces = {seed: trial.rate for seed, trial in self.trials.items() if trial.running and trial.rate > 0}
        if not paces:
            return None
        drawing = sum(self.drawn) / len(self.drawn) if self.drawn else 0.0
        most = math.inf if self.minutes is None else 60 * self.minutes
        left = [
            max(min((self.budget - trial.interactions) / paces[seed], most - trial.searched), 0.0) + drawing
            for seed, trial in self.trials.items()
            if seed in paces
        ]
        waiting = sum(trial.status == "waiting" for trial in self.trials.values())
        each = min(self.budget * len(paces) / sum(paces.values()), most) + drawing
        at_once = min(self.workers, len(left) + waiting)
        return max((sum(left) + waiting * each) / at_once, *left)

    def _say_compiled(self, how: str = "") -> None:
        """Say once that compiling has ended, if it had begun."""
        if self.announced and not self.compiled:
            self.compiled = True
            self.say(f"compiled{how}")

    def _line(self, seed: int) -> str:
        trial = self.trials[seed]
        best = "no design yet" if trial.best is None else f"best {trial.best:z.4f}"
        if trial.status == NO_DESIGN:
            return f"seed {seed}: {trial.interactions:,} interactions, {trial.rate:,.0f}/s, {NO_DESIGN}"
        if trial.status == "polishing":
            steps, value = trial.polished
            return f"seed {seed}: polishing its best design, {steps:,} steps, best {value:z.4f}"
        done = f"{trial.interactions:,} of {self.budget:,} interactions, {trial.rate:,.0f}/s"
        status = {"running": "", "drawing": ", drawing its pictures"}.get(trial.status, f", {trial.status}")
        return f"seed {seed}: {done}, {best}{status}"


class LiveDisplay(PlainDisplay):
    """A table that is drawn anew a few times a second: for terminals."""

    live: Live | None = None
    shown_at = 0.0

    def __enter__(self) -> LiveDisplay:
        from rich.live import Live

        self.live = Live(self._table(), console=self.console, auto_refresh=False, transient=True)
        self.live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.live is not None:
            self.live.stop()
            self.live = None

    def show(self, event: Event) -> None:
        """Take in an event and redraw."""
        self._update(event)
        now = time.monotonic()
        if self.live is not None and now - self.shown_at > 0.2:
            self.shown_at = now
            self.live.update(self._table(), refresh=True)

    def _table(self) -> Table:
        from rich.progress_bar import ProgressBar
        from rich.table import Table

        ended = [seed for seed, trial in self.trials.items() if trial.ended]
        running = [seed for seed, trial in self.trials.items() if trial.running]
        shown = (ended[-max(SHOWN - len(running), 0) :] if len(running) < SHOWN else []) + running[:SHOWN]
        best = [trial.best for trial in self.trials.values() if trial.best is not None]
        rate = sum(self.trials[seed].rate for seed in running)
        caption = f"{len(ended)} of {len(self.trials)} trials done · {rate:,.0f} interactions/s"
        if best:
            caption += f" · best {max(best):z.4f}"
        if (left := self.seconds_left()) is not None:
            caption += f" · about {duration(left)} left"
        table = Table(box=None, padding=(0, 1), caption=caption, caption_justify="left", header_style="dim")
        wide = self.console.width >= NARROW
        columns = ("seed", "interactions", "", "per second", "best", "status")
        kept = [name for name in columns if wide or name not in ("", "per second")]
        for name in kept:
            table.add_column(name, justify="left" if name in ("", "status") else "right", no_wrap=True)
        for seed in shown:
            trial = self.trials[seed]
            cells: dict[str, str | ProgressBar] = {
                "seed": str(seed),
                "interactions": f"{trial.interactions:,}",
                "": ProgressBar(total=self.budget, completed=trial.interactions, width=24),
                "per second": f"{trial.rate:,.0f}",
                "best": "–" if trial.best is None else f"{trial.best:z.4f}",
                "status": self._status(trial),
            }
            table.add_row(*(cells[name] for name in kept))
        if not shown:
            table.add_row(*[""] * (len(kept) - 1), "compiling" if self.announced else "loading")
        return table

    def _status(self, trial: _Trial) -> str:
        if trial.running and trial.status != "polishing" and trial.interactions >= self.budget:
            return "drawing" if self.draws else "writing"
        if trial.running and not self.warm:
            return f"compiling, {time.monotonic() - self.compiles_since:.0f} s" if self.announced else "loading"
        return trial.status[:40]


def make_display(
    console: Console,
    verbosity: str,
    seeds: Sequence[int],
    budget: int,
    draws: bool = True,
    minutes: float | None = None,
    workers: int = 1,
) -> Display:
    """The display that fits where the output goes.

    Parameters
    ----------
    draws
        Whether trials end with pictures.
    minutes
        Longest that the search of a trial may take; None for no limit.
    workers
        Trials at a time.
    """
    if verbosity == "quiet":
        return QuietDisplay(console)
    live = console.is_terminal and not console.is_dumb_terminal  # which rich would show nothing
    return (LiveDisplay if live else PlainDisplay)(console, seeds, budget, draws, minutes, workers)
