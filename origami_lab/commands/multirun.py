"""Several experiments with ``-m``: one job of them, wherever a launcher runs it, and what all of them found."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from rich.console import Console

from origami_lab.commands.experiment import run_one
from origami_lab.errors import EXIT_FAILED, EXIT_INPUT, EXIT_OK, InputError

if TYPE_CHECKING:
    from omegaconf import DictConfig
    from rich.table import Table

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

        try:
            enter_job(config, _hydra(), self.folder, self.place)
            return run_one(config, self.arguments)
        except InputError as error:
            print(f"error: {error}", file=sys.stderr)
            return EXIT_INPUT, None

    def run_launched(self, config: DictConfig) -> float | None:
        """Run a job in a launcher's process, which may share its terminal with others; returns its mean return."""
        from origami_lab.experiment.composing import working_directory_importable
        from origami_lab.experiment.multirun import enter_job
        from origami_lab.experiment.runner import run_experiment
        from origami_lab.experiment.settings import read_settings

        # what the launcher set for itself, workers would be told to use, too, and need not know
        multiprocessing.set_start_method("spawn", force=True)
        name = enter_job(config, _hydra(), self.folder, self.place)
        with working_directory_importable():
            experiment = run_experiment(read_settings(config), _Labelled(name), ["origami-lab", *self.arguments])
        mean = experiment.summary["returns"].get("return")
        return None if mean is None else float(mean["mean"])

    def __enter__(self) -> Multirun:
        self._before = self._written()
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
        if "verbosity=quiet" not in self.arguments:
            console.print(_table(found, f"{len(found)} jobs · {index.experiment}"))
            console.print(f"to compare them: origami-lab report {self.folder}", highlight=False, soft_wrap=True)
        console.print(str(self.folder), highlight=False, soft_wrap=True)


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


def _table(found: Sequence[Outcome], title: str) -> Table:
    """One line a job; the best of each task is bold."""
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", header_style="bold", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("job", overflow="fold")
    for name in ("trials", "return", "best"):
        table.add_column(name, justify="right")
    shows_status = any(outcome.status != "ok" for outcome in found)
    if shows_status:
        table.add_column("status")
    best: dict[str, float] = {}
    for outcome in found:
        if outcome.spread is not None:
            best[outcome.job.task] = max(best.get(outcome.job.task, outcome.spread.mean), outcome.spread.mean)
    for outcome in found:
        spread, row = outcome.spread, outcome.best
        table.add_row(
            outcome.job.name,
            f"{outcome.done} of {outcome.asked}",
            "–" if spread is None else str(spread),
            "–" if row is None else f"{row['return']:.4f}",
            *([outcome.status] if shows_status else []),
            style="bold" if spread is not None and spread.mean == best[outcome.job.task] else None,
        )
    return table
