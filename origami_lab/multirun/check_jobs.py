"""Hydra's multirun (``-m``): every job is checked before the first one starts, and all get folders below one."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hydra import compose
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, ListConfig, OmegaConf

from origami_lab.config.compose import without_hydra
from origami_lab.config.instantiate import build_parts
from origami_lab.config.seeds import format_seeds, parse_seeds
from origami_lab.config.settings import fit_workers, read_settings
from origami_lab.errors import InputError
from origami_lab.files import require_no_link
from origami_lab.multirun.launchers import cores_of_job
from origami_lab.runs.multirun_folder import INDEX, Index, begun_seeds, new_index, read_index, write_index
from origami_lab.tracking.tracker import check_tracking


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
        config.output = str(_job_folder(folder, job.folder))
        settings = fit_workers(read_settings(config))
        check_tracking(settings)
        build_parts(settings)
        there = begun_seeds(folder / job.folder)
        asked = settings.seeds if settings.seeds_given or not there else ()
        holds = format_seeds(sorted({*asked, *there}) if there else asked)
        found[found.index(job)] = replace(job, task=settings.task, method=settings.method, seeds=holds)
    return replace(index, jobs=tuple(found))


def _job_folder(folder: Path, name: str) -> Path:
    """The folder of a job in that of the multirun; raises InputError if it is a link to another one."""
    try:
        return require_no_link(folder, name)
    except OSError as error:
        raise InputError("output", folder, f"cannot be used: {error.strerror}") from error


def _plain(value: Any) -> Any:
    return OmegaConf.to_container(value) if OmegaConf.is_config(value) else value


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
    config.output = str(_job_folder(folder, name))
    # a job that a cluster starts again, because its node died, goes on
    config.open = False  # that of the multirun is opened, once
    config.resume = (folder / name / "config.yaml").is_file()
    cores = cores_of_job(hydra.launcher)
    if cores is not None and config.workers == "auto":
        config.workers = cores
    return name
