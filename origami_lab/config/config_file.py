"""A run's own configuration, as it is written and read back."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError  # type: ignore[import-untyped]

from origami_lab.config.bounded_yaml import yaml_text
from origami_lab.config.checked_files import check_interpolations
from origami_lab.config.node import Node
from origami_lab.errors import InputError
from origami_lab.text import first_line, one_line

WHOSE_CODE = (
    "a _target_ is called if it is a part of origami-lab's or of your own: what lies in the folder in which you run",
    "this is trusted",
)
"""What the head of each written configuration says."""


def config_text(head: Sequence[str], config: Node) -> str:
    """A configuration as a file that runs again, below lines that say what it is."""
    lines = [f"# {one_line(line)}\n" for line in (*head, *WHOSE_CODE)]
    return "".join(lines) + OmegaConf.to_yaml(OmegaConf.create(dict(config)))


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
