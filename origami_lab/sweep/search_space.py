"""The space that a sweep searches: its parameters, which are settings, and when each of them is searched at all."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from origami_lab.config.checked_values import Reader, Value, check_own, override, shown
from origami_lab.errors import InputError

Point = Mapping[str, Value]
"""Values of those parameters that are searched under their conditions."""


@dataclass(frozen=True)
class Parameter:
    """A setting and the values that it may take: ``choices``, or a range from ``low`` to ``high``, both ends in.

    A range is of whole numbers if its ends are. Where ``when`` does not hold, the setting keeps its default.
    """

    name: str
    """The setting's key on the command line, e.g. search.sigma_1."""
    choices: tuple[Value, ...] = ()
    low: int | float = 0
    high: int | float = 0
    log: bool = False
    step: int | float | None = None
    when: Mapping[str, tuple[Value, ...]] | None = None
    """Other parameters and those of their values under which this one is searched."""

    @property
    def whole(self) -> bool:
        """Whether the range is of whole numbers."""
        return all(isinstance(end, int) for end in (self.low, self.high, self.step or 0))

    def active(self, point: Point) -> bool:
        """Whether it is searched, given the values of the parameters above it."""
        return all(name in point and is_one_of(point[name], values) for name, values in (self.when or {}).items())

    def values(self) -> tuple[Value, ...] | None:
        """All its values, for a grid; None if there is no end to them."""
        if self.choices:
            return self.choices
        if self.step is None and (self.log or not self.whole):
            return None
        return tuple(_steps(self.low, self.high, self.step or 1))

    @property
    def probes(self) -> tuple[Value, ...]:
        """Values that tell whether it can be played: choices, or the ends and, of real numbers, one between."""
        if self.choices:
            return self.choices
        between = () if self.whole or self.step is not None else (self.low + (self.high - self.low) / math.e,)
        return (self.low, *between, self.high)

    def plain(self) -> dict[str, Any]:
        """As it is written in the file, for a record."""
        plain: dict[str, Any] = (
            {"choices": list(self.choices)} if self.choices else {"low": self.low, "high": self.high}
        )
        plain |= {"log": True} if self.log else {}
        plain |= {"step": self.step} if self.step is not None else {}
        return plain | ({"when": {name: list(values) for name, values in self.when.items()}} if self.when else {})


def _steps(low: float, high: float, step: float) -> list[int | float]:
    """The values of a range; as they are written: 0.3, not 0.1 + 0.1 + 0.1."""
    first, last, width = (Decimal(str(value)) for value in (low, high, step))
    kind = int if all(isinstance(value, int) for value in (low, high, step)) else float
    return [kind(first + number * width) for number in range(int((last - first) / width) + 1)]


def is_one_of(value: Value, values: Sequence[Value]) -> bool:
    """Whether it is among them; true is not 1."""
    return any(value == other and isinstance(value, bool) == isinstance(other, bool) for other in values)


def overrides_of(point: Point) -> list[str]:
    """A point as settings on the command line."""
    return [override(name, value) for name, value in point.items()]


def read_space(read: Reader) -> tuple[Parameter, ...]:
    """Read and check the ``space`` of a sweep's file.

    Raises
    ------
    InputError
        Naming the key: if a range is empty or the wrong way round, logarithmic from zero or below, if choices are
        missing or doubled, or a condition names no parameter with choices above it, or none of its values.
    """
    space: list[Parameter] = []
    for name in read.values:
        check_own("space", str(name), allowed=("search",))
        space.append(_parameter(str(name), read.below(name), space))
    if not space:
        raise InputError("space", "{}", "must name at least one setting, e.g. search.sigma_1: {low: 0.01, high: 1}")
    return tuple(space)


def _parameter(name: str, read: Reader, above: Sequence[Parameter]) -> Parameter:
    read.only(("choices", "low", "high", "log", "step", "when"))
    when = _condition(read, above) if read.values.get("when") is not None else None
    if "choices" in read.values:
        for key in ("low", "high", "log", "step"):
            if key in read.values:
                raise read.refuse(key, "must not stand beside choices")
        return Parameter(name, choices=_choices(read), when=when)
    if "low" not in read.values or "high" not in read.values:
        raise InputError(read.prefix[:-1], dict(read.values), "must have low and high, or choices")
    low, high, log = read.number("low"), read.number("high"), read.flag("log", False)
    if not low < high:
        raise read.refuse("low", f"must be below high, which is {high}")
    if log and low <= 0:
        raise read.refuse("low", "must be above 0 where log is true")
    step = read.number("step") if read.values.get("step") is not None else None
    if step is not None and not 0 < step <= high - low:
        raise read.refuse("step", f"must be above 0 and at most {high - low}, the width of the range")
    if step is not None and log:
        raise read.refuse("step", "must not stand beside log: true")
    if step is not None and (last := _steps(low, high, step)[-1]) != high:
        expected = f"must be reached by steps of {step} from {low}: {last} or {_next(last, step)}"
        raise read.refuse("high", expected)
    return Parameter(name, low=low, high=high, log=log, step=step, when=when)


def _next(value: float, step: float) -> Decimal:
    return Decimal(str(value)) + Decimal(str(step))


def _choices(read: Reader) -> tuple[Value, ...]:
    choices = read.values["choices"]
    if not isinstance(choices, list) or not choices:
        raise read.refuse("choices", "must be a list of values")
    for number, value in enumerate(choices):
        if not isinstance(value, Value):
            raise read.refuse("choices", "must be plain values: numbers, words, true, false, null")
        if is_one_of(value, choices[:number]):
            raise read.refuse("choices", f"must not hold {value} twice")
    return tuple(choices)


def _condition(read: Reader, above: Sequence[Parameter]) -> dict[str, tuple[Value, ...]]:
    when = read.below("when")
    parameters = {parameter.name: parameter for parameter in above}
    found = {}
    for name, value in when.values.items():
        values = tuple(value) if isinstance(value, list) else (value,)
        if name not in parameters or not parameters[name].choices:
            known = [other for other, parameter in parameters.items() if parameter.choices]
            expected = "must be the name of a parameter with choices that is declared above this one"
            raise InputError(when.prefix[:-1], name, f"{expected} ({', '.join(known) or 'there is none'})")
        possible = parameters[name].choices
        if not values or not all(is_one_of(item, possible) for item in values):
            raise when.refuse(name, f"must be one of its choices, or a list of some: {', '.join(map(shown, possible))}")
        found[str(name)] = values
    return found


def grid_points(space: Sequence[Parameter]) -> Iterator[dict[str, Value]]:
    """All points of a space, each once: where a condition does not hold, its parameter is left out.

    Raises
    ------
    InputError
        If a parameter is a range without steps.
    """
    for parameter in space:
        if parameter.values() is None:
            expected = "must have a step, or choices, for the sampler grid"
            raise InputError(f"space.{parameter.name}", parameter.plain(), expected)

    def below(number: int, point: dict[str, Value]) -> Iterator[dict[str, Value]]:
        if number == len(space):
            yield point
            return
        parameter = space[number]
        if not parameter.active(point):
            yield from below(number + 1, point)
            return
        for value in parameter.values() or ():
            yield from below(number + 1, {**point, parameter.name: value})

    yield from below(0, {})


def grid_size(space: Sequence[Parameter], most: int) -> int:
    """How many points a grid has, counted up to ``most`` + 1."""
    return sum(1 for _ in itertools.islice(grid_points(space), most + 1))


def diagonals(space: Sequence[Parameter]) -> Iterator[dict[str, Value]]:
    """A few points that have many choices and ends between them."""
    for number in range(max(len(parameter.probes) for parameter in space)):
        point: dict[str, Value] = {}
        for parameter in space:
            if parameter.active(point):
                point[parameter.name] = parameter.probes[number % len(parameter.probes)]
        yield point


def corners(space: Sequence[Parameter]) -> Iterator[tuple[Parameter, Value, list[dict[str, Value]]]]:
    """Each choice of each parameter, and the ends of each range with one value between, with two points that have it.

    In one all other ranges are at their low ends, in the other at their high ones, with first and last choices: a
    value that neither can be played with is wrong, most likely.
    """
    conditions = {parameter.name: parameter.when or {} for parameter in space}

    def needed(name: str) -> dict[str, Value]:
        found: dict[str, Value] = {}
        for other, values in conditions[name].items():
            found |= needed(other) | {other: values[0]}
        return found

    def fill(fixed: Mapping[str, Value], end: int) -> dict[str, Value]:
        point: dict[str, Value] = {}
        for parameter in space:
            if parameter.active(point):
                point[parameter.name] = fixed.get(parameter.name, parameter.probes[end])
        return point

    for parameter in space:
        for value in parameter.probes:
            fixed = {**needed(parameter.name), parameter.name: value}
            yield parameter, value, [fill(fixed, 0), fill(fixed, -1)]
