"""``origami-lab --help``, ``--help settings`` and ``--help GROUP``: read from conf/ and its comments, without Hydra."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from origami_lab.commands import COMMANDS
from origami_lab.config.explained_options import (
    ExplainedGroup,
    ExplainedOption,
    ExplainedSetting,
    explained_groups,
    explained_option,
    explained_settings,
)
from origami_lab.config.option_files import explained_keys
from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.text import nearest

WIDTH = 118
SETTINGS = "settings"
WHAT_IT_IS = (
    "origami-lab designs rigid origami: name a shape, and a search plays the origami game until a crease pattern with"
    " one degree of freedom folds into it. An argument is a setting, KEY=VALUE or GROUP=OPTION; a bare word, a command."
)
EXAMPLES = (
    ("target=bowl search=bfts seed=0..9", "ten seeds, one result: mean ± std, pictures, a page, MLflow"),
    ("target=cube budget=50000", "a quick one, by the default search=lns"),
    ("target=bowl seed=0..9 polish=60000", "and move each best design off the grid"),
    ("target=mesh target.path=part.stl", "your own part; all that suits it is chosen"),
    ("objective=table search=evo", "an objective that needs no target"),
    ("+experiment=paper/bowl search=evo", "one of the paper's experiments, ten seeds"),
    ("-m target=cube,bowl search=rdm,bfts", "every combination; one folder, one table"),
    ("target=bowl output=DIR resume=true", "finish a run; more seeds or budget extend it"),
)
MOST_USED = (
    *("seed", "budget", "target_return", "max_crease_length", "driving_angle.max"),
    *("polish", "sheet", "files", "workers", "output"),
)
FLAGS = (
    ("-m, --multirun", "every combination of comma-separated values; hydra/launcher=joblib runs them side by side"),
    ("--cfg job", "print the configuration instead of running; with --resolve, computed values too"),
    ("--config-dir DIR", "your own options: DIR/target/mine.yaml becomes target=mine"),
    ("--hydra-help, --version", "Hydra's own flags; the version"),
)


def help_text(topics: Sequence[str], flags: Sequence[str] = ()) -> str:
    """The text that ``--help`` prints.

    Parameters
    ----------
    topics
        Words and settings beside it: ``settings``, groups, options like ``search=evo``, keys; none for the first page.
    flags
        The command's flags, of which ``--config-dir`` names options of the user's.

    Raises
    ------
    InputError
        For a topic that is none, or an option that cannot be read.
    """
    own = _own_folders(flags)
    pages = [_page(topic, own) for topic in topics]
    return "\n\n".join("\n".join(page) for page in pages or [_first_page(own)])


def _own_folders(flags: Sequence[str]) -> list[Path]:
    """Folders that ``--config-dir`` names."""
    found = []
    for flag, following in zip(flags, (*flags[1:], ""), strict=True):
        name, equals, value = flag.partition("=")
        if name in ("--config-dir", "-cd"):
            folder = expanded(value if equals else following)
            if not folder.is_dir():
                raise InputError("--config-dir", folder, "there is no such folder")
            found.append(folder)
    return found


def _first_page(own: Sequence[Path]) -> list[str]:
    known = {setting.key: setting for setting in explained_settings()}
    settings = [(f"{key}={known[key].value}", _in_short(known[key].words)) for key in MOST_USED]
    return [
        *_wrapped(WHAT_IT_IS, 0),
        "",
        "Examples",
        *_columns([(f"origami-lab {typed}", words) for typed, words in EXAMPLES]),
        "",
        "Commands (each has its own --help)",
        *_columns([(f"origami-lab {typed}", words) for typed, words in COMMANDS.values()]),
        *_columns([("origami-lab RUN/config.yaml", "run a finished experiment's configuration again")], 42),
        "",
        "Groups and their options (--help target: what they are; what you choose brings the settings that suit it)",
        *(_group_line(group) for group in explained_groups(own).values()),
        "",
        "Settings that are used most (--help settings: all of them; --help seed: one)",
        *_columns(settings),
        "",
        "Flags",
        *_columns(FLAGS),
        "",
        "Exit codes: 0 done, 1 a trial failed, 2 wrong input (one line says what would be right), 70 an error of the",
        "program itself, 130 interrupted.",
    ]


def _group_line(group: ExplainedGroup) -> str:
    names = [name for name in group.options if name != "none" or group.name != "experiment"]
    return "  " + textwrap.shorten(f"{group.name}: {', '.join(names)}", WIDTH - 2, placeholder=" ...")


def _page(topic: str, own: Sequence[Path]) -> list[str]:
    """The page of one topic."""
    word, equals, option = topic.lstrip("+~").partition("=")
    known = explained_groups(own)
    if word == SETTINGS:
        return _settings_page(known.values())
    if word in known and option and option in known[word].options:
        return list(_option_lines(word, _read(word, option, own)))
    if word in known:
        return _group_page(known[word], own)
    settings = {setting.key: setting for setting in explained_settings()}
    words = explained_keys()
    if word in settings:
        return [*_setting_lines([settings[word]])]
    if word in words:
        return [*_setting_lines([ExplainedSetting(word, "", words[word])])]
    inside = [setting for key, setting in settings.items() if key.startswith(f"{word}.")]
    if inside:
        return [*_setting_lines(inside)]
    if equals:  # what is wrong with it, the command itself says when it runs
        return _first_page(own)
    every = [SETTINGS, *known, *settings, *words]
    raise InputError(
        "--help", topic, f"must be settings, a group ({', '.join(known)}) or a setting" + nearest(word, every)
    )


def _settings_page(known: Iterable[ExplainedGroup]) -> list[str]:
    return [
        "Settings, with what they are where nothing else is said or brought by an option",
        "",
        *_setting_lines(explained_settings()),
        "",
        "Settings of groups: --help GROUP",
        *_columns([(f"{group.name}={group.default}", group.words) for group in known]),
    ]


def _group_page(group: ExplainedGroup, own: Sequence[Path]) -> list[str]:
    options = [_read(group.name, name, own) for name in group.options if name != "none" or group.name != "experiment"]
    chosen = f"; {group.name}={group.default} where none is chosen" if group.default else ""
    lines = [f"{group.name}: {group.words}{chosen}", ""]
    said: set[ExplainedSetting] = set()
    for option in options:
        lines += [*_option_lines(group.name, option, said), ""]
        said.update(option.settings)
    return lines[:-1]


def _option_lines(
    group: str, option: ExplainedOption, said: set[ExplainedSetting] | frozenset[ExplainedSetting] = frozenset()
) -> Iterator[str]:
    """An option, what it brings and its settings; those that were said for another option are named only."""
    plus = "+" if group == "experiment" else ""
    yield from _columns([(f"{plus}{group}={option.name}", option.words)], 26)
    if option.brings:
        yield from _wrapped(f"brings {' '.join(option.brings)}", 6)
    yield from _setting_lines([setting for setting in option.settings if setting not in said], 6)
    again = [f"{setting.key}={setting.value}" for setting in option.settings if setting in said]
    if again:
        yield from _wrapped(f"as above: {' '.join(again)}", 6)


def _read(group: str, name: str, own: Sequence[Path]) -> ExplainedOption:
    try:
        return explained_option(group, name, own)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(group, name, f"its file cannot be read ({reason})") from error


def _setting_lines(settings: Sequence[ExplainedSetting], indent: int = 2) -> list[str]:
    """Settings in two columns; words that hold for several in a row stand beside the first."""
    before = ["", *(setting.words for setting in settings)]
    pairs = [
        (f"{s.key}={s.value}" if s.value else s.key, "" if s.words == words else s.words)
        for s, words in zip(settings, before, strict=False)
    ]
    return _columns(pairs, max(min(38, max((len(typed) for typed, _ in pairs), default=0)) + 2, 28), indent)


def _columns(pairs: Sequence[tuple[str, str]], width: int = 0, indent: int = 2) -> list[str]:
    """Lines in two columns; a left cell that is too long has a line of its own."""
    width = width or max(len(left) for left, _ in pairs) + 2
    lines = []
    for left, right in pairs:
        first, *more = textwrap.wrap(right, WIDTH - indent - width) or [""]
        if len(left) + 2 > width and first:
            lines.append(" " * indent + left)
            left = ""
        lines.append((" " * indent + f"{left:<{width}}{first}").rstrip())
        lines += [" " * (indent + width) + line for line in more]
    return lines


def _wrapped(text: str, indent: int) -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent + 2 * (indent > 0)),
        break_on_hyphens=False,
    )


def _in_short(words: str) -> str:
    """The beginning of a comment that fits on one line beside its setting."""
    for end in (" (null = ", "; ", ". ", " (no "):
        words = words.partition(end)[0]
    if words.rpartition("(")[2].count(")") == 0:  # one that is left open
        words = words.rpartition(" (")[0] or words
    return textwrap.shorten(words, 82, placeholder=" ...")
