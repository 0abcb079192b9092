"""The page of all settings, made from the files of conf/: ``python -m tools.settings`` in docs/ writes it."""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import Path
from typing import Any

import yaml

from origami_lab.config.node import flatten
from origami_lab.config.option_files import config_dir, explained_in, explained_keys, groups, options_of

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "settings.md"
HEAD = """# Settings

Every setting, made from the files of `conf/` and their comments. `GROUP=OPTION` chooses a file of a group,
`KEY=VALUE` sets a key; a target or an objective brings the settings that suit it, and what is typed wins over all.
`origami-lab target=bowl search=bfts --cfg job` shows what would run. `null` stands for "not set", `???` must be
given, and a default of `${...}` is another setting's value.
"""
GROUPS = {
    "target": "The shape to fold into.",
    "objective": "What the folded sheet is worth. `shape`, the distance to the target, unless you name another.",
    "search": "Who plays. [Which searcher when](which-searcher.md).",
    "start": "What lies on the board before the first move.",
    "board": "The grid that vertices lie on.",
    "symmetry": "What the pattern's halves have in common.",
    "tracking": "Where results are recorded, besides the disk.",
    "program": "Whose rules: ours, or what the paper's program does.",
    "experiment": "Whole rows of settings.",
}


def value(text: Any) -> str:
    """A default as it is typed."""
    if text is None or isinstance(text, bool):
        return {None: "null", True: "true", False: "false"}[text]
    if isinstance(text, list):
        return f"[{','.join(map(value, text))}]"
    return str(text)


def cell(text: str) -> str:
    """A comment in a table."""
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def top_comment(file: Path) -> str:
    """What stands at the top of an option's file about the option."""
    lines = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if line.startswith("# @package"):
            continue
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines)


def _table(rows: list[tuple[str, str, str]]) -> str:
    """A row for each comment, which several keys may share."""
    body = ""
    for text, alike in groupby(rows, key=lambda row: row[2] or row[0]):
        keys = [(key, default, said) for key, default, said in alike]
        settings = " ".join(f"`{key}={default}`" for key, default, _ in keys)
        body += f"| {settings} | {cell(text if keys[0][2] else '')} |\n"
    return f"\n| setting and default | what it is |\n|---|---|\n{body}" if rows else ""


def _rows(content: dict[str, Any], prefix: str, said: dict[str, str]) -> list[tuple[str, str, str]]:
    flat = flatten(content)
    rows = []
    for key, default in flat.items():
        name = f"{prefix}.{key}" if prefix else key
        if key.rpartition(".")[2].startswith("_") or "hydra" in key.split("."):
            continue
        rows.append((name, value(default), said.get(name, "")))
    return rows


def _option(group: str, name: str, file: Path) -> str:
    content = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    overridden = [item for item in content.pop("defaults", []) if isinstance(item, dict)]
    whole = group in content or file.read_text(encoding="utf-8").startswith("# @package _global_")
    said = explained_of(file, group)
    own = content.pop(group, {}) if whole else content
    rows = _rows(own if isinstance(own, dict) else {}, group, said)
    brings = [f"`{key.removeprefix('override /')}={choice}`" for item in overridden for key, choice in item.items()]
    if whole:
        rest = flatten({key: what for key, what in content.items() if key not in ("report_order", "task")})
        brings += [f"`{key}={value(default)}`" for key, default in rest.items()]
    text = f"\n### {group}={name}\n\n{cell(top_comment(file))}\n"
    if brings:
        text += f"\nBrings {', '.join(brings)}.\n"
    return text + _table(rows)


def explained_of(file: Path, group: str) -> dict[str, str]:
    """The keys of one option with their comments: its own, else those of an option of the same class, else of any."""
    alike: dict[str, str] = {}
    for other in options_of(groups()[group]):
        beside = groups()[group] / f"{other}.yaml"
        if _class(beside, group) == _class(file, group):
            alike = {**explained_in(beside, group), **alike}
    return {**explained_keys(), **alike, **explained_in(file, group)}


def _class(file: Path, group: str) -> Any:
    content = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    own = content.get(group, content)
    return own.get("_target_") if isinstance(own, dict) else None


def page() -> str:
    """The whole page as Markdown."""
    root = yaml.safe_load((config_dir() / "config.yaml").read_text(encoding="utf-8"))
    choices = {key: name for item in root.pop("defaults") if isinstance(item, dict) for key, name in item.items()}
    root.pop("hydra")
    parts = [HEAD, "\n## Of every run\n", _table(_rows(root, "", explained_keys()))]
    for group, about in GROUPS.items():
        folder = groups()[group]
        names = options_of(folder)
        chosen = f" `{group}={choices[group]}` unless something else is said." if group in choices else ""
        parts.append(f"\n## {group}\n\n{about}{chosen}\n")
        parts += [_option(group, name, folder / f"{name}.yaml") for name in names]
    return re.sub(r"\n{3,}", "\n\n", "".join(parts))


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
