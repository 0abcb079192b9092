"""YAML files that somebody else may have made, read within bounds."""

from __future__ import annotations

from pathlib import Path

import yaml  # type: ignore[import-untyped]

from origami_lab.errors import InputError
from origami_lab.files import regular_bytes
from origami_lab.text import first_line

LARGEST = 4 * 2**20
"""Bytes of a file: a hundred thousand seeds are less than one megabyte."""
MOST_VALUES = 500_000
"""Values in a file, those counted again that an alias repeats."""
LONGEST_NUMBER = 2_000
"""Characters of a value without quotes, which may be read as a number."""


def yaml_text(field: str, file: Path) -> str:
    """The text of a YAML file; that it is well-formed is left to what reads it.

    Raises
    ------
    InputError
        If it cannot be read, is no regular file, or would be too large when its aliases are replaced.
    """
    try:
        text = regular_bytes(file, LARGEST).decode("utf-8")
    except FileNotFoundError:
        raise InputError(field, file, "there is no such file") from None
    except OSError as error:
        raise InputError(field, file, f"cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError(field, file, f"cannot be read: not UTF-8 text ({first_line(str(error))})") from error
    check_values(field, file, text)
    return text


def check_values(field: str, file: object, text: str) -> None:
    """Raise InputError if a YAML text would be too large when its aliases are replaced by what they stand for."""
    try:
        root = yaml.compose(text, yaml.SafeLoader)
        count = 0 if root is None else _count(root, {})
    except RecursionError:
        raise InputError(field, file, "is nested too deeply") from None
    except (yaml.YAMLError, ValueError):
        return
    if count > MOST_VALUES:
        raise InputError(field, file, f"holds more than {MOST_VALUES} values when its aliases are replaced")


def _count(node: yaml.Node, known: dict[int, int]) -> int:
    """Values in a node, aliases replaced; one that holds itself has no end."""
    if id(node) not in known:
        known[id(node)] = MOST_VALUES + 1  # what it holds itself in the meantime
        if isinstance(node, yaml.ScalarNode):
            long = node.style is None and len(node.value) > LONGEST_NUMBER
            known[id(node)] = MOST_VALUES + 1 if long else 1
        else:
            pairs = isinstance(node, yaml.MappingNode)
            inner = [part for pair in node.value for part in pair] if pairs else node.value
            known[id(node)] = 1 + sum(_count(part, known) for part in inner)
    return known[id(node)]
