"""Where the configuration files are, and Hydra's errors in one line."""

from __future__ import annotations

import errno
import re
from collections.abc import Callable, Iterable, Sequence

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import (
    ConfigCompositionException,
    HydraException,
    MissingConfigException,
    OverrideParseException,
)
from omegaconf.errors import OmegaConfBaseException

from origami_lab.addresses import hidden
from origami_lab.config.option_files import groups, has_key, options_of, own_keys
from origami_lab.errors import InputError
from origami_lab.text import first_line, nearest

_NOT_A_KEY = re.compile(r"Could not (?:override|delete)[^']* '([^']+)'")
_TWICE = re.compile(r"Multiple values for (\S+?)\.")
_AMBIGUOUS = re.compile(r"Ambiguous value for argument '([^=']+)=(.*)'")
_MERGED = re.compile(r"Error merging override (.*)")
_MESH_FILE = re.compile(r".*\.(stl|obj|ply|off|glb|gltf)", re.IGNORECASE)

_WITH_CLASSES = ("target", "objective", "search", "start")
"""Groups whose options name a class, which may take more than its option's file says."""


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
        return _missing(error, arguments)
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:  # Hydra looks for a group of that name
        key, _, value = max(arguments, key=lambda text: len(text.partition("=")[0]), default="").partition("=")
        return InputError(key, value, "is too long for the name of a key")
    if isinstance(error, OSError):  # Hydra makes its folder when all is composed
        return InputError("hydra.run.dir", error.filename, f"must be a folder that can be written ({error.strerror})")
    if isinstance(error, OverrideParseException):
        key, _, value = str(error.override).partition("=")
        # the parser quotes parts of what it stumbled over
        said = "" if hidden(value) != value else f": {first_line(error.message)}"
        return InputError(key, value, f"cannot be read{said}; quote special characters")
    mark = getattr(error, "problem_mark", None)  # PyYAML's, in a file of the user's
    if mark is not None:
        problem = getattr(error, "problem", None) or "not YAML"
        return InputError("configuration", mark.name, f"cannot be read: {problem} in line {mark.line + 1}")
    if isinstance(error, UnicodeDecodeError):
        return InputError("configuration", "?", "cannot be read: a file is not UTF-8 text")
    if isinstance(error, ConfigCompositionException | HydraException | OmegaConfBaseException):
        text = f"{error}\n{error.__cause__ or ''}"
        if found := _AMBIGUOUS.search(text):
            return _ambiguous(*found.groups())
        if found := _NOT_A_KEY.search(text):
            return _unknown(found.group(1), arguments, known_keys())
        if found := _TWICE.search(text):
            return InputError(found.group(1), "twice", "must be given once, without a +")
        if (found := _MERGED.search(text)) and error.__cause__ is not None:
            key, _, value = found.group(1).partition("=")
            return InputError(key, value, f"cannot be set: {first_line(str(error.__cause__))}")
        if isinstance(error, OmegaConfBaseException) and error.full_key:
            return InputError(error.full_key, "?", first_line(str(error)))
        return InputError("configuration", "?", first_line(text))
    return None


def find_culprit(arguments: Sequence[str]) -> InputError | None:
    """The override that Hydra breaks on without naming it: one without a key or a value, or a group without a word."""
    for argument in arguments:
        key, _, value = argument.partition("=")
        try:
            OverridesParser.create().parse_override(argument)
        except Exception as error:  # a number of thousands of digits, say
            return InputError(key, value, f"cannot be read: {first_line(str(error))}")
        if key == "":
            return InputError("", value, "must have a key before the =, as in budget=1000")
        if key in groups() and value not in (options := options_of(groups()[key])):
            return InputError(key, value, f"must be one of {', '.join(options)}")
    return None


def _missing(error: MissingConfigException, arguments: Sequence[str]) -> InputError:
    path = error.missing_cfg_file or "configuration/?"
    group, _, option = path.rpartition("/")
    options = [name for name in error.options or [] if name]
    if path.startswith("experiment/"):  # its options lie in folders
        group, _, option = path.partition("/")
        options = sorted({*options, *options_of(groups()[group])})
    for argument in arguments:
        if argument.startswith("target=") and _MESH_FILE.fullmatch(argument):
            value = argument.partition("=")[2]
            return InputError("target", value, f"a mesh file is given as target=mesh target.path={value}")
    if not options:
        return InputError(group or "configuration", option, first_line(str(error)))
    group, hint = group.removeprefix("/"), nearest(option, options)
    if group == "board" and (size := re.fullmatch(r"(\d+)(?:x(\d+))?", option)):
        width, height = int(size[1]), int(size[2] or size[1])
        if width % 2 and height % 2:
            given = f"board.size={width}" if width == height else f"board.width={width} board.height={height}"
            hint = f"; any other size is given as {given}"
    return InputError(group, option, f"must be one of {', '.join(options)}{hint}")


def _ambiguous(key: str, value: str) -> InputError:
    several = f"several runs, one for each, need -m: origami-lab -m {key}={value} ..."
    if key in groups():
        return InputError(key, value, f"must be one option; {several}")
    return InputError(key, value, f"must be one value or a list, {key}=[{value}]; {several}")


def _unknown(key: str, arguments: Sequence[str], known_keys: Iterable[str]) -> InputError:
    key = key.lstrip("+~")
    values = [text.partition("=")[2] for text in arguments if text.lstrip("+~").partition("=")[0] == key]
    value, known = values[-1] if values else "?", sorted(set(known_keys))
    if f"~{key}" in arguments and key in known:
        return InputError(f"~{key}", value, "cannot be left out")
    group, _, name = key.partition(".")
    if name and group in groups():
        owners = [option for option in options_of(groups()[group]) if has_key(groups()[group] / f"{option}.yaml", name)]
        owners.sort(key=lambda option: option == "auto")  # which is of no use by itself
        if owners:
            either = " or ".join(f"{group}={option}" for option in owners)
            return InputError(key, value, f"is a key of {either} only: {group}={owners[0]} {key}={value}")
    chosen = [text.partition("=")[2] for text in arguments if text.partition("=")[0] == group]
    if name and chosen and (own := own_keys(group, chosen[-1])):
        meant = nearest(key, [f"{group}.{other}" for other in own])
        return InputError(key, value, f"there is no such key{meant}; {group}={chosen[-1]} has {', '.join(own)}")
    # part of the key itself is no suggestion
    hint = nearest(key, [other for other in known if not key.startswith(f"{other}.")])
    if not hint and name and group in _WITH_CLASSES:
        hint = f"; +{key}={value} would hand it to the class that {group} names"
    return InputError(key, value, "there is no such key or group" + (hint or "; see --help"))
