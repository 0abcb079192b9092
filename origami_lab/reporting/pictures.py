"""The pictures of a design; they need nothing but the files of its run folder."""

from __future__ import annotations

from origami_lab.reporting.folded_picture import draw_folded
from origami_lab.reporting.motion import draw_motion
from origami_lab.reporting.pattern_picture import draw_pattern
from origami_lab.reporting.scene import TargetSurface, read_target

__all__ = ["TargetSurface", "draw_folded", "draw_motion", "draw_pattern", "read_target"]
