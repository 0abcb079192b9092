"""Where the code that a configuration names may come from.

A configuration may be somebody else's, and a ``_target_`` in it names what is called. It may be a part of ours for its
place, or of the user's own: what lies below the working directory, or in an installed package that the command line
names by ``trust=PACKAGE``. Nothing else is called, or so much as imported.
"""

from __future__ import annotations

import functools
import json
import re
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from importlib import metadata
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import unquote, urlparse

from origami_lab.about import PACKAGE
from origami_lab.config.option_files import config_dir

LIBRARIES = tuple(
    sorted({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")} - {None})
)
"""Folders of Python's own modules and of installed ones."""
_INSTALLED = ("site-packages", "dist-packages")
_WITH_PARTS = ("target", "objective", "search", "start")
_FROM_FILES = {"start": ("origami_lab.game.FromMoves",), "search": ("origami_lab.studio.DesignedByHand",)}
"""Parts that no option names: what start=file becomes in a run folder, and who designs in the studio."""


@functools.cache
def our_parts(place: str) -> tuple[str, ...]:
    """The public names of our parts for a place: those that the options of its group name.

    Parameters
    ----------
    place
        A group such as ``target``; empty for those of all places.
    """
    places = [place] if place else _WITH_PARTS
    texts = [
        file.read_text(encoding="utf-8") for name in places for file in sorted((config_dir() / name).glob("*.yaml"))
    ]
    found = {name for text in texts for name in re.findall(r"^\s*_target_:\s*(origami_lab\.\S+)", text, re.MULTILINE)}
    return tuple(sorted(found.union(*(_FROM_FILES.get(name, ()) for name in places))))


def names_only_ours(config: Any) -> bool:
    """Whether every ``_target_`` of a configuration, at any depth, is a part of this package."""
    if isinstance(config, Mapping):
        ours = str(config.get("_target_", "origami_lab.")).startswith("origami_lab.")
        return ours and all(map(names_only_ours, config.values()))
    return not isinstance(config, list | tuple) or all(map(names_only_ours, config))


def spec_of(module: str) -> ModuleSpec | None:
    """What a module would be imported from; None if there is none. The packages that it lies in must be imported.

    One of the same name that was imported in another working directory is forgotten.
    """
    loaded = sys.modules.get(module)
    if loaded is not None and "." not in module and not _is_own(str(getattr(loaded, "__file__", None) or "")):
        there = PathFinder.find_spec(module)
        if there is not None and there.origin is not None and _is_own(there.origin):
            for name in [name for name in sys.modules if name.partition(".")[0] == module]:
                del sys.modules[name]
    try:
        return find_spec(module)
    except ValueError:  # already there, made by hand
        return ModuleSpec(module, None, origin=getattr(sys.modules[module], "__file__", None))
    except ModuleNotFoundError:  # what is above is no package
        return None


def is_trusted(spec: ModuleSpec | None, trust: Sequence[str]) -> bool:
    """Whether a module is the user's own, or of a package that is trusted. A folder without code is."""
    if spec is None or spec.origin in ("built-in", "frozen"):
        return False
    if spec.origin is None:  # a folder of modules, each of which is asked for
        return spec.submodule_search_locations is not None
    return _is_own(spec.origin) or any(_is_of(name, spec.origin) for name in trust)


def is_trusted_module(module: ModuleType, trust: Sequence[str]) -> bool:
    """The same of a module that is imported."""
    return is_trusted(spec_of(module.__name__), trust)


def home_of(value: Any) -> str:
    """The module in which a class or function was defined; empty if that is not known, as of built-in methods."""
    while isinstance(value, functools.partial):
        value = value.func
    return str(getattr(getattr(value, "__func__", value), "__module__", None) or "")


def _is_own(file: str) -> bool:
    """Whether a file lies below the working directory and is not of an environment there, or of ours."""
    here = Path.cwd()
    named, real = Path(file).absolute(), Path(file).resolve()
    below = named.is_relative_to(here) or real.is_relative_to(here.resolve())
    return below and not any(map(_is_installed, (named, real)))


def _is_installed(file: Path) -> bool:
    libraries = {*map(Path, LIBRARIES), *(Path(folder).resolve() for folder in LIBRARIES), PACKAGE}
    return any(file.is_relative_to(folder) for folder in libraries) or any(name in file.parts for name in _INSTALLED)


def _is_of(name: str, file: str) -> bool:
    """Whether a file is one of an installed package's."""
    files, folders = _places(name)
    real = Path(file).resolve()
    return real in files or any(real.is_relative_to(folder) for folder in folders)


@functools.cache
def _places(name: str) -> tuple[frozenset[Path], tuple[Path, ...]]:
    """The files of an installed package, and folders that are wholly its own."""
    distribution = metadata.distribution(name)
    folders = []
    try:
        origin = json.loads(distribution.read_text("direct_url.json") or "{}")
        if origin.get("dir_info", {}).get("editable"):
            folders.append(Path(unquote(urlparse(origin["url"]).path)).resolve())
    except (ValueError, KeyError):
        pass
    listed = distribution.files
    if listed is None:  # installed by a system's packages, which keep no list here
        names = (distribution.read_text("top_level.txt") or "").split()
        return frozenset(), tuple(Path(str(distribution.locate_file(name))).resolve() for name in names)
    return frozenset(Path(str(file.locate())).resolve() for file in listed), tuple(folders)


def is_installed_package(name: str) -> bool:
    """Whether there is an installed package of this name, as pip knows it."""
    try:
        metadata.distribution(name)
    except (metadata.PackageNotFoundError, ValueError):
        return False
    return True
