"""The folder of a multirun, from what was typed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from hydra.core.utils import setup_globals
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.multirun.launchers import typed_value
from origami_lab.runs.multirun_folder import INDEX
from origami_lab.runs.run_folder import RESULTS, fresh_folder

MULTIRUNS = RESULTS / "multirun"


RUN_DIR, SWEEP_DIR = "hydra.run.dir", "hydra.sweep.dir"
"""Hydra's names for the folder of a run and of a multirun."""


def own_words(overrides: Sequence[str], several: bool) -> list[str]:
    """The overrides with ``output`` for Hydra's name of a run's folder.

    Raises
    ------
    InputError
        If they set something of Hydra's that would be without effect.
    """
    if (value := typed_value(overrides, RUN_DIR)) is not None and several:
        raise InputError(RUN_DIR, value, "is the folder of one run; that of a multirun is given as output=DIR")
    if (there := typed_value(overrides, SWEEP_DIR)) is not None and not several:
        raise InputError(SWEEP_DIR, there, "is the folder of a multirun, -m; that of one run is given as output=DIR")
    if (below := typed_value(overrides, "hydra.sweep.subdir")) is not None:
        expected = "cannot be chosen: the folders of a multirun's jobs are named by what differs"
        raise InputError("hydra.sweep.subdir", below, expected)
    if typed_value(overrides, "hydra.job.chdir") is True:
        raise InputError("hydra.job.chdir", "true", "must be false: paths are meant from where the command is typed")
    if value is None:
        return list(overrides)
    if typed_value(overrides, "output") is not None:
        raise InputError(RUN_DIR, value, "is the same thing as output; give one of them")
    folder = str(_folder(RUN_DIR, value)).replace("\\", "\\\\").replace("'", "\\'")
    kept = [word for word in overrides if word.partition("=")[0].lstrip("+") not in (RUN_DIR, "output")]
    return [*kept, f"output='{folder}'"]


@contextmanager
def multirun_folder(overrides: Sequence[str]) -> Iterator[Path]:
    """The folder of a multirun as typed, or a new one below results/; one in which nothing was written vanishes.

    Parameters
    ----------
    overrides
        Of the command, as Hydra reads them.

    Raises
    ------
    InputError
        If it is not one folder, or cannot be made.
    """
    given = [_folder(key, value) for key in ("output", SWEEP_DIR) if (value := typed_value(overrides, key)) is not None]
    if len(given) > 1:
        raise InputError(SWEEP_DIR, given[1], "is the same thing as output in a multirun; give one of them")
    if given:
        yield given[0]
        return
    if typed_value(overrides, "resume") is True:
        last = max(MULTIRUNS.glob(f"*/{INDEX}"), default=None)
        hint = f", e.g. output={last.parent}" if last else ""
        raise InputError("resume", "true", f"must come with the multirun's folder to finish, output=DIR{hint}")
    try:
        folder = fresh_folder(MULTIRUNS, datetime.now())
    except OSError as error:
        raise InputError("output", MULTIRUNS, f"must be a folder that can be written ({error.strerror})") from error
    try:
        yield folder
    finally:
        with suppress(OSError):
            for empty in (folder, MULTIRUNS, RESULTS):
                empty.rmdir()


def _folder(key: str, value: Any) -> Path:
    setup_globals()  # for ${now:...}
    try:
        return expanded(str(OmegaConf.create({"folder": str(value)}).folder))
    except OmegaConfBaseException:
        expected = "must be one folder for all jobs; each gets one below it, named by what differs"
        raise InputError(key, value, expected) from None
