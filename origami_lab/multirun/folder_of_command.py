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


SWEEP_DIR = "hydra.sweep.dir"


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
