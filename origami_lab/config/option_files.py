"""The YAML files of the config groups: which options there are, their keys, and the comments that explain them."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from origami_lab.about import PACKAGE
from origami_lab.config.bounded_yaml import yaml_text
from origami_lab.config.earlier_versions import LATER_KEYS
from origami_lab.config.node import flatten
from origami_lab.errors import InputError
from origami_lab.text import first_line, nearest, shorten

CONFIG_NAME = "config"
NOT_IN_FILES = {
    "hydra": "is for Hydra itself, which takes no settings from files; they are given on the command line",
    "trust": "is given on the command line only",
}
"""Keys that no file may set, and why."""
KEYLESS = {"experiment", "program"}
"""Groups whose options set keys of others only."""


def config_dir() -> Path:
    """The folder with config.yaml and the groups.

    The checkout's top-level ``conf/`` next to the package if it is there (also for an editable install), else
    the copy inside the installed package.

    Raises
    ------
    FileNotFoundError
        If neither is there.
    """
    for place in (PACKAGE.parent / "conf", PACKAGE / "conf"):
        # the second file: a folder conf/ beside an installed package may be somebody else's
        if (place / f"{CONFIG_NAME}.yaml").is_file() and (place / "search/lns.yaml").is_file():
            return place
    raise FileNotFoundError(f"no configuration files beside or in {PACKAGE}")


def groups() -> dict[str, Path]:
    """The groups of the configuration and their folders."""
    return {folder.name: folder for folder in sorted(config_dir().iterdir()) if folder.is_dir()}


def check_file(file: Path, known_keys: Iterable[str]) -> None:
    """Check that a file is a whole configuration, as a run writes it; raises InputError with file and line."""
    if not file.exists():
        raise InputError("configuration", file, "there is no such file")
    if not file.is_file():
        raise InputError("configuration", file, "must be a file")
    text = yaml_text("configuration", file)
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        place, problem = "" if mark is None else f":{mark.line + 1}", getattr(error, "problem", None) or str(error)
        raise InputError("configuration", f"{file}{place}", f"is no YAML: {first_line(problem)}") from error
    if not isinstance(content, dict):
        raise InputError("configuration", file, "must hold keys and values, as a run's config.yaml does")
    known_keys = list(known_keys)
    known = {key.partition(".")[0] for key in known_keys} - KEYLESS
    for key in content:
        if key not in known or key in NOT_IN_FILES:
            line = 1 + next((i for i, row in enumerate(text.splitlines()) if row.startswith(f"{key}:")), 0)
            expected = f"there is no key {shorten(key)}" + nearest(str(key), sorted(known))
            expected = f"{key}: {NOT_IN_FILES[key]}" if key in NOT_IN_FILES else expected
            raise InputError("configuration", f"{file}:{line}", expected)
    # a group need not leave a key
    required = {key.partition(".")[0] for key in known_keys if "." in key or key not in groups()}
    missing = sorted(required - content.keys() - LATER_KEYS.keys())
    if missing:
        expected = f"lacks {', '.join(missing)}; a run's own config.yaml has every key"
        raise InputError("configuration", file, expected)


def is_ours(file: Path) -> bool:
    """Whether a file is one of our configuration."""
    return file.is_relative_to(config_dir().resolve())


def own_roots() -> frozenset[str]:
    """The keys at the top of a whole configuration."""
    return _roots(config_dir())


@functools.cache
def _roots(folder: Path) -> frozenset[str]:
    content = yaml.safe_load((folder / f"{CONFIG_NAME}.yaml").read_text(encoding="utf-8"))
    return frozenset({*content, *groups()} - {"defaults", "hydra"} - KEYLESS)


def options_of(folder: Path) -> list[str]:
    """The options of a group, in folders of folders too, as in experiment=paper/bowl.

    Folders with a leading underscore hold what options bring for others.
    """
    files = [file.relative_to(folder).with_suffix("") for file in folder.rglob("*.yaml")]
    return sorted(file.as_posix() for file in files if not file.as_posix().startswith("_"))


def read_options(group: str, folder: Path | None = None) -> dict[str, dict[str, Any]]:
    """The contents of a group's options by name, those of ``--config-dir`` and of another such folder included."""
    from hydra.core.hydra_config import HydraConfig

    sources = HydraConfig.get().runtime.config_sources if HydraConfig.initialized() else []
    own = [Path(source.path) for source in sources if source.provider == "command-line" and source.path]
    folders = [place / group for place in (config_dir(), *own, *([folder] if folder else []))]
    return {
        name: yaml.safe_load((place / f"{name}.yaml").read_text(encoding="utf-8")) or {}
        for place in folders
        for name in options_of(place)
    }


def own_keys(group: str, option: str) -> list[str]:
    """The keys of an option of ours below its group, dotted; none where there is no such option."""
    file = groups()[group] / f"{option}.yaml" if group in groups() else None
    if file is None or not file.is_file():
        return []
    content = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    own = content.get(group, content)
    return [key for key in flatten(own) if not key.endswith("_target_")] if isinstance(own, dict) else []


def explained_keys() -> dict[str, str]:
    """All keys of the configuration with the comments above them in its files; of several options the first counts."""
    found = explained_in(config_dir() / f"{CONFIG_NAME}.yaml", "")
    for group, folder in groups().items():
        if group not in {"hydra", CONFIG_NAME, *KEYLESS}:
            for name in options_of(folder):
                found = {**explained_in(folder / f"{name}.yaml", group), **found}
    return dict(sorted(found.items()))


def explained_in(file: Path, group: str) -> dict[str, str]:
    """The keys of one file that have a comment above them; several in a row may share one.

    The comment at the top of a file is about the file.
    """
    found: dict[str, str] = {}
    text = file.read_text(encoding="utf-8")
    above: list[tuple[int, str]] = [] if not group or text.startswith("# @package _global_") else [(-1, group)]
    comment: list[str] = []
    lines = text.splitlines()
    top = next((number for number, line in enumerate(lines) if not line.startswith("#")), 0)
    fresh = True
    for line in lines[top:]:
        key = re.match(r"( *)(\w+):(.*)", line)
        if line.lstrip().startswith("# ---"):  # the heading of a section
            comment, fresh = [], True
        elif line.lstrip().startswith("#"):
            comment, fresh = [*([] if fresh else comment), line.lstrip("# ")], False
        elif key is None:
            comment, fresh = [], True
        else:
            depth, name, value = len(key[1]), key[2], key[3].strip()
            above = [(other, word) for other, word in above if other < depth]
            if not value:  # its comment is that of the keys below it
                comment, above = [] if fresh else comment, [*above, (depth, name)]
            elif comment and not name.startswith("_") and (not group or (above and above[0][1] == group)):
                found[".".join([*(word for _, word in above), name])] = " ".join(comment)
            fresh = True
    return found


def has_key(file: Path, name: str) -> bool:
    """Whether an option's file sets a key, at any depth."""
    return re.search(rf"^\s*{re.escape(name.rpartition('.')[2])}:", file.read_text(encoding="utf-8"), re.M) is not None
