"""Settings of a run that goes on: what could not be said when it began stays as it was."""

from __future__ import annotations

from dataclasses import replace

from origami_lab.config.mesh_axis import as_it_was, is_mesh, with_target, without_up
from origami_lab.config.node import Node
from origami_lab.config.settings import Settings


def like_begun(settings: Settings, begun: Node) -> Settings:
    """The settings of a run that goes on, without what could not be said when it began: its target stays as it was.

    Parameters
    ----------
    begun
        The configuration that the run was started with.
    """
    before = begun.get("target") or {}
    if settings.target is None or not (is_mesh(settings.target) and is_mesh(before)) or "up" in before:
        return settings
    return replace(
        settings, target=as_it_was(without_up(settings.target)), config=with_target(settings.config, without_up)
    )
