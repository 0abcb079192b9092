"""The one place where configuration becomes objects: game, target, objective and searcher."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hydra.errors import InstantiationException
from hydra.utils import instantiate

from origami_lab.errors import InputError
from origami_lab.experiment.locate import describe, locate
from origami_lab.experiment.settings import Node, Settings

if TYPE_CHECKING:
    from origami_lab.game.game import Game
    from origami_lab.objectives.targets import Target
    from origami_lab.search.problem import Searcher


@dataclass(frozen=True)
class Parts:
    """What a trial is made of. Fresh for each trial, so that no trial can depend on another."""

    game: Game
    target: Target | None
    objective: Any
    searcher: Searcher


def build_parts(settings: Settings) -> Parts:
    """Build and so check everything that the settings name.

    Raises
    ------
    InputError
        If a class cannot be imported, does not take the arguments, refuses their values, or is not what its place
        wants; whatever is raised on the way is said in one line with its file and line.
    """
    from origami_lab.experiment.interface import check_objective, check_searcher, check_target
    from origami_lab.game.game import Game  # here: it compiles or loads kernels

    start = _make("start", settings.start)
    game = Game(start=start, **_without_none(settings.game, "capacity"))
    target = None
    if settings.target is not None:
        target = _make("target", settings.target)
        check_target(settings.target["_target_"], target)
    extra = {} if target is None or not _wants_target(settings) else {"target": target}
    objective = _make("objective", settings.objective, **extra)
    check_objective(settings.objective["_target_"], objective)
    searcher = _make("search", settings.search)
    check_searcher(settings.search["_target_"], searcher)
    _let_refuse(settings.search["_target_"], searcher, game)
    return Parts(game, target, objective, searcher)


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


def _wants_target(settings: Settings) -> bool:
    return "target" in settings.config["objective"]


def _without_none(arguments: Node, *names: str) -> dict[str, Any]:
    """Leave out arguments whose None means "the callee's own default"."""
    return {key: value for key, value in arguments.items() if value is not None or key not in names}


def _make(field: str, node: Node, **extra: Any) -> Any:
    """Call the node's ``_target_``; ``extra`` arguments are passed on untouched."""
    for name in _targets(node):
        locate(field, name)  # says it better than Hydra
    name = node["_target_"]
    try:
        # _partial_, because Hydra turns dataclasses among the arguments of a call into configurations
        return instantiate(dict(node), _partial_=True, _convert_="all")(**extra)
    except InputError:
        raise
    except InstantiationException as error:  # of an argument that is a part itself, or Hydra refuses the target
        cause: BaseException = error
        while cause.__cause__ is not None:
            cause = cause.__cause__
        if isinstance(cause, InputError):
            raise cause from error
        raise InputError(field, name, f"cannot be made: {describe(cause)}") from error
    except Exception as error:
        if isinstance(error, TypeError) and (refused := _refused_arguments(name, field, node, extra)):
            raise InputError(field, name, f"does not take these arguments: {refused}") from error
        raise InputError(field, name, f"raised {describe(error)}") from error


def _targets(node: Any) -> Iterator[str]:
    """All that is to be located: the node's own ``_target_`` first, then those of its arguments."""
    if isinstance(node, Mapping):
        if isinstance(node.get("_target_"), str):
            yield node["_target_"]
        for value in node.values():
            yield from _targets(value)
    elif isinstance(node, list | tuple):
        for value in node:
            yield from _targets(value)


def _refused_arguments(name: str, field: str, node: Node, extra: Node) -> str | None:
    """Why the signature does not fit the arguments; None if it does, or has none."""
    keys = [key for key in node if key not in ("_target_", "_args_", "_convert_", "_partial_", "_recursive_")]
    try:
        inspect.signature(locate(field, name)).bind(*node.get("_args_", ()), **dict.fromkeys([*keys, *extra]))
    except TypeError as error:
        return str(error)
    except ValueError:
        return None
    return None
