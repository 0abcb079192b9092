"""Names and settings of earlier versions: runs on disk, and parts of the user's own, may be of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_PUBLIC = {
    "objectives.targets": ("targets", "bowl cube pyramid mesh"),
    "objectives.face": ("targets", "face"),
    "objectives.shape": ("objectives", "ShapeObjective"),
    "objectives.bucket": ("objectives", "BucketObjective"),
    "objectives.chair": ("objectives", "ChairObjective"),
    "objectives.packaging": ("objectives", "PackagingObjective"),
    "objectives.shelf": ("objectives", "ShelfObjective"),
    "objectives.table": ("objectives", "TableObjective"),
    "game.starts": ("game", "Square Crease"),
    "game.seeding": ("game", "FromFile FromMoves"),
    "search.tree": ("search", "BreadthFirstSearch DepthFirstSearch"),
    "search.random": ("search", "RandomSearch"),
    "search.evo": ("search", "EvolutionarySearch"),
    "search.mcts": ("search", "MonteCarloTreeSearch"),
    "search.ppo": ("search", "ProximalPolicyOptimization"),
    "experiment.multirun": ("multirun", "CheckJobs"),
}
"""Module of version 0.1.0 → package, and those of its names that a ``_target_`` could bear."""

OLD_TARGETS = {
    f"origami_lab.{module}.{name}": f"origami_lab.{package}.{name}"
    for module, (package, names) in _PUBLIC.items()
    for name in names.split()
}
"""Dotted path in files of version 0.1.0 → public name."""

_MODULES = {
    "objectives.base": "objectives",
    "objectives.abstract": "objectives",
    "objectives.mesh_file": "targets",
    "objectives.mesh_reading": "targets",
    "objectives.coverage": "objectives",
    "game.folded": "game",
    "game.pattern": "game",
    "game.pattern_file": "game",
    "search.draws": "search",
    "search.episodes": "search",
    "export.fold": "fold_format",
    "export.foldfile": "fold_format",
    "export.motion": "fold_format",
    "export.polygons": "fold_format",
    "export.reading": "fold_format",
    "export.mesh": "export",
    "export.cut": "export",
    "reporting": "drawing",
    "reporting.exporting": "export",
    "reporting.tables": "runs",
    "verification.checking": "verification",
    "report.build": "report",
    "experiment.build": "config",
    "experiment.composing": "config",
    "experiment.folder": "runs",
    "experiment.result": "runs",
    "experiment.seeds": "config",
    "experiment.settings": "config",
}
"""Modules of version 0.1.0 whose names were imported by parts and scripts, and the package that has them now."""


LATER_KEYS: dict[str, Any] = {
    **{"files": "all", "folder_format": 1, "report_order": {"task": None, "method": None}},
    **{"polish": None, "polish_seconds": None, "polish_simplify": None},
    "straight_sectors": False,
    **{"min_crease_length": None, "min_sector_angle": None, "min_panel_width": None},
    **{"cell": None, "sheet": None, "thickness": None},
    **{"target_return": None, "minutes": None, "stages": []},
    "trust": [],  # never in a file
}
"""Settings that came later → what a run meant that does not have them."""

LATER_IN_GROUPS: dict[str, dict[str, Any]] = {"board": {"width": None, "height": None}}
"""Keys of groups that came later, likewise."""


LATER_ARGUMENTS: dict[str, dict[str, Any]] = {
    "origami_lab.game.Square": {"position": None},
    "origami_lab.game.Crease": {"ends": None, "stays": "upper"},
    "origami_lab.targets.mesh": {"board_width": None, "board_height": None, "cell": None, "skin": None, "unit": None},
    "origami_lab.objectives.BucketObjective": {"norm_of": "leaves"},
    "origami_lab.search.BreadthFirstSearch": {"aspiration": None, "inside_moves": False},
    "origami_lab.search.DepthFirstSearch": {"aspiration": None, "inside_moves": False},
}
"""Arguments of ours that came later, by the public name → what a run meant that does not have them."""


OTHER_TODAY: dict[str, tuple[str, ...]] = {"origami_lab.objectives.BucketObjective": ("norm_of",)}
"""Those of them whose default is another today: a run that goes on keeps to what it meant."""

RULES_OTHER_TODAY = ("straight_sectors",)
"""Settings of the game, likewise."""


def game_of_today(saved: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a game of any version, as they stand in an actions.json, with those that came later."""
    found = {**{key: LATER_KEYS[key] for key in RULES_OTHER_TODAY}, **saved}
    return {key: value for key, value in found.items() if key != "capacity" or value is not None}  # the game's own


def public_target(path: str) -> str:
    """The public name of a ``_target_``; a path that is no old one of ours stays as it is."""
    return OLD_TARGETS.get(path, path)


def with_public_targets(value: Any) -> Any:
    """A configuration with public names for all ``_target_`` in it, at any depth, and the arguments that came later."""
    if isinstance(value, Mapping):
        found = {key: with_public_targets(item) for key, item in value.items()}
        if isinstance(path := found.get("_target_"), str):
            found["_target_"] = public_target(path)
            found = {**LATER_ARGUMENTS.get(found["_target_"], {}), **found}
        return found
    return [with_public_targets(item) for item in value] if isinstance(value, list) else value


def as_of_today(config: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration of a run of any version, with today's names and with all settings."""
    found = {**LATER_KEYS, **with_public_targets(config)}
    for group, later in LATER_IN_GROUPS.items():
        if isinstance(found.get(group), Mapping):
            found[group] = {**later, **found[group]}
    return found


def new_home(module: str) -> str | None:
    """The package that now exports what a module of version 0.1.0 held; None for any other module."""
    root, _, rest = module.partition(".")
    if root != "origami_lab":
        return None
    while rest:
        package = _MODULES.get(rest) or (_PUBLIC[rest][0] if rest in _PUBLIC else None)
        if package is not None:
            return f"origami_lab.{package}"
        rest = rest.rpartition(".")[0]
    return None
