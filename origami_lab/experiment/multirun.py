"""Hydra's multirun (``-m``): every job is checked before the first one starts, and all get folders below one."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hydra import compose
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.core.utils import setup_globals
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, ListConfig, OmegaConf, open_dict
from omegaconf.errors import OmegaConfBaseException

from origami_lab.errors import InputError
from origami_lab.experiment.build import build_parts
from origami_lab.experiment.folder import RESULTS, fresh_folder
from origami_lab.experiment.machine import usable_cores
from origami_lab.experiment.multirun_folder import INDEX, Index, begun_seeds, new_index, read_index, write_index
from origami_lab.experiment.seeds import format_seeds, parse_seeds
from origami_lab.experiment.settings import fit_workers, read_settings
from origami_lab.experiment.tracking import check_tracking

MULTIRUNS = RESULTS / "multirun"
SWEEP_DIR = "hydra.sweep.dir"
LAUNCHER = "hydra/launcher"


@dataclass(frozen=True)
class Launcher:
    """What runs the jobs elsewhere than in the command's own process: a package for Hydra."""

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


class RefusedJobs(BaseException):
    """A job of a multirun is wrong. No ``Exception``: Hydra turns those of callbacks into warnings."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


class CheckJobs(Callback):
    """Check the input of every job, so that the ninth does not fail on a typo after eight have run; then index them."""

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        try:
            jobs = _jobs(config)
            if jobs is None:
                return
            folder = Path(str(config.hydra.sweep.dir))
            index = _checked(config.hydra.job.config_name, jobs, folder)
            folder.mkdir(parents=True, exist_ok=True)
            write_index(folder, index)
        except Exception as error:
            raise RefusedJobs(error) from error


def _jobs(config: DictConfig) -> list[list[str]] | None:
    """The overrides of each job; None if the sweeper is not Hydra's own and makes them up as it goes."""
    if not _lists_its_jobs(config.hydra):
        return None
    texts = [f"{key}={value}" for key, value in (config.hydra.sweeper.get("params") or {}).items()]
    parser = OverridesParser.create(config_loader=GlobalHydra.instance().config_loader())
    overrides = parser.parse_overrides([*texts, *_as_typed(config.hydra.overrides.task)])
    for override in overrides:
        if override.is_discrete_sweep():
            _check_values(override)
    return [job for batch in BasicSweeper.split_arguments(overrides, max_batch_size=None) for job in batch]


def _lists_its_jobs(hydra: DictConfig) -> bool:
    return str(hydra.sweeper._target_).endswith("BasicSweeper")


def _as_typed(overrides: ListConfig) -> list[str]:
    """The overrides of a job; what they refer to (``${board.size}``) may have another value in each job."""
    found = OmegaConf.to_container(overrides, resolve=False)
    assert isinstance(found, list)
    return found


def _check_values(override: Override) -> None:
    """Raise InputError unless an override names values, and each once."""
    values = list(override.sweep_string_iterator())
    text = str(override.input_line).partition("=")[2]
    if not values:
        raise InputError(override.get_key_element(), text, "names no value, so that there is no job to run")
    twice = [value for value, times in Counter(values).items() if times > 1]
    if twice:
        raise InputError(
            override.get_key_element(), text, f"names {twice[0]} more than once; every job must be another one"
        )


def _checked(name: str, jobs: Sequence[Sequence[str]], folder: Path) -> Index:
    """The index with the jobs, their tasks, searchers and seeds; raises for the first that cannot run."""
    configs = [compose(name, overrides=list(overrides), return_hydra_config=True) for overrides in jobs]
    seeds = []
    for composed in configs:
        HydraConfig.instance().set_config(composed)
        seeds.append(parse_seeds(0 if (seed := composed.get("seed")) is None else _plain(seed)))
    index = (read_index(folder) or new_index(folder)).planned(jobs, seeds)
    found = list(index.jobs)
    for overrides, composed in zip(jobs, configs, strict=True):
        HydraConfig.instance().set_config(composed)
        config = without_hydra(composed)
        job = index.find(overrides)
        assert job is not None
        if config.output is not None and Path(str(config.output)).absolute() != folder:
            raise InputError("output", config.output, "must be given on the command line in a multirun, for all jobs")
        if not config.resume and folder.exists() and any(folder.iterdir()):
            raise InputError("output", folder, "must be a new or empty folder; resume=true finishes the multirun in it")
        if config.resume and folder.exists() and any(folder.iterdir()) and read_index(folder) is None:
            raise InputError("output", folder, f"must be the folder of a multirun, there is no {INDEX} in it")
        config.output = str(folder / job.folder)
        settings = fit_workers(read_settings(config))
        check_tracking(settings)
        build_parts(settings)
        there = begun_seeds(folder / job.folder)
        asked = settings.seeds if settings.seeds_given or not there else ()
        holds = format_seeds(sorted({*asked, *there}) if there else asked)
        found[found.index(job)] = replace(job, task=settings.task, method=settings.method, seeds=holds)
    return replace(index, jobs=tuple(found))


def _plain(value: Any) -> Any:
    return OmegaConf.to_container(value) if OmegaConf.is_config(value) else value


def launcher_settings(overrides: Sequence[str]) -> tuple[str, ...]:
    """What to put in front of a command's settings for the launcher that it names.

    Raises
    ------
    InputError
        If the launcher's package is not there.
    """
    name = _value(overrides, LAUNCHER)
    launcher = LAUNCHERS.get(str(name))
    if launcher is None:
        return ()
    with suppress(ModuleNotFoundError):
        if find_spec(launcher.package) is not None:
            return launcher.settings
    raise InputError(LAUNCHER, name, f"needs pip install 'origami-lab[{launcher.extra}]'")


def has_local_jobs(overrides: Sequence[str]) -> bool:
    """Whether a command's launcher runs its jobs as other processes of the same terminal."""
    launcher = LAUNCHERS.get(str(_value(overrides, LAUNCHER)))
    return launcher is not None and launcher.local


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
    given = [_folder(key, value) for key in ("output", SWEEP_DIR) if (value := _value(overrides, key)) is not None]
    if len(given) > 1:
        raise InputError(SWEEP_DIR, given[1], "is the same thing as output in a multirun; give one of them")
    if given:
        yield given[0]
        return
    if _value(overrides, "resume") is True:
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


def _value(overrides: Sequence[str], key: str) -> Any:
    """What the command says for a key; None if nothing."""
    texts = [text for text in overrides if text.partition("=")[0].lstrip("+") == key]
    if not texts:
        return None
    override = OverridesParser.create().parse_override(texts[-1])
    if override.is_sweep_override():
        raise InputError(key, texts[-1].partition("=")[2], "must be one for all jobs")
    return override.value()


def _folder(key: str, value: Any) -> Path:
    setup_globals()  # for ${now:...}
    try:
        return Path(str(OmegaConf.create({"folder": str(value)}).folder)).expanduser()
    except OmegaConfBaseException:
        expected = "must be one folder for all jobs; each gets one below it, named by what differs"
        raise InputError(key, value, expected) from None


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


def enter_job(config: DictConfig, hydra: DictConfig, folder: Path, place: Path) -> str:
    """Prepare the configuration of one job of a multirun, in whatever process it runs.

    Parameters
    ----------
    config
        The job's configuration; its ``output``, ``resume`` and ``workers`` are set.
    hydra
        Hydra's part of it.
    folder
        The multirun's folder.
    place
        The working directory of the command.

    Returns
    -------
    The name of the job's folder.
    """
    if Path.cwd() != place:
        os.chdir(place)
    index, overrides = read_index(folder), _as_typed(hydra.overrides.task)
    job = index.find(overrides) if index else None
    if job is None and _lists_its_jobs(hydra):
        raise InputError("output", folder, f"has no job {' '.join(overrides)} in its {INDEX}; start anew")
    # a sweeper that makes up its jobs as it goes has them numbered
    name = job.folder if job else str(hydra.job.num)
    config.output = str(folder / name)
    # a job that a cluster starts again, because its node died, goes on
    config.resume = (folder / name / "config.yaml").is_file()
    cores = cores_of_job(hydra.launcher)
    if cores is not None and config.workers == "auto":
        config.workers = cores
    return name


def without_hydra(config: DictConfig) -> DictConfig:
    """The task's part of a configuration composed with Hydra's own."""
    with open_dict(config):
        del config["hydra"]
    return config
