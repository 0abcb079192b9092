"""Settings of a run that goes on: what could not be said when it began stays as it was."""

from __future__ import annotations

from dataclasses import replace

from origami_lab.checks import check
from origami_lab.config.earlier_versions import (
    LATER_ARGUMENTS,
    LATER_KEYS,
    OTHER_TODAY,
    RULES_OTHER_TODAY,
    public_target,
)
from origami_lab.config.mesh_axis import as_it_was, is_mesh, with_target, without_up
from origami_lab.config.node import Node
from origami_lab.config.open_settings import DISTANCE, with_distance
from origami_lab.config.settings import Settings
from origami_lab.config.stages import Stage, check_larger, is_other_stage, known_stages, stage_node
from origami_lab.errors import InputError


def like_begun(settings: Settings, begun: Node) -> Settings:
    """The settings of a run that goes on, without what could not be said when it began: its parts stay as they were.

    Parameters
    ----------
    begun
        The configuration that the run was started with.
    """
    settings = _with_old_objective(_with_old_rules(settings, begun), begun)
    settings = _as_left_open(settings, begun)
    before = begun.get("target") or {}
    if settings.target is None or not (is_mesh(settings.target) and is_mesh(before)) or "up" in before:
        return settings
    return replace(
        settings, target=as_it_was(without_up(settings.target)), config=with_target(settings.config, without_up)
    )


def _with_old_rules(settings: Settings, begun: Node) -> Settings:
    """The settings with the rules of a game that could not be said when it began, where others hold today."""
    if not begun or begun.get("folder_format", 1) != 1:
        return settings
    old = {key: LATER_KEYS[key] for key in RULES_OTHER_TODAY}
    return replace(settings, game=replace(settings.game, **old), config={**settings.config, **old})


def _as_left_open(settings: Settings, begun: Node) -> Settings:
    """The settings with what the run began with, where they say nothing themselves."""
    before = (begun.get("objective") or {}).get("distance")
    if DISTANCE not in settings.left_open or before is None:
        return settings
    objective = {**settings.objective, "distance": before}
    return replace(settings, objective=objective, config=with_distance(settings.config, before))


def with_stages(settings: Settings, begun: Node) -> Settings:
    """The settings with the stages that the run has behind it: one more if it is asked for something else now.

    Raises
    ------
    InputError
        If it is asked for less than it had, or for stages that are not its own.
    """
    before, now = stage_node(begun), stage_node(settings.config)
    check_larger(before, now)
    known, said = known_stages(begun), known_stages(settings.config)
    if said and said != known:
        raise InputError("stages", said, "must be those of the run that goes on, or left out")
    nodes = [*known, before] if is_other_stage(before, now) else known
    stages = tuple(check(Stage, node) for node in nodes)
    return replace(settings, stages=stages, config={**settings.config, "stages": nodes})


def _with_old_objective(settings: Settings, begun: Node) -> Settings:
    """The settings with what an objective meant by arguments that it did not have, where that is another today."""
    before = begun.get("objective") or {}
    name = public_target(str(before.get("_target_")))
    old = {key: LATER_ARGUMENTS[name][key] for key in OTHER_TODAY.get(name, ())}
    was_said = begun.get("folder_format", 1) != 1  # today's folders say it
    if not old or was_said or public_target(str(settings.objective.get("_target_"))) != name:
        return settings
    written = {**settings.config, "objective": {**settings.config["objective"], **old}}
    return replace(settings, objective={**settings.objective, **old}, config=written)
