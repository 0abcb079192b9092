"""The frames of a FOLD file: all that each one inherits, and what its classes say that it shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from origami_lab.fold_format.checked_json import CheckedJson

PATTERN, FOLDED, OTHER, UNSAID, PASSED = "crease pattern", "folded form", "other", "unsaid", "passed over"
"""What a frame shows, by its classes: the flat sheet, a state of it, neither, or the file does not say."""


@dataclass(frozen=True, eq=False)
class FrameRecord:
    """One frame with the properties that it sets and those that it inherits."""

    index: int
    values: Mapping[str, Any]
    origin: Mapping[str, int]
    """Key → the frame that sets it."""

    def owns(self, key: str) -> bool:
        """Whether the frame sets a property itself."""
        return self.origin.get(key) == self.index

    def has(self, key: str) -> bool:
        """Whether the frame has a property, its own or inherited; null is none."""
        return self.values.get(key) is not None

    @property
    def name(self) -> str:
        """The frame in messages."""
        return f"frame {self.index}"

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes, its own or inherited."""
        found = self.values.get("frame_classes")
        return tuple(x for x in found if isinstance(x, str)) if isinstance(found, list) else ()

    @property
    def shows(self) -> str:
        """What the classes say."""
        pattern, folded = "creasePattern" in self.classes, "foldedForm" in self.classes
        if pattern != folded:
            return PATTERN if pattern else FOLDED
        return OTHER if not pattern and {"graph", "linkage"} & set(self.classes) else UNSAID

    @property
    def turned_in(self) -> int | None:
        """The frame that its fold angles are set in, None where it has none."""
        keys = [key for key in ("edges_foldAngle", "edges_foldAngles") if self.has(key)]
        return self.origin[keys[0]] if keys else None

    @property
    def turns(self) -> bool:
        """Whether the frame sets fold angles itself."""
        return self.turned_in == self.index


def all_frames(checked: CheckedJson, fold: Mapping[str, Any]) -> list[FrameRecord]:
    """The key frame and those that follow, each with what it inherits. Raises :class:`InputError`."""
    listed = fold.get("file_frames")
    listed = [] if listed is None else listed
    if not isinstance(listed, list) or any(not isinstance(frame, dict) for frame in listed):
        checked.refuse("file_frames", "must be a list of frames")
    own = [{key: value for key, value in fold.items() if key != "file_frames"}, *listed]
    parents = [None, *(_parent(checked, frame, len(own)) for frame in listed)]
    found: dict[int, FrameRecord] = {}
    for index in range(len(own)):
        chain, at = [index], parents[index]
        while at is not None and chain[-1] not in found:
            if at in chain:
                checked.refuse("frame_parent", "a frame must not inherit from itself")
            chain.append(at)
            at = parents[at]
        for number in reversed(chain):
            if number not in found:
                found[number] = _heir(number, own[number], found.get(parents[number]))  # type: ignore[arg-type]
    return [found[index] for index in range(len(own))]


def _parent(checked: CheckedJson, frame: Mapping[str, Any], count: int) -> int | None:
    """The number of the frame that one inherits from; the key frame where it does not say which."""
    if frame.get("frame_inherit") is not True:
        return None
    parent = frame.get("frame_parent")
    parent = 0 if parent is None else parent
    if isinstance(parent, bool) or not isinstance(parent, int) or not 0 <= parent < count:
        checked.refuse("frame_parent", f"must be a frame, 0 to {count - 1}")
    return parent


def _heir(index: int, own: Mapping[str, Any], parent: FrameRecord | None) -> FrameRecord:
    """A frame with all that it does not set taken from its parent; what describes the file is not inherited."""
    kept = [] if parent is None else [key for key in parent.values if not key.startswith("file_") and key not in own]
    values = {key: parent.values[key] for key in kept} | dict(own)  # type: ignore[union-attr]
    origin = {key: parent.origin[key] for key in kept} | dict.fromkeys(own, index)  # type: ignore[union-attr]
    return FrameRecord(index, values, origin)
