"""The grammar of ``seed``: ``3``, ``0..9`` (both ends in) or ``[0,3,7]``."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from origami_lab.errors import InputError

EXPECTED = "must be a seed like 3, a range like 0..9 (both ends in) or a list like [0,3,7]"
LARGEST = 2**63 - 1
MOST = 100_000
"""How many trials one experiment may have."""

_RANGE = re.compile(r"\s*(-?\d{1,40})\s*\.\.\s*(-?\d{1,40})\s*")
_NUMBER = re.compile(r"\s*-?\d{1,40}\s*")


def parse_seeds(value: object) -> tuple[int, ...]:
    """Read the value of ``seed`` as it comes from the command line or a YAML file.

    Returns
    -------
    The seeds in the order given, without repetition.

    Raises
    ------
    InputError
        If it is none of the three forms, a range runs backwards, a seed is negative or comes twice.
    """
    if isinstance(value, bool) or value is None:
        raise InputError("seed", value, EXPECTED)
    if isinstance(value, int):
        return (_checked(value, value),)
    if isinstance(value, str):
        if match := _RANGE.fullmatch(value):
            first, last = (_checked(int(end), value) for end in match.groups())
            if first > last:
                raise InputError("seed", value, f"the range runs backwards; must be {last}..{first}")
            if last - first >= MOST:
                raise InputError("seed", value, f"must hold at most {MOST} seeds")
            return tuple(range(first, last + 1))
        if _NUMBER.fullmatch(value):
            return (_checked(int(value), value),)
        raise InputError("seed", value, EXPECTED)
    if isinstance(value, Sequence):
        written = "[" + ",".join(map(str, value)) + "]"
        if not value or any(isinstance(item, bool) or not isinstance(item, int) for item in value):
            raise InputError("seed", written, EXPECTED)
        if len(value) > MOST:
            raise InputError("seed", written, f"must hold at most {MOST} seeds")
        seeds = tuple(_checked(item, written) for item in value)
        twice = sorted(seed for seed, times in Counter(seeds).items() if times > 1)
        if twice:
            raise InputError("seed", written, f"must not name a seed twice ({', '.join(map(str, twice))})")
        return seeds
    raise InputError("seed", value, EXPECTED)


def format_seeds(seeds: Sequence[int]) -> str | int | list[int]:
    """Write seeds in the shortest form that :func:`parse_seeds` reads back."""
    if len(seeds) == 1:
        return seeds[0]
    if all(after == before + 1 for before, after in pairwise(seeds)):
        return f"{seeds[0]}..{seeds[-1]}"
    return list(seeds)


def _checked(seed: int, written: object) -> int:
    if seed < 0:
        raise InputError("seed", written, "must not be negative")
    if seed > LARGEST:
        raise InputError("seed", written, f"must be at most {LARGEST}")
    return seed
