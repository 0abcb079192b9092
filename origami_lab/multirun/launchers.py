"""Hydra's launchers: which there are, what each needs, and the settings that a multirun gives them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig

from origami_lab.errors import InputError
from origami_lab.machine import usable_cores

LAUNCHER = "hydra/launcher"


@dataclass(frozen=True)
class Launcher:
    """A launcher: a package for Hydra that runs jobs elsewhere than in the command's own process."""

    package: str
    extra: str
    """Which extra of ours brings it."""
    settings: tuple[str, ...] = ()
    """Where its own defaults do not suit: what stands in front of the command's own settings."""
    local: bool = False
    """Whether its jobs are processes of this terminal, which hear its Ctrl-C, too."""


_DAY = "hydra.launcher.timeout_min=1440"


LAUNCHERS = {
    "joblib": Launcher("hydra_plugins.hydra_joblib_launcher", "cluster", local=True),
    "submitit_local": Launcher(
        "hydra_plugins.hydra_submitit_launcher",
        "cluster",
        # a folder for each number of a job's, as for SLURM, is made under that very name here, and stays empty
        (_DAY, "hydra.launcher.submitit_folder='${hydra.sweep.dir}/.submitit'"),
        local=True,
    ),
    "submitit_slurm": Launcher(
        "hydra_plugins.hydra_submitit_launcher",
        "cluster",
        # jobs that run out of time are queued again: they go on where they were
        (_DAY, "hydra.launcher.max_num_timeout=20", "hydra.launcher.cpus_per_task=4", "hydra.launcher.mem_gb=8"),
    ),
    "ray": Launcher(
        "hydra_plugins.hydra_ray_launcher",
        "ray",
        # the package asks for a size of Ray's memory unless there is a value, and clusters refuse to be asked
        ("++hydra.launcher.ray.init.logging_level=warning", "++hydra.launcher.ray.init.object_store_memory=null"),
    ),
}


def launcher_settings(overrides: Sequence[str]) -> tuple[str, ...]:
    """Settings to put in front of a command's own for the launcher that it names.

    Raises
    ------
    InputError
        If the launcher's package is not there.
    """
    name = typed_value(overrides, LAUNCHER)
    launcher = LAUNCHERS.get(str(name))
    if launcher is None:
        return ()
    with suppress(ModuleNotFoundError):
        if find_spec(launcher.package) is not None:
            return launcher.settings
    raise InputError(LAUNCHER, name, f"needs pip install 'origami-lab[{launcher.extra}]'")


def has_local_jobs(overrides: Sequence[str]) -> bool:
    """Whether a command's launcher runs its jobs as other processes of the same terminal."""
    launcher = LAUNCHERS.get(str(typed_value(overrides, LAUNCHER)))
    return launcher is not None and launcher.local


def typed_value(overrides: Sequence[str], key: str) -> Any:
    """The value that the command gives for a key; None if none."""
    texts = [text for text in overrides if text.partition("=")[0].lstrip("+") == key]
    if not texts:
        return None
    override = OverridesParser.create().parse_override(texts[-1])
    if override.is_sweep_override():
        raise InputError(key, texts[-1].partition("=")[2], "must be one for all jobs")
    return override.value()


def cores_of_job(launcher: DictConfig) -> int | None:
    """The cores that workers=auto takes in a job of a launcher; None for all that the process may use."""
    if "n_jobs" in launcher:  # joblib: so many jobs share the machine
        jobs = int(launcher.n_jobs)
        cores = usable_cores()
        return max(1, cores // (jobs if jobs > 0 else max(1, cores + 1 + jobs)))
    if "ray" in launcher:  # Ray counts cores and pins nothing
        return int((launcher.ray.get("remote") or {}).get("num_cpus") or 1)
    asked = launcher.get("cpus_per_task")  # not every cluster of SLURM's pins
    return None if asked is None else int(asked)
