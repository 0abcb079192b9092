"""Several experiments with ``-m``: one job of them, wherever a launcher runs it, and what all of them found."""

from __future__ import annotations

import multiprocessing
import shlex
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from rich.console import Console

from origami_lab.errors import EXIT_FAILED, EXIT_INPUT, EXIT_OK, InputError
from origami_lab.experiment.api import run_one
from origami_lab.multirun.jobs_table import best_commands, jobs_title, table_of_jobs

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from origami_lab.workers.interrupts import Interrupts

MULTIRUN, OWN_OPTIONS = ("-m", "--multirun"), ("--config-dir", "-cd")


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
    _opened: bool = field(default=False, init=False)

    @property
    def sweep_dir(self) -> str:
        """The folder, for Hydra and its launchers."""
        from origami_lab.multirun.folder_of_command import SWEEP_DIR

        text = str(self.folder.absolute()).replace("'", "\\'")
        return f"{SWEEP_DIR}='{text}'"

    def run_job(self, config: DictConfig) -> tuple[int, float | None]:
        """Run a job in the command's own process; wrong input ends it, and not the others."""
        from origami_lab.multirun.check_jobs import enter_job
        from origami_lab.runs.multirun_folder import membership

        try:
            opens, self._opened = bool(config.open) and not self._opened, True
            found = membership(self.folder / enter_job(config, _hydra(), self.folder, self.place))
            config.open = opens  # the page of all jobs, which the first one writes
            if found is not None and not self.is_quiet:
                index, job = found
                Console(stderr=True).print(index.heading(job), style="bold", markup=False, soft_wrap=True)
            return run_one(config, self.arguments)
        except InputError as error:
            _say(f"error: {error}")
            return EXIT_INPUT, None

    def run_launched(self, config: DictConfig) -> float | None:
        """Run a job in a launcher's process, which may share its terminal with others; returns its mean return."""
        from origami_lab.config.compose import working_directory_importable
        from origami_lab.config.settings import read_settings
        from origami_lab.experiment.runner import run_experiment
        from origami_lab.multirun.check_jobs import enter_job
        from origami_lab.multirun.job_interrupts import following, marked
        from origami_lab.multirun.launchers import LAUNCHER, LAUNCHERS

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
        from origami_lab.multirun.job_interrupts import LauncherInterrupts

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
        from origami_lab.multirun.job_interrupts import clear_mark

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
        from origami_lab.runs.multirun_folder import INDEX

        file = self.folder / INDEX
        return file.stat().st_mtime_ns if file.is_file() else 0

    def _finish(self) -> None:
        """Write the table of all jobs, and print it."""
        from origami_lab.experiment.multirun_page import write_multirun_page
        from origami_lab.file_names import PAGE, TRACKING
        from origami_lab.files import write_whole
        from origami_lab.runs.multirun_folder import TABLE, outcomes, read_index, table_text

        index = read_index(self.folder)
        if index is None:
            return
        found = outcomes(self.folder, index)
        if any(outcome.status != "ok" for outcome in found):
            self.exit_code = EXIT_FAILED
        try:
            write_whole(self.folder / TABLE, table_text(found), sync=True)
        except OSError as error:
            _say(f"warning: {self.folder / TABLE} could not be written ({error.strerror})")
        with suppress(OSError):
            write_multirun_page(self.folder)
        console = Console()
        if not self.is_quiet:
            console.print(jobs_title(found, index.experiment), style="italic", highlight=False, soft_wrap=True)
            console.print(table_of_jobs(found, console))
            folder = shlex.quote(str(self.folder))
            lines = [f"to compare them: origami-lab report {folder}", *best_commands(found, self._flags())]
            if (self.folder / PAGE).is_file():
                lines.append(f"all of it: {self.folder / PAGE}")
            if self.exit_code:
                lines.append(f"to go on: {self._going_on()}")
            if self.left_at_once and any((self.folder / job.folder / TRACKING).is_file() for job in index.jobs):
                lines.append(f"to have MLflow know what ended: origami-lab dashboard --sync {folder}")
            for line in lines:
                console.print(line, highlight=False, markup=False, soft_wrap=True)
        console.print(str(self.folder), highlight=False, soft_wrap=True)

    def _flags(self) -> list[str]:
        """The flags that one of its jobs needs by itself: where options of the user's are."""
        flags = [word for word in self.arguments if word.startswith("-")]
        values = {flag: self.arguments[k + 1] for k, flag in enumerate(self.arguments[:-1]) if flag in OWN_OPTIONS}
        words = [[flag, values[flag]] if flag in values else [flag] for flag in flags if flag not in MULTIRUN]
        return [word for pair in words for word in pair]

    def _going_on(self) -> str:
        """The command that finishes the multirun."""
        from origami_lab.multirun.folder_of_command import SWEEP_DIR
        from origami_lab.text import command_text

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


def _say(line: str) -> None:
    """Tell the user a line, on stderr."""
    Console(stderr=True).print(line, highlight=False, markup=False, soft_wrap=True)
