"""`origami_lab.run`: the command from Python."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from origami_lab.errors import InputError
from origami_lab.experiment.composing import check_texts, compose_settings, working_directory_importable
from origami_lab.experiment.result import Result
from origami_lab.experiment.runner import Experiment, run_experiment

if TYPE_CHECKING:
    from rich.console import Console

    from origami_lab.experiment.settings import Settings


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

    given = _checked(overrides)
    own = None if config_dir is None else Path(config_dir).expanduser()
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
    from origami_lab.experiment.stores import how_to_look
    from origami_lab.experiment.tracking import store_of
    from origami_lab.reporting.tables import certificate_lines, hint, summary_table

    title = f"{settings.task} · {settings.method} · {settings.budget:,} interactions a trial"
    console.print(summary_table(experiment.rows, title, console.width))
    for line in certificate_lines(experiment.rows):
        console.print(line, highlight=False, soft_wrap=True)
    if advice := hint(experiment.rows):
        console.print(advice, highlight=False, soft_wrap=True)
    if settings.tracking["kind"] == "mlflow":
        console.print(f"to look at it: {how_to_look(store_of(settings, experiment.folder))}", highlight=False)


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
