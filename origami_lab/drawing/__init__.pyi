"""Public names, and the modules that they live in; each is imported when it is first used."""

from .folded_picture import draw_folded
from .motion_gif import draw_motion
from .motion_mp4 import draw_movie
from .notebook import show
from .pattern_picture import draw_pattern
from .scene import TargetSurface, read_target
from .viewer import viewer_page, write_viewer

__all__ = [
    "TargetSurface",
    "draw_folded",
    "draw_motion",
    "draw_movie",
    "draw_pattern",
    "read_target",
    "show",
    "viewer_page",
    "write_viewer",
]
