"""A run's own configuration, read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError  # type: ignore[import-untyped]

from origami_lab.config.bounded_yaml import yaml_text
from origami_lab.config.checked_files import check_interpolations
from origami_lab.errors import InputError
from origami_lab.text import first_line


def read_config_file(field: str, file: Path) -> dict[str, Any]:
    """The content of a run's config.yaml.

    Raises
    ------
    InputError
        If it cannot be read, or holds something else than settings.
    """
    try:
        config = OmegaConf.create(yaml_text(field, file))
        check_interpolations(field, OmegaConf.to_container(config, resolve=False))
        container = OmegaConf.to_container(config, resolve=True)
    except InputError:
        raise
    except (ValueError, RecursionError, OmegaConfBaseException, YAMLError) as error:
        raise InputError(field, file, f"cannot be read ({first_line(str(error))})") from error
    if not isinstance(container, dict):
        raise InputError(field, file, "must be the configuration of a run")
    return {str(key): value for key, value in container.items()}
