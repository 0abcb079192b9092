"""`origami_lab.run`: the command from Python."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from origami_lab.addresses import hidden_word
from origami_lab.config.compose import check_texts, compose_settings, working_directory_importable
from origami_lab.errors import InputError
from origami_lab.experiment.runner import Experiment, run_experiment
from origami_lab.files import expanded
from origami_lab.runs.result import Result

if TYPE_CHECKING:
    from omegaconf import DictConfig
    from rich.console import Console

    from origami_lab.config.settings import Settings
    from origami_lab.experiment.trial_process import TrialProcess


def run(overrides: Sequence[str] = (), *, config_dir: str | os.PathLike[str] | None = None) -> Result:
    """Run one experiment: what ``origami-lab OVERRIDES`` does, with the same files and the same results.

    Needs no ``if __name__ == "__main__"`` and works in a notebook, in a thread, and beside a Hydra of your own.
    What the command says goes to stderr; ``verbosity=quiet`` leaves warnings only.

    Ctrl-C is the command's: the first one saves the best so far of the trials that run, and the result has exit
    code 130; the second one, or one before the trials have begun, raises ``KeyboardInterrupt``.

    Parameters
    ----------
    overrides
        The arguments of the command, e.g. ``["target=bowl", "search=bfts", "seed=0..3"]``. No flags.
    config_dir
        A folder with options of your own, like ``--config-dir``.

    Returns
    -------
    The run's table, designs and folder. Its ``exit_code`` is 1 if a trial failed: that does not raise.

    Raises
    ------
    InputError
        A ``ValueError`` with the command's one line, before anything is written.
    """
    from rich.console import Console

    given = [hidden_word(text) for text in _checked(overrides)]
    own = None if config_dir is None else expanded(config_dir)
    if own is not None and not own.is_dir():
        raise InputError("config_dir", own, "there is no such folder")
    command = ["origami-lab", *given, *(["--config-dir", str(own)] if own else [])]
    console = Console(stderr=True)
    with working_directory_importable():
        settings = compose_settings(given, own)
        experiment = run_experiment(settings, console, command)
    show_results(console, settings, experiment)
    if experiment.left_at_once:
        raise KeyboardInterrupt  # or a loop over experiments would go on to the next
    return Result(experiment.folder.absolute(), experiment.exit_code)


def show_results(console: Console, settings: Settings, experiment: Experiment) -> None:
    """Print the table of trials and how to look at them, unless the run is to be quiet."""
    if settings.verbosity == "quiet" or not experiment.rows:
        return
    from origami_lab.experiment.terminal_table import (
        certificate_lines,
        end_lines,
        figure_lines,
        hint,
        places_line,
        polish_lines,
        summary_table,
        surface_line,
        where_lines,
    )
    from origami_lab.tracking.store import how_to_look
    from origami_lab.tracking.tracker import store_of

    title = f"{settings.task} · {settings.method} · {settings.budget:,} interactions a trial"
    console.print(summary_table(experiment.rows, title, console.width))
    rows = experiment.rows
    lines = [*end_lines(rows), *certificate_lines(rows), places_line(rows), surface_line(rows), hint(rows)]
    if settings.tracking.kind == "mlflow":
        lines.append(f"to compare it: {how_to_look(store_of(settings, experiment.folder))}")
    for line in (*lines, *figure_lines(rows), *polish_lines(rows), *where_lines(rows, experiment.folder)):
        if line:
            console.print(line, highlight=False, markup=False, soft_wrap=True)


def _checked(overrides: Sequence[str]) -> list[str]:
    """The overrides of one run; what else the command takes is refused."""
    texts = check_texts(overrides)
    for text in texts:
        if text in ("-m", "--multirun"):
            raise InputError("overrides", text, "must be one experiment; call run once for each")
        if text.startswith("-"):
            raise InputError("overrides", text, "flags are the command's; run takes settings, and config_dir=DIR")
        if "=" not in text and not text.startswith("~"):
            raise InputError("overrides", text, "must be settings like target=bowl")
    return texts


def run_one(
    config: DictConfig, arguments: Sequence[str], early: TrialProcess | None = None
) -> tuple[int, float | None]:
    """Run one experiment and print what it found; returns the exit code and the mean return.

    Parameters
    ----------
    early
        A worker that has begun to import already, to be the first.
    """
    from rich.console import Console

    from origami_lab.config.settings import read_settings
    from origami_lab.experiment.runner import run_experiment

    console, errors = Console(), Console(stderr=True)
    settings = read_settings(config)
    experiment = run_experiment(settings, errors, ["origami-lab", *arguments], early=early)
    show_results(console, settings, experiment)
    console.print(str(experiment.folder), highlight=False, soft_wrap=True)
    mean = experiment.summary["returns"].get("return")
    return experiment.exit_code, None if mean is None else mean["mean"]
