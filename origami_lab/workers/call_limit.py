"""A time limit for single calls of a user's objective.

The worker only numbers the calls, in memory that it shares with the parent; the parent measures how long it sees the
same number. So the limit holds inside C code, too, and time in which the machine slept or the run was suspended does
not count.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from ctypes import c_uint64
from multiprocessing.context import SpawnContext
from typing import Any

LONGEST_STEP = 1.0
"""Most seconds that count between two looks; in a longer gap the parent itself did not run."""


class CallLimit:
    """The parent's side: how long a worker has been in one call.

    Parameters
    ----------
    seconds
        Longest that a call may take; None for no limit.
    """

    def __init__(self, context: SpawnContext, seconds: float | None) -> None:
        self.number: Any = context.RawValue(c_uint64, 0)
        """Shared memory for the worker: the number of the call it is in, 0 if it is in none."""
        self.seconds = seconds
        self._seen, self._lasted, self._looked = 0, 0.0, time.monotonic()

    def exceeded(self) -> bool:
        """Whether the worker's present call has lasted too long. To be asked several times a second."""
        now = time.monotonic()
        step, self._looked = min(now - self._looked, LONGEST_STEP), now
        call = int(self.number.value)
        self._lasted = self._lasted + step if call and call == self._seen else 0.0
        self._seen = call
        return self.seconds is not None and self._lasted > self.seconds


class Calls:
    """The worker's side: numbers the calls of the functions that are wrapped by it."""

    def __init__(self, shared: Any) -> None:
        self._shared, self._count = shared, 0

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        shared = self._shared

        def numbered(*arguments: Any, **named: Any) -> Any:
            self._count += 1
            shared.value = self._count
            try:
                return function(*arguments, **named)
            finally:
                shared.value = 0

        return numbered
