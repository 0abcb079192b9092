"""Hydra's multirun (``-m``): every job is checked before the first one starts."""

from __future__ import annotations

from typing import Any

from hydra import compose
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, open_dict

from origami_lab.experiment.build import build_parts
from origami_lab.experiment.settings import fit_workers, read_settings
from origami_lab.experiment.tracking import check_tracking


class RefusedJobs(BaseException):
    """A job of a multirun is wrong. No ``Exception``: Hydra turns those of callbacks into warnings."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


class CheckJobs(Callback):
    """Check the input of every job, so that the ninth does not fail on a typo after eight have run."""

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        name = config.hydra.job.config_name
        overrides = OverridesParser.create().parse_overrides(list(config.hydra.overrides.task))
        try:
            for batch in BasicSweeper.split_arguments(overrides, max_batch_size=None):
                for job in batch:
                    composed = compose(name, overrides=job, return_hydra_config=True)
                    HydraConfig.instance().set_config(composed)
                    settings = fit_workers(read_settings(without_hydra(composed)))
                    check_tracking(settings)
                    build_parts(settings)
        except Exception as error:
            raise RefusedJobs(error) from error


def without_hydra(config: DictConfig) -> DictConfig:
    """The task's part of a configuration composed with Hydra's own."""
    with open_dict(config):
        del config["hydra"]
    return config
