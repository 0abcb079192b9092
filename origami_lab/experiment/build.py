"""The one place where configuration becomes objects: game, target, objective and searcher."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hydra.errors import InstantiationException
from hydra.utils import instantiate

from origami_lab.errors import InputError
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
        If a class cannot be imported, does not take the arguments, or refuses their values.
    """
    from origami_lab.game.game import Game  # here: it compiles or loads kernels

    start = _make("start", settings.start)
    game = Game(start=start, **_without_none(settings.game, "capacity"))
    target = None if settings.target is None else _make("target", settings.target)
    extra = {} if target is None or not _wants_target(settings) else {"target": target}
    objective = _make("objective", settings.objective, **extra)
    if not any(callable(getattr(objective, name, None)) for name in ("bind", "score")):
        raise InputError("objective", settings.objective["_target_"], "must have a method score(sheet)")
    searcher = _make("search", settings.search)
    if not callable(getattr(searcher, "search", None)):
        raise InputError("search", settings.search["_target_"], "must have a method search(problem, rng)")
    return Parts(game, target, objective, searcher)


def _wants_target(settings: Settings) -> bool:
    return "target" in settings.config["objective"]


def _without_none(arguments: Node, *names: str) -> dict[str, Any]:
    """Leave out arguments whose None means "the callee's own default"."""
    return {key: value for key, value in arguments.items() if value is not None or key not in names}


def _make(field: str, node: Node, **extra: Any) -> Any:
    """Call the node's ``_target_``; ``extra`` arguments are passed on untouched."""
    # _partial_, because Hydra turns dataclasses among the arguments of a call into configurations
    try:
        return instantiate(dict(node), _partial_=True, _convert_="all")(**extra)
    except InputError:
        raise
    except InstantiationException as error:
        cause = error.__cause__
        if isinstance(cause, InputError):
            raise cause from error
        raise InputError(field, node["_target_"], f"cannot be loaded: {_reason(error)}") from error
    except TypeError as error:
        raise InputError(field, node["_target_"], f"does not take these arguments: {error}") from error


def _reason(error: BaseException) -> str:
    """What went wrong first, in one line."""
    while error.__cause__ is not None:
        error = error.__cause__
    lines = str(error).splitlines()
    return f"{type(error).__name__}: {lines[0] if lines else ''}"
