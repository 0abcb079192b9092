"""Where the configuration files are, and Hydra's errors in one line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from hydra.errors import (
    ConfigCompositionException,
    HydraException,
    MissingConfigException,
    OverrideParseException,
)
from omegaconf.errors import OmegaConfBaseException

import origami_lab
from origami_lab.errors import InputError
from origami_lab.experiment.locate import nearest

CONFIG_NAME = "config"

_NOT_A_KEY = re.compile(r"Could not (?:override|delete)[^']* '([^']+)'")
_TWICE = re.compile(r"Multiple values for (\S+?)\.")
_AMBIGUOUS = re.compile(r"Ambiguous value for argument '([^=']+)=([^']*)'")


def config_dir() -> Path:
    """The folder with config.yaml and the groups.

    The checkout's top-level ``conf/`` next to the package if it is there (also for an editable install), else
    the copy inside the installed package.

    Raises
    ------
    FileNotFoundError
        If neither is there.
    """
    package = Path(origami_lab.__file__).resolve().parent
    for place in (package.parent / "conf", package / "conf"):
        # the second file: a folder conf/ beside an installed package may be somebody else's
        if (place / f"{CONFIG_NAME}.yaml").is_file() and (place / "hydra/help/origami_lab.yaml").is_file():
            return place
    raise FileNotFoundError(f"no configuration files beside or in {package}")


def explain(
    error: Exception, arguments: Sequence[str] = (), known_keys: Callable[[], Iterable[str]] = tuple
) -> InputError | None:
    """Say in one line what Hydra refused; None if the error is not about the user's input.

    Parameters
    ----------
    arguments
        The command line, to quote what was given.
    known_keys
        Finds the keys and groups there are, to suggest the nearest one for a typo.
    """
    if isinstance(error, InputError):
        return error
    if isinstance(error, MissingConfigException):
        return _missing(error)
    if isinstance(error, OverrideParseException):
        key, _, value = str(error.override).partition("=")
        return InputError(key, value, f"cannot be read: {_first_line(error.message)}; quote special characters")
    mark = getattr(error, "problem_mark", None)  # PyYAML's, in a file of the user's
    if mark is not None:
        problem = getattr(error, "problem", None) or "not YAML"
        return InputError("configuration", mark.name, f"cannot be read: {problem} in line {mark.line + 1}")
    if isinstance(error, UnicodeDecodeError):
        return InputError("configuration", "?", "cannot be read: a file is not UTF-8 text")
    if isinstance(error, ConfigCompositionException | HydraException | OmegaConfBaseException):
        text = f"{error}\n{error.__cause__ or ''}"
        if found := _AMBIGUOUS.search(text):
            key, value = found.groups()
            return InputError(key, value, f"must be one value or a list, {key}=[{value}]; several runs need -m")
        if found := _NOT_A_KEY.search(text):
            return _unknown(found.group(1), arguments, known_keys())
        if found := _TWICE.search(text):
            return InputError(found.group(1), "twice", "must be given once, without a +")
        if isinstance(error, OmegaConfBaseException) and error.full_key:
            return InputError(error.full_key, "?", _first_line(str(error)))
        return InputError("configuration", "?", _first_line(text))
    return None


def _missing(error: MissingConfigException) -> InputError:
    group, _, option = (error.missing_cfg_file or "configuration/?").rpartition("/")
    options = [name for name in error.options or [] if name]
    if not options:
        return InputError(group or "configuration", option, _first_line(str(error)))
    return InputError(
        group.removeprefix("/"), option, f"must be one of {', '.join(options)}" + nearest(option, options)
    )


def _unknown(key: str, arguments: Sequence[str], known_keys: Iterable[str]) -> InputError:
    key = key.lstrip("+~")
    values = [text.partition("=")[2] for text in arguments if text.lstrip("+~").partition("=")[0] == key]
    hint = nearest(key, sorted(set(known_keys)))
    return InputError(key, values[-1] if values else "?", "there is no such key or group" + (hint or "; see --help"))


def _first_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[0] if lines else "cannot be used"
