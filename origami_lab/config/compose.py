"""A configuration composed from overrides without Hydra's application: for Python, and for looking things up.

Hydra keeps what it does in global objects. Here its loader is used by itself, and the two globals that it does need
(for ``${hydra:...}`` and for its version) are put back, so that a program may have a Hydra of its own.
"""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from omegaconf import DictConfig, open_dict

from origami_lab.config.checked_files import check_typed, only_checked_files
from origami_lab.config.hydra_errors import explain, find_culprit
from origami_lab.config.option_files import CONFIG_NAME, config_dir, groups
from origami_lab.config.settings import Settings, read_settings
from origami_lab.errors import InputError

if TYPE_CHECKING:
    from omegaconf import DictConfig

_HYDRA = threading.Lock()
"""Held while Hydra's globals are ours."""


def compose_settings(overrides: Sequence[str], own: Path | None = None) -> Settings:
    """The settings of one experiment, as the command reads them from the same overrides.

    Parameters
    ----------
    overrides
        Hydra overrides of one run, e.g. ``target=bowl``.
    own
        A folder with options of the user's own, like ``--config-dir``.

    Raises
    ------
    InputError
        In the words of the command.
    """

    try:
        with _composed(overrides, own) as config:
            return read_settings(without_hydra(config))
    except InputError:
        raise
    except Exception as error:
        raise explain(error, overrides, known_keys) or find_culprit(overrides) or error from None


def check_texts(overrides: Sequence[str]) -> list[str]:
    """The overrides as a list; raises InputError for anything but texts, one text that was to be a list included."""
    texts = [overrides] if isinstance(overrides, str) else list(overrides)
    if isinstance(overrides, str) or not all(isinstance(text, str) for text in texts):
        raise InputError("overrides", overrides, 'must be a list of texts like ["target=bowl", "start.size=2"]')
    return texts


def known_keys() -> list[str]:
    """All keys and groups, to suggest one for a typo."""
    from omegaconf import OmegaConf

    from origami_lab.config.node import flatten

    try:
        with _composed([], None) as config:
            container = OmegaConf.to_container(without_hydra(config), resolve=False)
    except Exception:
        return []
    assert isinstance(container, dict)
    names = [group for group in groups() if group != "hydra"]
    return [*names, *flatten({str(key): value for key, value in container.items()})]


@contextmanager
def _composed(overrides: Sequence[str], own: Path | None) -> Iterator[DictConfig]:
    """The composed configuration with Hydra's own part, whose interpolations resolve inside the block."""
    from hydra._internal.config_loader_impl import ConfigLoaderImpl
    from hydra._internal.utils import create_config_search_path
    from hydra.core.config_search_path import SearchPathQuery
    from hydra.core.hydra_config import HydraConfig
    from hydra.core.utils import setup_globals
    from hydra.types import RunMode
    from hydra.version import VersionBase, setbase
    from omegaconf import OmegaConf

    with _HYDRA, only_checked_files():
        hydra, version = HydraConfig.instance(), VersionBase.instance()
        before = hydra.cfg, version.version_base
        try:
            check_typed(overrides)
            setbase("1.3")
            if not OmegaConf.has_resolver("hydra"):
                setup_globals()
            places = create_config_search_path(str(config_dir()))
            if own is not None:  # where --config-dir puts it
                schema = SearchPathQuery(provider="schema")
                places.prepend(provider="command-line", path=f"file://{own.absolute()}", anchor=schema)
            config = ConfigLoaderImpl(places).load_configuration(CONFIG_NAME, hydra_words(overrides), RunMode.RUN)
            hydra.set_config(config)
            yield config
        finally:
            hydra.cfg, version.version_base = before


@contextmanager
def working_directory_importable() -> Iterator[None]:
    """Modules of the working directory can be imported inside, also by the worker processes started there."""
    here = str(Path.cwd())
    # always added, though "" or the same may be there: workers take "" for the folder where this process started,
    # and a run in another thread takes away what it added
    sys.path.append(here)
    try:
        yield
    finally:
        if here in sys.path:
            del sys.path[len(sys.path) - 1 - sys.path[::-1].index(here)]


def hydra_words(overrides: Sequence[str]) -> list[str]:
    """Overrides as Hydra reads them.

    Values may hold an equals sign, as in start.path=run/seed=3, and letters and signs of any other kind that names of
    files have, as in target.path=José/part(1).stl. The group of overlays has a default, so that experiment=NAME selects
    one, but +experiment=NAME is what Hydra's users type.

    Raises
    ------
    InputError
        If a value has characters that the terminal's encoding has no letters for.
    """
    found = []
    for override in overrides:
        key, equals, value = override.partition("=")
        if any("\ud800" <= character <= "\udfff" for character in value):
            expected = f"is no text in this terminal's encoding ({sys.getfilesystemencoding()}); set LC_ALL=C.UTF-8"
            raise InputError(key, value, expected)
        if not any(character in value for character in "\"'\\[]{}$") and not _FUNCTION.match(value):
            value = ",".join(_bare(piece) for piece in value.split(","))
        key = "experiment" if key == "+experiment" else key
        found.append(key + equals + value)
    return found


_FUNCTION = re.compile(r"\s*\w+\(.*\)\s*", re.DOTALL)
"""A function of Hydra's, such as range(1,5)."""
_BARE = re.compile(r"[\w/\-+.%*@?|:=\s]*", re.ASCII)
"""What Hydra reads without quotes."""


def _bare(text: str) -> str:
    """A text without quotes as Hydra's grammar wants it."""
    return text.replace("=", "\\=") if _BARE.fullmatch(text) else f"'{text}'"


def without_hydra(config: DictConfig) -> DictConfig:
    """The task's part of a configuration composed with Hydra's own."""
    with open_dict(config):
        del config["hydra"]
    return config
