"""Checks of what a user sets: kinds of values, declared beside a type, and pydantic's errors in one line.

A kind stands in the type of a dataclass's field or of an argument, ``Annotated[int, Whole(1, 100)]``, and says both
which values it takes and how a refusal ends. pydantic walks the fields; it is imported by the first check.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, TypeVar, cast, get_args, get_type_hints

from origami_lab.errors import InputError
from origami_lab.files import expanded
from origami_lab.text import nearest

if TYPE_CHECKING:
    from pydantic import TypeAdapter, ValidationError
    from pydantic_core import CoreSchema, PydanticCustomError

T = TypeVar("T")
P = ParamSpec("P")

LARGEST = sys.float_info.max
"""Numbers beyond this are none: also whole ones of more digits, which no float can be."""
REFUSED = object()
"""The answer of a kind to a value that it does not take."""
_GIVEN = object()


def wrong(expected: str, value: object = _GIVEN, key: str = "") -> PydanticCustomError:
    """The error that a validator of pydantic raises; :func:`check` makes one line of it.

    Parameters
    ----------
    expected
        The end of the line: what would be right.
    value
        The value to show, where it is not the whole that is validated.
    key
        The key below the one that is validated, where that is at fault.
    """
    from pydantic_core import PydanticCustomError

    return PydanticCustomError("wrong", "{expected}", {"expected": expected, "value": value, "key": key})


class Kind:
    """A kind of values. A field whose type allows None takes that, too, and its messages end in "or null"."""

    expected: str

    def take(self, value: Any) -> Any:
        """The value as it is used, or ``REFUSED``."""
        raise NotImplementedError

    def message(self, value: Any) -> str:
        """The end of the sentence "... must be": a value that would be right."""
        return self.expected

    def shown(self, value: Any) -> Any:
        """A refused value as the message shows it."""
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], CoreSchema]) -> CoreSchema:
        from pydantic_core import core_schema

        types = get_args(source) or (source,)
        nullable, only_float = NoneType in types, float in types and int not in types

        def check(value: Any) -> Any:
            if value is None and nullable:
                return None
            taken = self.take(value)
            if taken is REFUSED:
                message = self.message(value)
                says_null = not message.startswith("must") or "or null" in message
                raise wrong(f"{message}, or null" if nullable and not says_null else message, self.shown(value))
            return float(taken) if only_float and isinstance(taken, int) else taken

        return core_schema.no_info_plain_validator_function(check)


class Whole(Kind):
    """A whole number from ``low`` to ``high``; 1e6, a float to YAML, is one."""

    def __init__(self, low: int, high: int, expected: str = "") -> None:
        self.low, self.high, self.expected = low, high, expected

    def take(self, value: Any) -> Any:
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        good = isinstance(value, int) and not isinstance(value, bool) and self.low <= value <= self.high
        return value if good else REFUSED

    def shown(self, value: Any) -> Any:
        return int(value) if isinstance(value, float) and value.is_integer() else value

    def message(self, value: Any) -> str:
        endless = self.high >= 10**9 and not (isinstance(value, int | float) and value > self.high)
        return self.expected or f"must be a whole number from {self.low}" + ("" if endless else f" to {self.high}")


class Odd(Whole):
    """An odd number from ``low`` to ``high``."""

    def take(self, value: Any) -> Any:
        value = super().take(value)
        return value if value is not REFUSED and value % 2 else REFUSED

    def message(self, value: Any) -> str:
        even = super().take(value)
        return super().message(value) + ("" if even is REFUSED else f", e.g. {even - 1} or {even + 1}")


class Number(Kind):
    """A finite number from ``low`` to ``high``, with ``between`` neither of them, or one of some ``words``."""

    def __init__(
        self, low: float, high: float, expected: str = "", *, between: bool = False, words: Sequence[str] = ()
    ) -> None:
        self.low, self.high, self.between, self.words = low, high, between, words
        self.expected = expected or f"must be a number from {low:g} to {high:g}"

    def take(self, value: Any) -> Any:
        if isinstance(value, str) and value in self.words:
            return value
        if isinstance(value, bool) or not isinstance(value, int | float) or not -LARGEST <= value <= LARGEST:
            return REFUSED
        inside = self.low < value < self.high if self.between else self.low <= value <= self.high
        return value if inside else REFUSED


class Flag(Kind):
    """True or false."""

    expected = "must be true or false"

    def take(self, value: Any) -> Any:
        return value if isinstance(value, bool) else REFUSED


class Choice(Kind):
    """One of some words; of a mapping, what it stands for."""

    def __init__(self, words: Sequence[str] | Mapping[str, Any]) -> None:
        self.words = words if isinstance(words, Mapping) else dict(zip(words, words, strict=True))
        self.expected = f"must be one of {', '.join(words)}"

    def take(self, value: Any) -> Any:
        return self.words.get(value, REFUSED) if isinstance(value, str) else REFUSED

    def message(self, value: Any) -> str:
        return self.expected + nearest(str(value), self.words)


class Word(Kind):
    """A word that is also fit to be the name of a folder."""

    expected = "must be a word of at most 100 letters, digits, '.', '_', '+' and '-'"

    def take(self, value: Any) -> Any:
        return value if isinstance(value, str) and re.fullmatch(r"\w[\w.+-]{,99}", value) else REFUSED


class Text(Kind):
    """A text that is not blank; with ``numbers`` a number is one, too, as in ``output=5``."""

    def __init__(self, expected: str = "must be a text", numbers: bool = True, longest: float = math.inf) -> None:
        self.expected, self.numbers, self.longest = expected, numbers, longest

    def take(self, value: Any) -> Any:
        if self.numbers and isinstance(value, int | float) and not isinstance(value, bool):
            value = str(value)
        taken = isinstance(value, str) and value.strip() and "\0" not in value and len(value) <= self.longest
        return value if taken else REFUSED

    def message(self, value: Any) -> str:
        too_long = isinstance(value, str) and len(value) > self.longest
        return self.expected + f" of at most {self.longest:g} characters" * too_long


class Folder(Text):
    """The path of a folder, which need not be there."""

    def __init__(self, expected: str = "must be a folder") -> None:
        super().__init__(expected)

    def take(self, value: Any) -> Any:
        text = super().take(value)
        if text is REFUSED:
            return REFUSED
        path = expanded(text)
        return REFUSED if path.parts[:1] == ("~",) else path  # a home that is not known would be a folder of that name


class ExistingFolder(Folder):
    """The path of a folder that is there."""

    def message(self, value: Any) -> str:
        return "there is no such folder" if super().take(value) is not REFUSED else super().message(value)

    def take(self, value: Any) -> Any:
        path = super().take(value)
        return path if path is not REFUSED and path.is_dir() else REFUSED


class ListOf(Kind):
    """A list of values of one kind, at least one."""

    def __init__(self, kind: Kind, expected: str) -> None:
        self.kind, self.expected = kind, expected

    def take(self, value: Any) -> Any:
        taken = [self.kind.take(item) for item in value] if isinstance(value, list | tuple) else []
        return taken if taken and REFUSED not in taken else REFUSED


class Section:
    """A mapping whose keys are the fields of a dataclass and no others; null stands for an empty one.

    Parameters
    ----------
    short
        The key of a single word that stands for the whole mapping.
    hidden
        Fields that no key sets.
    """

    def __init__(self, short: str = "", hidden: Sequence[str] = ()) -> None:
        self.short, self.hidden = short, hidden

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], CoreSchema]) -> CoreSchema:
        from pydantic_core import core_schema

        known = [field.name for field in dataclasses.fields(source) if field.name not in self.hidden]
        return core_schema.no_info_before_validator_function(lambda value: self.read(value, known), handler(source))

    def read(self, value: Any, known: Sequence[str]) -> Any:
        """The mapping; raises what :func:`wrong` makes."""
        value = {} if value is None else {self.short: value} if self.short and isinstance(value, str) else value
        if not isinstance(value, Mapping):
            raise wrong(
                "must be a mapping of keys to values" + f", or one word for its {self.short}" * bool(self.short)
            )
        for key in value:
            if key not in known:
                expected = f"there is no such key{nearest(str(key), known)}; must be one of {', '.join(known)}"
                raise wrong(expected, value[key], str(key))
        return value


@functools.cache
def _adapter(kind: Any, section: Section | None) -> TypeAdapter[Any]:
    from pydantic import TypeAdapter

    return TypeAdapter(kind if section is None else Annotated[kind, section])


def check(
    kind: type[T], values: Mapping[str, Any], keys: Mapping[str, str] | None = None, section: Section | None = None
) -> T:
    """An object of a dataclass whose fields are checked by their kinds.

    Parameters
    ----------
    kind
        The dataclass.
    values
        Its fields, unchecked.
    keys
        Names of fields as the user writes them, where they are other ones.
    section
        How the mapping itself is read; None where keys without a field are no mistake.

    Raises
    ------
    InputError
        For the first value that is wrong or missing.
    """
    from pydantic import ValidationError

    try:
        checked: T = _adapter(cast("Any", kind), section).validate_python(values)
    except ValidationError as error:
        raise _input_error(error, "", keys) from None
    return checked


def checked_arguments(prefix: str) -> Callable[[Callable[P, None]], Callable[P, None]]:
    """A decorator of ``__init__``: arguments are checked by the kinds in their annotations.

    A wrong one is an InputError that names ``prefix`` and the argument. Arguments that the signature does not have are
    Python's TypeError.
    """

    def decorate(init: Callable[P, None]) -> Callable[P, None]:
        signature = inspect.signature(init)

        @functools.cache
        def validated() -> Callable[..., None]:
            from pydantic import validate_call

            return validate_call(init)

        @functools.wraps(init)
        def checked(*args: P.args, **kwargs: P.kwargs) -> None:
            from pydantic import ValidationError

            (_, instance), *arguments = signature.bind(*args, **kwargs).arguments.items()
            try:
                validated()(instance, **dict(arguments))
            except ValidationError as error:
                raise _input_error(error, prefix) from None

        return checked

    return decorate


def check_fields(instance: object, prefix: str) -> None:
    """Check the fields of a dataclass by the kinds in their annotations, in its ``__post_init__``.

    Raises
    ------
    InputError
        For the first wrong one, named by ``prefix`` and the field.
    """
    from pydantic import ValidationError

    for name, kind in get_type_hints(type(instance), include_extras=True).items():
        try:
            value = _adapter(kind, None).validate_python(getattr(instance, name))
        except ValidationError as error:
            raise _input_error(error, f"{prefix}.{name}") from None
        object.__setattr__(instance, name, value)


def _input_error(error: ValidationError, prefix: str, keys: Mapping[str, str] | None = None) -> InputError:
    """pydantic's first error as one of ours."""
    first = error.errors(include_url=False)[0]
    place, value, said = [str(part) for part in first["loc"]], first["input"], first.get("ctx", {})
    key = ".".join([prefix, *((keys or {}).get(part, part) for part in place), said.get("key", "")])
    if first["type"] == "missing":
        return InputError(key.strip("."), "(nothing)", "is missing from the configuration")
    value = said.get("value", _GIVEN) if said.get("value", _GIVEN) is not _GIVEN else value
    return InputError(key.strip("."), value, said.get("expected") or f"cannot be used: {first['msg']}")
