"""Whether a part that a user brought is one: what each must offer, checked before any work starts."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np

from origami_lab.errors import InputError
from origami_lab.objectives.targets import Target


def check_target(name: str, target: Any) -> None:
    """Raise InputError unless it is a target whose arrays describe a surface."""
    if not isinstance(target, Target):
        raise InputError(
            "target", name, f"returned {_kind(target)}; must return a Target (origami_lab.objectives.targets)"
        )
    vertices, faces = target.vertices, target.faces
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise InputError("target", name, f"vertices are {_shape(vertices)}; must be finite numbers of shape (V, 3)")
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
        raise InputError("target", name, f"faces are {_shape(faces)}; must have the shape (F, 3), F at least 1")
    if faces.min() < 0 or faces.max() >= len(vertices):
        expected = f"faces name vertices {faces.min()} to {faces.max()}; must be from 0 to {len(vertices) - 1}"
        raise InputError("target", name, expected)


def check_objective(name: str, objective: Any) -> None:
    """Raise InputError unless it can score sheets, or bind itself to a game (origami_lab.objectives.base)."""
    has = {method for method in ("bind", "report", "score") if callable(getattr(objective, method, None))}
    binds = {"bind", "report"} <= has
    if not binds and "score" not in has:
        if "bind" in has:
            raise InputError("objective", name, "has bind(game); must have report(game, actions, angle), too")
        raise InputError("objective", name, f"must make an object with a method score(sheet){_got(objective)}")
    _refuse_class("objective", name, objective)
    if binds:
        _check_call("objective", name, objective, "bind", ("game",))
    else:
        _check_call("objective", name, objective, "score", ("sheet",))
        if getattr(objective, "bound", None) is not None:
            _check_call("objective", name, objective, "bound", ("sheet",))
    if "report" in has:
        _check_call("objective", name, objective, "report", ("game", "actions", "angle"))
    for method in ("up", "front"):
        if getattr(objective, method, None) is not None:
            _check_call("objective", name, objective, method, ("design",))


def check_searcher(name: str, searcher: Any) -> None:
    """Raise InputError unless it has ``search(problem, rng)``; ``check_game(game)`` may be left out."""
    if not callable(getattr(searcher, "search", None)):
        raise InputError("search", name, f"must make an object with a method search(problem, rng){_got(searcher)}")
    _refuse_class("search", name, searcher)
    _check_call("search", name, searcher, "search", ("problem", "rng"))
    if getattr(searcher, "check_game", None) is not None:
        _check_call("search", name, searcher, "check_game", ("game",))


def _check_call(field: str, name: str, part: Any, method: str, arguments: tuple[str, ...]) -> None:
    """Refuse a method that cannot be called with these arguments, in this order."""
    function = getattr(part, method)
    wanted = f"must be def {method}({', '.join(('self', *arguments))})"
    if not callable(function):
        raise InputError(field, name, f"{method} is {_kind(function)}; {wanted}")
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError as error:
        raise InputError(field, name, f"{method} {wanted} ({error})") from error
    except ValueError as error:  # compiled functions have no signature; a method without self has a wrong one
        if inspect.ismethod(function):
            raise InputError(field, name, f"{method} {wanted} ({error})") from error


def _refuse_class(field: str, name: str, part: Any) -> None:
    if isinstance(part, type):
        raise InputError(field, name, f"returned the class {part.__name__}; must return an object of it")


def _kind(value: Any) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _got(value: Any) -> str:
    return ", made None" if value is None else f", made a {type(value).__name__} without one"


def _shape(array: np.ndarray[Any, Any]) -> str:
    return f"of shape {array.shape}"
