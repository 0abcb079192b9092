"""The config groups in words: what each is, its options with their comments, and what an option brings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from origami_lab.config.node import flatten
from origami_lab.config.option_files import CONFIG_NAME, config_dir, explained_in, groups, options_of
from origami_lab.files import regular_bytes

LARGEST_OPTION = 2**20
"""Bytes of an option's file, which may be a stranger's."""


@dataclass(frozen=True)
class ExplainedSetting:
    """One setting: its default as it is typed, and the comment above it."""

    key: str
    value: str
    words: str


@dataclass(frozen=True)
class ExplainedOption:
    """One option of a group."""

    name: str
    words: str
    """The comment at the top of its file."""
    settings: tuple[ExplainedSetting, ...]
    """Its own, below the group's name."""
    brings: tuple[str, ...] = field(default=())
    """Settings of other groups that choosing it sets, as they are typed."""


@dataclass(frozen=True)
class ExplainedGroup:
    """One group, the option that counts where none is chosen, and all options."""

    name: str
    words: str
    default: str
    options: tuple[str, ...]


def explained_groups(own: Sequence[Path] = ()) -> dict[str, ExplainedGroup]:
    """All groups by name, with the options of further folders.

    Parameters
    ----------
    own
        Folders with options of the user's, as ``--config-dir`` names them.
    """
    text = (config_dir() / f"{CONFIG_NAME}.yaml").read_text(encoding="utf-8")
    said = {name: (default, words) for name, default, words in re.findall(r"^  - (\w+): (\S+) # (.*)$", text, re.M)}
    found = {}
    for name, folder in groups().items():
        default, words = said.get(name, ("", ""))
        options = {option for place in (folder, *(place / name for place in own)) for option in options_of(place)}
        found[name] = ExplainedGroup(name, words, default, tuple(sorted(options)))
    return found


def explained_option(group: str, name: str, own: Sequence[Path] = ()) -> ExplainedOption:
    """One option in words; a user's folder wins over ours, as it does for Hydra.

    Raises
    ------
    OSError, ValueError
        If its file cannot be read.
    """
    file = next(f for f in (place / group / f"{name}.yaml" for place in (*own, config_dir())) if f.is_file())
    text = regular_bytes(file, LARGEST_OPTION).decode("utf-8")
    try:
        content = yaml.safe_load(text) or {}
    except yaml.YAMLError as error:
        raise ValueError("is no YAML") from error
    if not isinstance(content, dict):
        raise ValueError("must hold keys and values")
    top = [line.lstrip("# ") for line in text.splitlines()]
    head = next((k for k, line in enumerate(text.splitlines()) if not line.startswith("#")), len(top))
    words = " ".join(line for line in top[:head] if line and not line.startswith("@package"))
    everywhere = text.startswith("# @package _global_")
    part = content.get(group) if everywhere else content
    settings = _settings(group, part if isinstance(part, dict) else {}, explained_in(file, group))
    brings = _brought(group, content) if everywhere else ()
    return ExplainedOption(name, words, settings, brings)


def explained_settings() -> list[ExplainedSetting]:
    """The settings of config.yaml that belong to no group, in its order."""
    file = config_dir() / f"{CONFIG_NAME}.yaml"
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    kept = {key: value for key, value in content.items() if key not in ("defaults", "hydra")}
    words = explained_in(file, "")
    return [ExplainedSetting(key, typed(value), words.get(key, "")) for key, value in flatten(kept).items()]


def typed(value: Any) -> str:
    """A value as it is typed on the command line."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value).replace(", ", ",") if isinstance(value, list) else str(value)


def _settings(group: str, part: Mapping[str, Any], words: Mapping[str, str]) -> tuple[ExplainedSetting, ...]:
    dotted = flatten(part, f"{group}.")
    shown = {key: value for key, value in dotted.items() if "_target_" not in key and not str(value).startswith("${")}
    return tuple(ExplainedSetting(key, typed(value), words.get(key, "")) for key, value in shown.items())


def _brought(group: str, content: Mapping[str, Any]) -> tuple[str, ...]:
    """What an option sets elsewhere: options of other groups, then single settings."""
    chosen = [entry for entry in content.get("defaults") or [] if isinstance(entry, dict)]
    options = [(str(key), value) for entry in chosen for key, value in entry.items()]
    words = [f"{key.rpartition('/')[2]}={typed(value)}" for key, value in options if key.startswith("override /")]
    rest = {k: v for k, v in content.items() if k not in ("defaults", group, "task", "report_order", "hydra")}
    return (*words, *(f"{key}={typed(value)}" for key, value in flatten(rest).items() if "_target_" not in key))
