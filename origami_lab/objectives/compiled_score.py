"""Scores that compiled searches ask for themselves, so that Python hears of an episode only when it may be the best.

An evaluator whose score is compiled offers it as ``compiled_score``: a :class:`CompiledScore`, a named tuple of arrays
and numbers whose class says by :func:`answered_by` which kernels answer for it. Kernels that play take the tuple as an
argument and call :func:`bound_in_kernel`, :func:`best_in_kernel` and :func:`value_in_kernel`; they are compiled once
for each class. The answers are those of the evaluator's methods, to the last bit.

An objective of the user's own has none of this, and a class of the user's that overrides ``score`` or ``bound`` is
asked by these: see :func:`scores_itself`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from origami_lab.game.kernels.state import States
from origami_lab.jit import compiled_as
from origami_lab.objectives.objective import Memos

CompiledScore = Any
"""A named tuple whose class is decorated with :func:`answered_by`. To the kernels its class is a type of its own."""

Bound = Callable[[States, int, States, Memos, int, Any, float], float]
"""``bound(states, i, rules, memos, j, score, above)``: what no continuation of state i can exceed; any value not above
``above`` where none can. Memo j is the state's."""
Best = Callable[[States, int, States, Memos, int, Any, float], tuple[float, int]]
"""The same arguments: the score of state i and its driving angle's index; (−inf, −1) if it is not above ``above``."""
Value = Callable[[States, int, States, Memos, int, Any], float]
"""Without ``above``: the score of state i, whatever it is; −inf if there is none."""


class Kernels(NamedTuple):
    """What answers for a class of compiled scores: kernels, or functions that may be part of one."""

    bound: Bound
    best: Best
    value: Value


_KERNELS: dict[type, Kernels] = {}

C = TypeVar("C", bound=type)


def answered_by(bound: Bound, best: Best, value: Value) -> Callable[[C], C]:
    """Class decorator: which kernels answer for a class of compiled scores.

    Raises
    ------
    ValueError
        For a class outside of this package. Machine code is kept on disk by the contents of the package's files: that
        of a search would go on with kernels of another file as they were.
    """

    def decorate(cls: C) -> C:
        if cls.__module__.partition(".")[0] != __name__.partition(".")[0]:
            raise ValueError(f"{cls.__module__}.{cls.__qualname__}: only classes of the package have compiled scores")
        _KERNELS[cls] = Kernels(bound, best, value)
        return cls

    return decorate


def scores_itself(evaluator: Any) -> bool:
    """Whether an evaluator's answers are those of the package, none of them overridden by a subclass or an instance."""
    for name in ("score", "bound"):
        owner = next(cls for cls in type(evaluator).__mro__ if name in vars(cls))
        if name in vars(evaluator) or owner.__module__.partition(".")[0] != __name__.partition(".")[0]:
            return False
    return True


def bound_in_kernel(
    states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore, above: float
) -> float:
    """What no continuation of state i can exceed, see :data:`Bound`."""
    return _KERNELS[type(score)].bound(states, i, rules, memos, j, score, above)


def best_in_kernel(
    states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore, above: float
) -> tuple[float, int]:
    """The score of state i and its driving angle's index, see :data:`Best`."""
    return _KERNELS[type(score)].best(states, i, rules, memos, j, score, above)


def value_in_kernel(states: States, i: int, rules: States, memos: Memos, j: int, score: CompiledScore) -> float:
    """The score of state i, whatever it is, see :data:`Value`."""
    return _KERNELS[type(score)].value(states, i, rules, memos, j, score)


# what the three are to the compiler: the function that answers for the type of ``score``


def _plain(function: Callable[..., Any]) -> Any:
    """The function that a kernel was made of; any other as it is."""
    return getattr(function, "py_func", function)


@compiled_as(bound_in_kernel)
def _typed_bound(states: Any, i: Any, rules: Any, memos: Any, j: Any, score: Any, above: Any) -> Any:
    return _plain(_KERNELS[score.instance_class].bound)


@compiled_as(best_in_kernel)
def _typed_best(states: Any, i: Any, rules: Any, memos: Any, j: Any, score: Any, above: Any) -> Any:
    return _plain(_KERNELS[score.instance_class].best)


@compiled_as(value_in_kernel)
def _typed_value(states: Any, i: Any, rules: Any, memos: Any, j: Any, score: Any) -> Any:
    return _plain(_KERNELS[score.instance_class].value)
