"""What files with options may hold: settings of an experiment, and nothing that makes Hydra do something else.

Hydra takes more from its files than settings: callbacks that it calls, search paths, interpolations that read the
environment. Files may be somebody else's, so those but ours are looked at before Hydra has them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydra._internal.core_plugins import file_config_source, importlib_resources_config_source
from hydra._internal.sources_registry import SourcesRegistry
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigResult
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from omegaconf.grammar_parser import parse

from origami_lab.addresses import keep
from origami_lab.config.bounded_yaml import yaml_text
from origami_lab.config.option_files import NOT_IN_FILES, is_ours
from origami_lab.errors import InputError
from origami_lab.text import shorten

RESOLVERS = ("oc.select", "oc.dict.keys", "oc.dict.values", "hydra")
"""What an interpolation in a file may use: nothing that reads the environment, or makes settings of a text."""
_CHOICE = re.compile(r"runtime\.choices\.[\w/]+")
"""All that it may ask Hydra for."""
_CALLED = ("callbacks", "job_logging", "hydra_logging")
"""Settings of Hydra's that name what it calls."""


@contextmanager
def only_checked_files() -> Iterator[None]:
    """While Hydra reads files, ours look at them first; a program's own Hydra is as it was afterwards."""
    Plugins.instance()  # registers Hydra's sources, the first time
    types = SourcesRegistry.instance().types
    before = dict(types)
    types.update({"file": FileConfigSource, "pkg": ImportlibResourcesConfigSource})
    try:
        yield
    finally:
        types.update(before)


# Named as Hydra's own: a launcher's job takes over the registry, and Hydra knows its sources there by their names.
class FileConfigSource(file_config_source.FileConfigSource):
    """Files of a folder."""

    def load_config(self, config_path: str) -> ConfigResult:
        file = Path(self.path, self._normalize_file_name(config_path)).resolve()
        if is_ours(file):
            return super().load_config(config_path)
        if file.exists():
            yaml_text("configuration", file)
        result = super().load_config(config_path)
        _check(file, config_path, result)
        result.config = _without_secrets(result.config)
        return result


class ImportlibResourcesConfigSource(importlib_resources_config_source.ImportlibResourcesConfigSource):
    """Files of an installed package."""

    def load_config(self, config_path: str) -> ConfigResult:
        result = super().load_config(config_path)
        if self.path.partition(".")[0] not in ("hydra", "hydra_plugins"):
            _check(f"{self.path}/{config_path}", config_path, result)
        return result


def _check(file: object, config_path: str, result: ConfigResult) -> None:
    """Raise InputError if a file holds something else than settings."""
    content = OmegaConf.to_container(result.config, resolve=False)
    _refuse(file, re.split(r"[./]", f"{config_path.partition('/')[0]}.{result.header.get('package') or ''}"))
    if isinstance(content, dict):
        _refuse(file, content)
        defaults = content.get("defaults")
        for entry in defaults if isinstance(defaults, list) else []:
            for text in [str(key) for key in entry] if isinstance(entry, Mapping) else [str(entry)]:
                _refuse(file, re.split(r"[\s./@:]+", text))
    check_interpolations(f"configuration {file}", content)


def _without_secrets(config: Any) -> Any:
    """The file's settings without the secrets in addresses, which are noted: Hydra writes and shows what it reads."""

    def cleaned(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: cleaned(item) for key, item in value.items()}
        if isinstance(value, list):
            return [cleaned(item) for item in value]
        return keep(value) if isinstance(value, str) and "://" in value and "${" not in value else value

    content = OmegaConf.to_container(config, resolve=False)
    found = cleaned(content)
    return config if found == content else OmegaConf.create(found)


def _refuse(file: object, names: Sequence[Any] | Mapping[Any, Any]) -> None:
    for name, expected in NOT_IN_FILES.items():
        if name in names:
            raise InputError("configuration", file, f"{name}: {expected}")


def check_interpolations(field: str, value: Any) -> None:
    """Refuse interpolations that are more than a reference to another setting.

    Raises
    ------
    InputError
        If there is one, at any depth.
    """
    if isinstance(value, Mapping):
        for item in value.values():
            check_interpolations(field, item)
    elif isinstance(value, list | tuple):
        for item in value:
            check_interpolations(field, item)
    elif isinstance(value, str) and "${" in value:
        try:
            resolvers = list(_resolvers(parse(value)))
        except OmegaConfBaseException:
            return  # said when it is resolved
        for name, arguments in resolvers:
            if name not in RESOLVERS or (name == "hydra" and not _CHOICE.fullmatch(arguments)):
                expected = f"{shorten(value)} may refer to other settings only, as in ${{target}}"
                raise InputError(field, f"${{{name}:...}}", expected)


def _resolvers(tree: Any) -> Iterator[tuple[str, str]]:
    """The names of resolvers in a parsed text, and what they are given."""
    if type(tree).__name__ == "InterpolationResolverContext":
        yield tree.resolverName().getText(), "" if tree.sequence() is None else tree.sequence().getText()
    for child in getattr(tree, "children", None) or ():
        yield from _resolvers(child)


def check_typed(overrides: Sequence[str]) -> None:
    """Refuse settings of Hydra's that name what it calls: a ``_target_`` obeys the same rule wherever it is typed.

    Raises
    ------
    InputError
        For the first one.
    """
    for text in overrides:
        key, _, value = text.partition("=")
        path = key.lstrip("+~").replace("/", ".").split("@")
        names = [name for part in path for name in part.split(".")]
        if "hydra" in names and (
            names == ["hydra"] or any(name in names for name in _CALLED) or "_target_" in text or "_args_" in text
        ):
            raise InputError(key, value, "names code for Hydra to call, which is not done")
