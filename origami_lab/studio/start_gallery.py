"""What a design can be begun for from the page: names of closed lists, so that no message holds a path or a setting."""

from __future__ import annotations

from pathlib import Path

from origami_lab.config.node import flatten
from origami_lab.config.option_files import read_options
from origami_lab.studio.replies import GalleryTask

DEFAULT = "default"
STARTS = {
    DEFAULT: (),
    "square": ("start=square",),
    "rectangle": ("start=rectangle",),
    "crease": ("start=crease", "symmetry=y"),
}
"""Start patterns that need nothing to be given, with the settings that they mean."""
_SAYS = {
    "pyramid": "four flaps that meet in an apex",
    "cube": "a cube with a lid in two halves",
    "bowl": "a round bowl",
    "face": "a face, from a single crease",
    "bucket": "a rim as high as possible",
    "shelf": "levels above each other",
    "table": "four feet and a top",
    "chair": "a seat, legs and a backrest",
    "packaging": "much surface in little room",
}


def tasks(own: Path | None = None) -> list[GalleryTask]:
    """The targets and objectives of the configuration, and of a folder of the user's, that need nothing to be given."""
    found = []
    for group in ("target", "objective"):
        for name, content in sorted(read_options(group, own).items()):
            whole = "???" not in flatten(content).values()
            if whole and (group == "objective" or content.get("target") is not None) and name != "shape":
                found.append(GalleryTask(name=name, group=group, says=_SAYS.get(name, "")))
    return found


def settings_of(task: str, start: str, own: Path | None = None) -> list[str] | None:
    """The settings that a choice means; None for names that are in none of the lists."""
    groups = {known.name: known.group for known in tasks(own)}
    if task not in groups or start not in STARTS:
        return None
    return [f"{groups[task]}={task}", *STARTS[start]]
