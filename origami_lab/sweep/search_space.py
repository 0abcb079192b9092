"""The space that a sweep searches: its parameters, which are settings, and when each of them is searched at all."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from origami_lab.checks import REFUSED, Flag, Kind, Number, Section, wrong
from origami_lab.config.checked_values import Value, check_own, override, shown
from origami_lab.errors import InputError

Point = Mapping[str, Value]
"""Values of those parameters that are searched under their conditions."""


_ANY = Number(-math.inf, math.inf, "must be a number")


class _Choices(Kind):
    """A list of values, each once."""

    expected = "must be a list of values"

    def take(self, value: Any) -> Any:
        if not isinstance(value, list) or not value:
            return REFUSED
        for number, item in enumerate(value):
            if not isinstance(item, Value):
                raise wrong("must be plain values: numbers, words, true, false, null")
            if is_one_of(item, value[:number]):
                raise wrong(f"must not hold {item} twice")
        return tuple(value)


class _Condition(Kind):
    """Names of parameters, each with one of their values or a list of some."""

    expected = "must be a mapping of keys to values"

    def take(self, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return REFUSED
        return {str(name): tuple(item) if isinstance(item, list) else (item,) for name, item in value.items()}


@dataclass(frozen=True)
class Parameter:
    """A setting and the values that it may take: ``choices``, or a range from ``low`` to ``high``, both ends in.

    A range is of whole numbers if its ends are. Where ``when`` does not hold, the setting keeps its default.
    """

    name: str = ""
    """The setting's key on the command line, e.g. search.sigma_1."""
    choices: Annotated[tuple[Value, ...], _Choices()] = ()
    low: Annotated[int | float, _ANY] = 0
    high: Annotated[int | float, _ANY] = 0
    log: Annotated[bool, Flag()] = False
    step: Annotated[int | float | None, _ANY] = None
    when: Annotated[Mapping[str, tuple[Value, ...]] | None, _Condition()] = None
    """Other parameters and those of their values under which this one is searched."""

    def __post_init__(self) -> None:
        low, high, step = self.low, self.high, self.step
        if self.choices:
            return
        if not low < high:
            raise wrong(f"must be below high, which is {high}", low, "low")
        if self.log and low <= 0:
            raise wrong("must be above 0 where log is true", low, "low")
        if step is None:
            return
        width = Decimal(str(high)) - Decimal(str(low))
        if not 0 < Decimal(str(step)) <= width:
            raise wrong(f"must be above 0 and at most {width}, the width of the range", step, "step")
        if self.log:
            raise wrong("must not stand beside log: true", step, "step")
        if (last := _steps(low, high, step)[-1]) != high:
            above = Decimal(str(last)) + Decimal(str(step))
            raise wrong(f"must be reached by steps of {step} from {low}: {last} or {above}", high, "high")

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


class _Spec(Section):
    """A parameter as it is written in the file."""

    def read(self, value: Any, known: Sequence[str]) -> Any:
        value = super().read(value, known)
        if "choices" in value:
            for key in ("low", "high", "log", "step"):
                if key in value:
                    raise wrong("must not stand beside choices", value[key], key)
        elif not {"low", "high"} <= value.keys():
            raise wrong("must have low and high, or choices", dict(value))
        return value


class Space:
    """The ``space`` of a sweep's file: a mapping of names to parameters, which becomes a tuple of these.

    A parameter's condition names parameters with choices above it, and some of these.
    """

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        parameters = handler.generate_schema(dict[str, Annotated[Parameter, _Spec(hidden=("name",))]])
        before = core_schema.no_info_before_validator_function(self._names, parameters)
        return core_schema.no_info_after_validator_function(self._parameters, before)

    @staticmethod
    def _names(value: Any) -> Any:
        if not isinstance(value, Mapping):
            raise wrong("must be a mapping of keys to values")
        for name in value:
            check_own(str(name), allowed=("search",))
        if not value:
            raise wrong("must name at least one setting, e.g. search.sigma_1: {low: 0.01, high: 1}", "{}")
        return {str(name): parameter for name, parameter in value.items()}

    @staticmethod
    def _parameters(space: Mapping[str, Parameter]) -> tuple[Parameter, ...]:
        choices: dict[str, tuple[Value, ...]] = {}
        for name, parameter in space.items():
            for other, values in (parameter.when or {}).items():
                if other not in choices:
                    expected = "must be the name of a parameter with choices that is declared above this one"
                    raise wrong(f"{expected} ({', '.join(choices) or 'there is none'})", other, f"{name}.when")
                if not values or not all(is_one_of(value, choices[other]) for value in values):
                    possible = ", ".join(map(shown, choices[other]))
                    given = values[0] if len(values) == 1 else list(values)
                    expected = f"must be one of its choices, or a list of some: {possible}"
                    raise wrong(expected, given, f"{name}.when.{other}")
            if parameter.choices:
                choices[name] = parameter.choices
        return tuple(replace(parameter, name=name) for name, parameter in space.items())


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
