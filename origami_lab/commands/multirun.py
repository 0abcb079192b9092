"""Several experiments with ``-m``: one job of them, wherever a launcher runs it, and what all of them found."""

from __future__ import annotations

import multiprocessing
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from rich.console import Console
from rich.text import Text

from origami_lab.commands.experiment import run_one
from origami_lab.errors import EXIT_FAILED, EXIT_INPUT, EXIT_OK, InputError

if TYPE_CHECKING:
    from omegaconf import DictConfig
    from rich.table import Table

    from origami_lab.experiment.interrupts import Interrupts
    from origami_lab.experiment.multirun_folder import Outcome


@dataclass
class Multirun:
    """A multirun, as a context in which its jobs run; a summary of those that have ended is printed at the end."""

    folder: Path
    """As typed."""
    place: Path
    """The command's working directory."""
    arguments: Sequence[str]
    exit_code: int = EXIT_OK
    """1 if a job is not complete; known at the end."""
    left_at_once: bool = False
    """Whether a second Ctrl-C ended jobs where they were."""
    _before: int = field(default=0, init=False)

    @property
    def sweep_dir(self) -> str:
        """The folder, for Hydra and its launchers."""
        from origami_lab.experiment.multirun import SWEEP_DIR

        text = str(self.folder.absolute()).replace("'", "\\'")
        return f"{SWEEP_DIR}='{text}'"

    def run_job(self, config: DictConfig) -> tuple[int, float | None]:
        """Run a job in the command's own process; wrong input ends it, and not the others."""
        from origami_lab.experiment.multirun import enter_job
        from origami_lab.experiment.multirun_folder import membership

        try:
            found = membership(self.folder / enter_job(config, _hydra(), self.folder, self.place))
            if found is not None and not self.is_quiet:
                index, job = found
                Console(stderr=True).print(index.heading(job), style="bold", markup=False, soft_wrap=True)
            return run_one(config, self.arguments)
        except InputError as error:
            print(f"error: {error}", file=sys.stderr)
            return EXIT_INPUT, None

    def run_launched(self, config: DictConfig) -> float | None:
        """Run a job in a launcher's process, which may share its terminal with others; returns its mean return."""
        from origami_lab.experiment.composing import working_directory_importable
        from origami_lab.experiment.multirun import LAUNCHER, LAUNCHERS, enter_job
        from origami_lab.experiment.multirun_interrupts import following, marked
        from origami_lab.experiment.runner import run_experiment
        from origami_lab.experiment.settings import read_settings

        # what the launcher set for itself, workers would be told to use, too, and need not know
        multiprocessing.set_start_method("spawn", force=True)
        hydra = _hydra()
        launcher = LAUNCHERS.get(str(hydra.runtime.choices.get(LAUNCHER)))
        folder = self.place / self.folder
        if launcher is None or not launcher.local:
            follows: AbstractContextManager[Interrupts | None] = nullcontext()
        elif marked(folder):
            return None
        else:
            follows = following(folder)
        name = enter_job(config, hydra, self.folder, self.place)
        try:
            with follows as interrupts, working_directory_importable():
                command = ["origami-lab", *self.arguments]
                experiment = run_experiment(read_settings(config), _Labelled(name), command, interrupts)
        except KeyboardInterrupt:
            if interrupts is None:
                raise
            return None  # before its first trial; launchers would take it for a death
        mean = experiment.summary["returns"].get("return")
        return None if mean is None else float(mean["mean"])

    @contextmanager
    def listening(self) -> Iterator[None]:
        """While jobs are processes of the same terminal: Ctrl-C ends them as it does without a launcher."""
        from origami_lab.experiment.multirun_interrupts import LauncherInterrupts

        def say(line: str) -> None:
            Console(stderr=True).print(line, highlight=False, soft_wrap=True)

        interrupts = LauncherInterrupts(self.folder, lambda: self.started, say)
        try:
            with interrupts:
                yield
        finally:
            self.left_at_once = interrupts.count > 1
        if interrupts.count:
            raise KeyboardInterrupt

    @property
    def is_quiet(self) -> bool:
        return "verbosity=quiet" in self.arguments

    def __enter__(self) -> Multirun:
        from origami_lab.experiment.multirun_interrupts import clear_mark

        self._before = self._written()
        clear_mark(self.folder)
        return self

    def __exit__(self, *_: object) -> None:
        if self.started:
            self._finish()

    @property
    def started(self) -> bool:
        """Whether all jobs were checked and the first one was started."""
        return self._written() != self._before

    def _written(self) -> int:
        from origami_lab.experiment.multirun_folder import INDEX

        file = self.folder / INDEX
        return file.stat().st_mtime_ns if file.is_file() else 0

    def _finish(self) -> None:
        """Write the table of all jobs, and print it."""
        from origami_lab.experiment.folder import write_atomically
        from origami_lab.experiment.multirun_folder import TABLE, outcomes, read_index, table_text
        from origami_lab.experiment.note import NOTE

        index = read_index(self.folder)
        if index is None:
            return
        found = outcomes(self.folder, index)
        if any(outcome.status != "ok" for outcome in found):
            self.exit_code = EXIT_FAILED
        try:
            write_atomically(self.folder / TABLE, table_text(found))
        except OSError as error:
            print(f"warning: {self.folder / TABLE} could not be written ({error.strerror})", file=sys.stderr)
        console = Console()
        if not self.is_quiet:
            console.print(_title(found, index.experiment), style="italic", highlight=False, soft_wrap=True)
            console.print(_table(found, console))
            folder = shlex.quote(str(self.folder))
            lines = [f"to compare them: origami-lab report {folder}"]
            if self.exit_code:
                lines.append(f"to go on: {self._going_on()}")
            if self.left_at_once and any((self.folder / job.folder / NOTE).is_file() for job in index.jobs):
                lines.append(f"to have MLflow know what ended: origami-lab dashboard --sync {folder}")
            for line in lines:
                console.print(line, highlight=False, markup=False, soft_wrap=True)
        console.print(str(self.folder), highlight=False, soft_wrap=True)

    def _going_on(self) -> str:
        """The command that finishes the multirun."""
        from origami_lab.experiment.multirun import SWEEP_DIR
        from origami_lab.experiment.stores import command_text

        place = ("output", "resume", SWEEP_DIR)
        words = [word for word in self.arguments if word.partition("=")[0] not in place]
        return command_text(["origami-lab", *words, f"output={self.folder}", "resume=true"])


def _hydra() -> DictConfig:
    """Hydra's part of the configuration of the job that runs."""
    from hydra.core.hydra_config import HydraConfig

    return cast("DictConfig", HydraConfig.get())


class _Labelled(Console):
    """Plain lines on stderr that say which job they are of."""

    def __init__(self, label: str) -> None:
        super().__init__(stderr=True, force_terminal=False)
        self.label = label

    def print(self, *objects: Any, **options: Any) -> None:
        super().print(f"{self.label}:", *objects, **options)


def _title(found: Sequence[Outcome], experiment: str) -> str:
    """What all jobs have in common."""
    names = ({getattr(outcome.job, kind) for outcome in found} for kind in ("task", "method"))
    common = [next(iter(values)) for values in names if len(values) == 1]
    return " · ".join([f"{len(found)} job{'' if len(found) == 1 else 's'}", *common, experiment])


def _table(found: Sequence[Outcome], console: Console) -> Table:
    """One line a job, by what tells it from the others; the best of each task is bold."""
    from rich.measure import Measurement

    wide = console.options.update(width=10_000)
    for shown in (("return", "best"), ("return",)):
        table = _table_of(found, shown)
        if Measurement.get(console, wide, table).maximum <= console.width:
            break
    return table


def _table_of(found: Sequence[Outcome], shown: Sequence[str]) -> Table:
    from rich import box
    from rich.table import Table

    tasks, methods = ({getattr(outcome.job, name) for outcome in found} for name in ("task", "method"))
    table = Table(header_style="bold", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("job", overflow="fold")
    shows_status = any(outcome.status != "ok" for outcome in found)
    for name in ("trials", *shown):
        table.add_column(name, justify="right")
    if shows_status:
        table.add_column("status")
    best: dict[str, float] = {}
    for outcome in found:
        if outcome.spread is not None:
            best[outcome.job.task] = max(best.get(outcome.job.task, outcome.spread.mean), outcome.spread.mean)
    for outcome in found:
        job, spread, row = outcome.job, outcome.spread, outcome.best
        named = [*job.own, *([job.task] if len(tasks) > 1 else []), *([job.method] if len(methods) > 1 else [])]
        figures = {
            "return": "–" if spread is None else str(spread),
            "best": "–" if row is None else f"{row['return']:.4f}",
        }
        table.add_row(
            Text(" · ".join(named) or job.name),
            f"{outcome.done} of {outcome.asked}",
            *(figures[name] for name in shown),
            *([outcome.status] if shows_status else []),
            style="bold" if spread is not None and spread.mean == best[job.task] else None,
        )
    return table
