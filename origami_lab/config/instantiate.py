"""The one place where configuration becomes objects: game, target, objective and searcher."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from origami_lab.config.dotted_path import describe, locate
from origami_lab.config.node import Node
from origami_lab.config.physical_size import aimed_return, thickness_in_cells
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError

if TYPE_CHECKING:
    from origami_lab.game.game import Game
    from origami_lab.search.problem import Searcher
    from origami_lab.targets.target import Target


@dataclass(frozen=True)
class Parts:
    """The parts of a trial; what can change is fresh for each, so that no trial can depend on another."""

    game: Game
    target: Target | None
    objective: Any
    searcher: Searcher

    def start_to_keep(self, settings: Settings) -> Node | None:
        """The start pattern as a run folder keeps it; None where placing it is an action of the game."""
        from origami_lab.game.start_from_moves import saved_start

        return saved_start(settings.start, self.game) if self.game.start_moves else None

    @property
    def lasting(self) -> dict[str, Any]:
        """The target and the objective, with the samples and trees that they made, if other trials may have them:
        ours never change.
        """
        ours = type(self.objective).__module__.startswith("origami_lab.")
        return {"target": self.target, "objective": self.objective} if ours else {}


def build_parts(settings: Settings, earlier: Parts | None = None) -> Parts:
    """Make everything that the settings name, then check it.

    Parameters
    ----------
    earlier
        Parts that were made from the same settings: what lasts is taken from them.

    Raises
    ------
    InputError
        If a class cannot be imported, does not take the arguments, refuses their values, or is not what its place
        wants; whatever is raised on the way is said in one line with its file and line.
    """
    game = build_game(settings)
    lasting = earlier.lasting if earlier else {}
    fields = [field for field in ("target", "objective", "search") if field not in lasting]
    made = lasting | _make_all(settings, *fields)
    _let_refuse(settings.search["_target_"], made["search"], game)
    if settings.polish:
        _check_polish(settings.polish, made["objective"])
    thickness_in_cells(settings, made["target"])
    for stage in (*settings.stages, settings.stage):
        if stage.target_return is not None:
            aimed_return(stage.target_return, settings, made["objective"], made["target"])
    return Parts(game, made["target"], made["objective"], made["search"])


def build_game(settings: Settings) -> Game:
    """The game alone; raises InputError as :func:`build_parts` does."""
    from origami_lab.game.game import Game  # here: it compiles or loads kernels

    return Game(start=_make("start", settings.start, settings.trust), **vars(settings.game))


def build_objective(settings: Settings) -> tuple[Target | None, Any]:
    """The target, if there is one, and the objective alone; raises InputError as :func:`build_parts` does."""
    made = _make_all(settings, "target", "objective")
    return made["target"], made["objective"]


def build_searcher(settings: Settings) -> Searcher:
    """A fresh searcher alone; raises InputError as :func:`build_parts` does."""
    searcher: Searcher = _make_all(settings, "search")["search"]
    return searcher


def _make_all(settings: Settings, *fields: str) -> dict[str, Any]:
    """The parts that the settings name, by field, made and then checked."""
    nodes = {field: getattr(settings, field) for field in fields}
    made: dict[str, Any] = {}
    try:
        for field, node in nodes.items():
            wants_target = field == "objective" and "target" in settings.config["objective"]
            extra = {"target": made["target"]} if wants_target else {}
            made[field] = None if node is None else _make(field, node, settings.trust, **extra)
    finally:  # what is wrong with one part may be why the next one could not be made: it is said first
        for field, part in made.items():
            if (node := nodes[field]) is not None:
                _CHECKS[field](node["_target_"], part)
    return made


def _let_refuse(name: str, searcher: Any, game: Game) -> None:
    """Let a searcher that can tell refuse the game now, instead of each trial later."""
    if getattr(searcher, "check_game", None) is None:
        return
    try:
        searcher.check_game(game)
    except InputError:
        raise
    except Exception as error:
        raise InputError("search", name, f"check_game raised {describe(error)}") from error


def _check_polish(steps: int, objective: Any) -> None:
    """Raise InputError unless designs for the objective can be polished."""
    from origami_lab.polish.polisher import ONLY_SHAPES, can_be_polished  # here: it brings kernels

    if not can_be_polished(objective):
        raise InputError("polish", steps, f"must be null: {type(objective).__name__} {ONLY_SHAPES}")


def _make(field: str, node: Node, trust: Sequence[str], **extra: Any) -> Any:
    """Call the node's ``_target_``; ``extra`` arguments are passed on untouched."""
    _check_names(field, node, trust)
    return _made(field, node, trust, extra)


def _check_names(field: str, value: Any, trust: Sequence[str], inner: bool = False) -> None:
    """Refuse a part, and those in its arguments, that may not be called, before any of them is."""
    if isinstance(value, Mapping):
        for key in value:
            if re.fullmatch(r"_\w*_", str(key)) and key != "_target_":
                raise InputError(f"{field}.{key}", value[key], "is no argument; of such keys there is only _target_")
        if "_target_" in value:
            locate(field, value["_target_"], trust, inner=inner)
        value = [item for key, item in value.items() if key != "_target_"]
    if isinstance(value, list | tuple):
        for item in value:
            _check_names(field, item, trust, inner=True)


def _made(field: str, node: Node, trust: Sequence[str], extra: Node, inner: bool = False) -> Any:
    """What the node's ``_target_`` returns, its arguments made first where they are parts themselves."""
    name = node["_target_"]
    call = locate(field, name, trust, inner=inner)
    arguments = {key: _argument(field, value, trust) for key, value in node.items() if key != "_target_"} | dict(extra)
    try:
        return call(**arguments)
    except InputError:
        raise
    except Exception as error:
        if isinstance(error, TypeError) and (refused := _refused_arguments(call, arguments)):
            raise InputError(field, name, f"does not take these arguments: {refused}") from error
        raise InputError(field, name, f"raised {describe(error)}") from error


def _argument(field: str, value: Any, trust: Sequence[str]) -> Any:
    if isinstance(value, Mapping):
        if "_target_" in value:
            return _made(field, value, trust, {}, inner=True)
        return {key: _argument(field, item, trust) for key, item in value.items()}
    return [_argument(field, item, trust) for item in value] if isinstance(value, list | tuple) else value


def _refused_arguments(call: Any, arguments: Node) -> str | None:
    """Why the signature does not fit the arguments; None if it does, or has none."""
    try:
        inspect.signature(call).bind(**arguments)
    except TypeError as error:
        return str(error)
    except ValueError:
        return None
    return None


def _check_target(name: str, target: Any) -> None:
    """Raise InputError unless it is a target whose arrays describe a surface."""
    from origami_lab.targets.target import Target  # here: it brings kernels

    if not isinstance(target, Target):
        raise InputError("target", name, f"returned {_kind(target)}; must return a Target of origami_lab.targets")
    vertices, faces = target.vertices, target.faces
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise InputError("target", name, f"vertices are {_shape(vertices)}; must be finite numbers of shape (V, 3)")
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
        raise InputError("target", name, f"faces are {_shape(faces)}; must have the shape (F, 3), F at least 1")
    if faces.min() < 0 or faces.max() >= len(vertices):
        expected = f"faces name vertices {faces.min()} to {faces.max()}; must be from 0 to {len(vertices) - 1}"
        raise InputError("target", name, expected)


def _check_objective(name: str, objective: Any) -> None:
    """Raise InputError unless it can score sheets, or bind itself to a game (origami_lab.objectives.objective)."""
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


def _check_searcher(name: str, searcher: Any) -> None:
    """Raise InputError unless it has ``search(problem, rng)``; ``check_game(game)`` may be left out."""
    if not callable(getattr(searcher, "search", None)):
        raise InputError("search", name, f"must make an object with a method search(problem, rng){_got(searcher)}")
    _refuse_class("search", name, searcher)
    _check_call("search", name, searcher, "search", ("problem", "rng"))
    saves = [method for method in ("save", "load") if callable(getattr(searcher, method, None))]
    if len(saves) == 1:
        raise InputError("search", name, f"has {saves[0]} and no {'load' if saves == ['save'] else 'save'}: needs both")
    if saves:
        _check_call("search", name, searcher, "save", ())
        _check_call("search", name, searcher, "load", ("state",))
    if getattr(searcher, "check_game", None) is not None:
        _check_call("search", name, searcher, "check_game", ("game",))


_CHECKS = {"target": _check_target, "objective": _check_objective, "search": _check_searcher}


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
