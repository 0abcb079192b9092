"""Parts of a user's that misbehave, each in its own way, for :mod:`benchmarks.faults`."""

from __future__ import annotations

import ctypes
import math
import os
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

GOOD_CALLS = 20
"""Calls that go well before the one that does not."""


def _raises() -> object:
    raise RuntimeError("the kettle is empty\nsecond line")


def _eats_memory() -> object:
    blocks = []
    while True:
        blocks.append(np.empty(2**28))  # asked for, never touched: the machine itself is not to run out


def _recurses() -> object:
    return _recurses()


def _sleeps() -> object:
    while True:
        time.sleep(0.01)


WAYS: dict[str, Callable[[], object]] = {
    "raises": _raises,
    "returns None": lambda: None,
    "returns a text": lambda: "1.5",
    "returns NaN": lambda: math.nan,
    "returns inf": lambda: math.inf,
    "returns an array": lambda: np.zeros(1),
    "recurses for ever": _recurses,
    "calls sys.exit": lambda: sys.exit(7),
    "raises KeyboardInterrupt": lambda: (_ for _ in ()).throw(KeyboardInterrupt()),
    "calls os._exit": lambda: os._exit(3),
    "segfaults in C": lambda: ctypes.string_at(0),
    "eats the memory": _eats_memory,
    "loops for ever in Python": _sleeps,
    "blocks for ever in C": lambda: ctypes.PyDLL(None).sleep(1000),
    "backtracks for ever in a regex": lambda: re.match("(a+)+$", "a" * 64 + "b"),
}


class Faulty:
    """Height of the highest point; one trial, the first to come so far, meets one bad call.

    Parameters
    ----------
    how
        One of WAYS.
    where
        The method that goes wrong: score or bound.
    once
        A file that is made by the trial that meets the bad call.
    """

    def __init__(self, how: str, where: str, once: str) -> None:
        self.how, self.where, self.once = how, where, Path(once)
        self.calls = 0

    def score(self, sheet: object) -> object:
        """The height, a number – or not."""
        if self.where == "score" and self._goes_wrong():
            return WAYS[self.how]()
        points = sheet.points[sheet.reach - 1]  # type: ignore[attr-defined]
        return float(points[:, 2].max())

    def bound(self, sheet: object) -> object:
        """No bound is known."""
        if self.where == "bound" and self._goes_wrong():
            return WAYS[self.how]()
        return math.inf

    def _goes_wrong(self) -> bool:
        self.calls += 1
        if self.calls != GOOD_CALLS:
            return False
        try:
            self.once.touch(exist_ok=False)
        except FileExistsError:
            return False
        return True
