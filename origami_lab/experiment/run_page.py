"""The page of a run: written while it runs, at its end, and anew when its designs are reworked."""

from __future__ import annotations

import math
import os
import sys
import time
import webbrowser
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.node import Node
from origami_lab.config.seeds import parse_seeds
from origami_lab.config.settings import task_name
from origami_lab.experiment.page_entries import SHOWN, MeanCurve, entry_of, thinned
from origami_lab.experiment.trial_progress import Polishing, Progress
from origami_lab.file_names import CONFIG, DESCRIBED, PAGE, SUMMARY, TRIALS
from origami_lab.runs.run_folder import RunFolder, read_summary
from origami_lab.runs.trial_row import NO_DESIGN, STOPPED, TrialRow
from origami_lab.text import command_text

if TYPE_CHECKING:
    from origami_lab.pages import PageFolder

EVERY_SECONDS = 2.0
"""How often the page is written while a run goes on, at most."""
MOST_DRAWN = 200
"""Trials without pictures whose patterns are drawn; later ones only if they are the best so far."""
RUNNING, FINISHED = "running", "finished"


@dataclass
class Running:
    """A trial that runs, as far as is known."""

    interactions: int = 0
    best: float | None = None
    seconds: float = 0.0
    doing: str = "searching"
    curve: list[list[float]] = field(default_factory=list)

    def take(self, event: Progress | Polishing) -> None:
        if isinstance(event, Polishing):
            self.doing, self.best = "polishing", event.best
            return
        if event.best is not None and event.best != self.best:
            self.curve.append([event.interactions, event.best])
            if len(self.curve) > 120:
                self.curve = thinned(self.curve)
        self.interactions, self.best, self.seconds = event.interactions, event.best, event.seconds


class Tally:
    """What the trials that have ended came to, one after the other."""

    def __init__(self, budget: int = 1) -> None:
        self.curve = MeanCurve(budget)
        self.outcomes: Counter[str] = Counter()
        self.verdicts: Counter[str] = Counter()
        self.count, self.mean, self._squares = 0, 0.0, 0.0
        self.best: TrialRow | None = None
        self.best_entry: Mapping[str, Any] | None = None

    def improves(self, row: TrialRow) -> bool:
        """Whether a trial's design is better than all before; the lower seed among equals."""
        if row.return_ is None or row.outcome == NO_DESIGN:
            return False
        best = self.best
        return best is None or best.return_ is None or (row.return_, -row.seed) > (best.return_, -best.seed)

    def add(self, row: TrialRow, entry: Mapping[str, Any]) -> None:
        self.outcomes[row.outcome] += 1
        if row.certificate:
            self.verdicts[row.certificate] += 1
        if self.improves(row):
            self.best, self.best_entry = row, entry
        if row.spent_budget and row.return_ is not None:  # Welford's
            self.count += 1
            before = row.return_ - self.mean
            self.mean += before / self.count
            self._squares += before * (row.return_ - self.mean)
            self.curve.add(entry["curve"])

    def to_json(self) -> dict[str, Any]:
        std = math.sqrt(self._squares / (self.count - 1)) if self.count > 1 else None
        return {
            "outcomes": dict(sorted(self.outcomes.items())),
            "verdicts": dict(sorted(self.verdicts.items())),
            "returns": None if not self.count else {"mean": self.mean, "std": std, "n": self.count},
            "best": self.best_entry,
            "curve": self.curve.points(),
        }


class RunPage:
    """The page of one run. Nothing that goes wrong with it costs the run anything.

    Parameters
    ----------
    config
        The run's configuration.
    seeds
        How many trials it is to have.
    command
        As it is shown.
    """

    def __init__(self, folder: RunFolder, config: Node, seeds: int, command: str, opens: bool = False) -> None:
        self.folder, self.config, self.seeds, self.command, self.opens = folder, config, seeds, command, opens
        self.running: dict[int, Running] = {}
        budget = config.get("budget")
        self._tally = Tally(budget if isinstance(budget, int) and budget > 0 else 1)
        self._to_add: list[TrialRow] = []
        self._page: PageFolder | None = None
        self._written = time.monotonic()
        self._tried = False

    def begin(self, rows: Iterable[TrialRow]) -> None:
        """Take in the trials of an earlier part of the run."""
        self._to_add = list(rows)

    def take(self, event: object) -> None:
        """Take in how far a trial is, and write the page if it is time to."""
        if isinstance(event, Progress | Polishing):
            self.running.setdefault(event.seed, Running()).take(event)
        waited = time.monotonic() - self._written >= EVERY_SECONDS
        # before the first progress a worker is about to begin: that comes first
        if waited or (not self._tried and isinstance(event, Progress | Polishing)):
            self.write(RUNNING)

    def end(self, row: TrialRow) -> None:
        """Take in a trial that has ended."""
        self.running.pop(row.seed, None)
        self._to_add.append(row)

    def write(self, state: str) -> None:
        """Write the page as things stand."""
        self._written, self._tried = time.monotonic(), True
        with suppress(OSError):
            page = self._opened()
            self._add(page)
            page.say(self._live(state))

    def _opened(self) -> PageFolder:
        from origami_lab.pages import PageFolder

        if self._page is None:
            page = PageFolder(self.folder.path)
            page.begin(run_page_text(self.config, self.folder.path, self.command))
            self._page = page
            around = write_page_around(self.folder.path)
            if self.opens:
                open_page(around or self.folder.path / PAGE)
        return self._page

    def _add(self, page: PageFolder) -> None:
        entries: list[dict[str, Any]] = []
        for row in self._to_add:
            draws = page.ended + len(entries) < MOST_DRAWN or self._tally.improves(row)
            entry = entry_of(self.folder.path, row, draws)
            entries.append(entry)
            self._tally.add(row, entry)
        self._to_add = []
        page.add(entries)

    def _live(self, state: str) -> dict[str, Any]:
        return {
            "state": state,
            "at": round(1000 * time.time()),
            "seeds": self.seeds,
            "budget": self.config.get("budget"),
            "running": [{"seed": seed, **vars(trial)} for seed, trial in sorted(self.running.items())],
            "files": [name for name in (CONFIG, TRIALS, SUMMARY) if (self.folder.path / name).is_file()],
            **self._tally.to_json(),
        }


def run_page_text(config: Node, folder: Path, command: str) -> str:
    """The page itself: all but its data."""
    from origami_lab.pages import page_text
    from origami_lab.tracking.tracker import commands_to_look

    budget = config.get("budget")
    own = ["origami-lab", str(folder / CONFIG), f"output={folder}", "resume=true"]
    longer = [*own, f"budget={2 * budget}"] if isinstance(budget, int) else own
    values = {
        "kind": "run",
        "task": task_name(str(config.get("task")), config.get("target")),
        "method": str(config.get("method")),
        "budget": budget,
        "made": command,
        "commands": {
            "go_on": command_text(own),
            "longer": command_text(longer),
            "folder": command_text([str(folder)]),
            "look": commands_to_look(config.get("tracking") or {}, folder),
        },
        "columns": SHOWN,
        "files": DESCRIBED,
        "settings": _settings_in_words(config),
    }
    return page_text(
        __package__,
        "run_page.html.jinja",
        values,
        scripts=[Path(__file__).with_name("run_page.js")],
    )


def _settings_in_words(config: Node) -> list[tuple[str, str]]:
    """What tells this run from others of its task and searcher, as it is most often asked."""
    board, symmetry = config.get("board"), config.get("symmetry")
    found: list[tuple[str, Any]] = [("budget", f"{config.get('budget'):,} interactions a trial")]
    if isinstance(board, Mapping):
        found.append(("board", " × ".join(str(board.get(side) or board.get("size")) for side in ("width", "height"))))
    if isinstance(symmetry, Mapping):
        found.append(("symmetry", symmetry.get("name")))
    if config.get("max_crease_length") is not None:
        found.append(("longest crease", f"{config.get('max_crease_length')} cells"))
    return [(name, str(value)) for name, value in found]


def write_run_page(path: Path) -> None:
    """Write the page of a run folder anew, from what is on disk; nothing happens if it cannot be."""
    folder = RunFolder(path)
    try:
        config, summary = folder.config(), read_summary(path)
        seeds = parse_seeds(0 if config.get("seed") is None else config["seed"])
        rows = folder.known_rows()
        page = RunPage(folder, config, len({*seeds, *rows}), str(summary.get("command") or ""))
        page.begin(rows.values())
        whole = all(seed in rows and rows[seed].outcome != STOPPED for seed in seeds)
        page.write(FINISHED if whole else STOPPED)
    except (OSError, ValueError, KeyError, TypeError):  # InputError is a ValueError
        return


def write_page_around(run: Path) -> Path | None:
    """Write the page of the multirun that a run is of, unless it has one that names all its jobs; that page."""
    from origami_lab.experiment.multirun_page import write_multirun_page
    from origami_lab.runs.multirun_folder import membership

    if membership(run) is None:
        return None
    write_multirun_page(run.absolute().parent)
    return run.absolute().parent / PAGE


def has_display() -> bool:
    """Whether a browser's window could be seen by whoever runs this."""
    if sys.platform in ("win32", "darwin"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_page(page: Path) -> None:
    """Open a page in the user's browser, where there is a display."""
    if has_display():
        with suppress(webbrowser.Error, OSError, ValueError):
            webbrowser.open(page.absolute().as_uri())
