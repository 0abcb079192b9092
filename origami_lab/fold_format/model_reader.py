"""The reader of FOLD files of any program: its frames become one model."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.fold_format.checked_json import CheckedJson, line
from origami_lab.fold_format.file_digits import precision, rounding
from origami_lab.fold_format.flat_graph import Array, Face, Indices, area
from origami_lab.fold_format.flat_plane import lay_into_plane
from origami_lab.fold_format.fold_angles import measured_angles
from origami_lab.fold_format.frames import FOLDED, OTHER, PASSED, PATTERN, UNSAID, FrameRecord, all_frames
from origami_lab.fold_format.keys import ACTIONS, ANGLE, DRIVEN, METADATA, MODE
from origami_lab.fold_format.laid_flat import run_alike
from origami_lab.fold_format.loose_lines import auxiliary_lines, without_spurs
from origami_lab.fold_format.model import SAME_PLACE, FoldModel, FoldState, Limits, panels_of

_LEVEL = 1e-6
"""Of the pattern's size: a crease pattern that is no further off its plane is flat."""
_COUNTED = ("vertices", "edges", "faces")


def read_model(path: str | os.PathLike[str], frame: int | None = None, limits: Limits | None = None) -> FoldModel:
    """Read a FOLD file of any program.

    Parameters
    ----------
    frame
        The frame that is wanted, where a file has several patterns or states; by default the first crease pattern.

    Raises :class:`InputError`, whose field is the path, on a file that is not FOLD or too large.
    """
    return ModelReader(Path(path), limits or Limits()).model(frame)


class ModelReader:
    """One file being read."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.path, self.limits, self.checked = path, limits, CheckedJson(path, limits.bytes)
        self.remarks: list[str] = []
        self.unread: list[str] = []

    def model(self, wanted: int | None) -> FoldModel:
        """The whole file."""
        fold = self.checked.load()
        listed = fold.get("file_frames")
        self.bound(len(listed) if isinstance(listed, list) else 0, self.limits.frames, "frames")
        frames = all_frames(self.checked, fold)
        for frame in frames:  # before anything is looked at item by item
            for what, most in zip(_COUNTED, (self.limits.vertices, self.limits.edges, self.limits.faces), strict=True):
                rows = frame.values.get(f"{what}_{'coords' if what == 'vertices' else 'vertices'}")
                self.bound(len(rows) if isinstance(rows, list) else 0, most, what)
        shows = self.shown(frames)
        base = self.base(frames, shows, wanted)
        size = len(self.checked.coordinates(base.values, None)) if base.has("vertices_coords") else 0
        if not size:
            self.checked.array(base.values, "vertices_coords", None)
        self.bound(size, self.limits.vertices, "vertices")
        edges = np.array(self.checked.edges(base.values, size), dtype=np.int64).reshape(-1, 2)
        self.bound(len(edges), self.limits.edges, "edges")
        faces = self.faces(base, frames, size)
        letters = self.checked.letters(base.values, len(edges))
        degrees = self.checked.angles(base.values, len(edges))
        flat = shows[base.index] == PATTERN
        states = self.states(frames, shows, base, size, edges, flat)
        model = FoldModel(
            index=base.index,
            flat=None,
            edges=edges,
            faces=faces,
            letters=letters,
            angles=np.radians(degrees) if flat and degrees is not None else None,
            loose=np.zeros(len(edges), dtype=np.bool_),
            modes=self.numbers(base, MODE, size, (-1, 0, 1), np.int8),
            driven=self.numbers(base, DRIVEN, len(edges), (False, True), np.bool_),
            declared=base.shows in (PATTERN, FOLDED),
            states=tuple(states),
            creator=line(fold.get("file_creator")),
            title=line(fold.get("file_title")) or line(base.values.get("frame_title")),
            actions=self.checked.integers(fold, ACTIONS),
            metadata=self.checked.record(fold, METADATA),
        )
        coords = self.checked.coordinates(base.values, None)
        used = np.unique(edges)
        folded = [state.coords[used] for state in states if state.coords is not None]
        stated = [degrees] if degrees is not None and flat else []
        stated += [np.degrees(state.angles) for state in states if state.angles is not None]
        model = replace(model, precision=precision(coords[used] if flat else None, folded, stated))
        model = self.laid(model, coords) if flat else self.turned(model)
        if wanted is not None and shows[wanted] != PATTERN:
            chosen = [k for k, state in enumerate(states) if state.index == wanted]
            if not chosen:
                self.no_frame(wanted, "is no state that can be shown")
            model = replace(model, chosen=chosen[0])
        return replace(model, remarks=tuple(self.remarks), unread=tuple(self.unread))

    def bound(self, count: int, most: int | None, what: str) -> None:
        """Refuse what is too large."""
        if most is not None and count > most:
            self.checked.refuse(f"{count} {what}", f"must be at most {most}")

    def no_frame(self, wanted: int, why: str) -> NoReturn:
        """Refuse a frame that was asked for."""
        raise InputError("frame", wanted, f"{why} in {self.path}")

    def numbers(
        self, base: FrameRecord, key: str, length: int, allowed: tuple[int, ...], kind: Any
    ) -> NDArray[Any] | None:
        """A key of ours as an array."""
        values = self.checked.optional(base.values, key, length, allowed)
        return None if values is None else np.array(values, dtype=kind)

    # what the frames show

    def shown(self, frames: list[FrameRecord]) -> list[str]:
        """What each frame shows; what is not said is a crease pattern if it lies in a plane and is the first such."""
        shows = [frame.shows for frame in frames]
        if OTHER in shows and not {PATTERN, FOLDED, UNSAID} & set(shows):
            shows = [UNSAID if show == OTHER else show for show in shows]
        for frame in frames:
            if shows[frame.index] == PATTERN and not frame.owns("frame_classes") and frame.owns("vertices_coords"):
                if not self.level(frame):
                    self.remarks.append(
                        f"{frame.name} inherits the class creasePattern but is not flat: taken as folded"
                    )
                    shows[frame.index] = FOLDED
        for frame in frames:
            origin = frame.origin.get("vertices_coords", frame.index)
            if shows[frame.index] == PATTERN and shows[origin] == FOLDED:
                self.remarks.append(f"{frame.name} is called a crease pattern but has the coordinates of a folded form")
                shows[frame.index] = PASSED
        known = PATTERN in shows
        for frame in frames:
            if shows[frame.index] != UNSAID:
                continue
            shows[frame.index] = FOLDED
            if not (frame.has("edges_vertices") or frame.has("faces_vertices")) and len(frames) > 1:
                shows[frame.index] = PASSED
                alone = not any(frame.index in other.origin.values() for other in frames if other is not frame)
                if alone and (frame.owns("vertices_coords") or frame.turns):
                    self.remarks.append(f"{frame.name} has neither edges nor a class, and is not looked at")
            elif frame.has("vertices_coords") and not known and self.level(frame) and not self.folded_flat(frame):
                shows[frame.index], known = PATTERN, True
        return shows

    def level(self, frame: FrameRecord) -> bool:
        """Whether the coordinates of a frame lie in one plane."""
        coords = self.checked.coordinates(frame.values, None)
        plane = lay_into_plane(coords, np.arange(len(coords)), None, rounding(coords))
        return plane.off <= max(SAME_PLACE * float(np.ptp(coords, axis=0).max()), 2.0 * rounding(coords))

    def folded_flat(self, frame: FrameRecord) -> bool:
        """Whether the faces of a frame in a plane lie upon each other: some of them upside down, all running alike."""
        coords = self.checked.coordinates(frame.values, None)
        faces = self.checked.faces(frame.values, len(coords))
        if faces is None:
            return False
        plane = lay_into_plane(coords, np.arange(len(coords)), None, rounding(coords))
        areas = np.array([area(plane.points, face) for face in run_alike(faces)[0]])
        seen = areas[np.abs(areas) > SAME_PLACE * np.abs(areas).max()]
        return bool(np.any(seen > 0.0) and np.any(seen < 0.0))

    def base(self, frames: list[FrameRecord], shows: list[str], wanted: int | None) -> FrameRecord:
        """The frame of the crease pattern that the model is of."""
        patterns = [f for f in frames if shows[f.index] == PATTERN and f.has("vertices_coords")]
        if wanted is not None:
            if not 0 <= wanted < len(frames):
                self.no_frame(wanted, f"must be from 0 to {len(frames) - 1}, one of the frames")
            frame = frames[wanted]
            if shows[wanted] == OTHER or not (frame.has("vertices_coords") or frame.turns):
                self.no_frame(wanted, "has no crease pattern and no state of one")
            if shows[wanted] == PATTERN:
                return frame
            alike = [f for f in patterns if _edge_set(f) == _edge_set(frame)]
            near = [f for f in alike if f.index in frame.origin.values()]
            return (near or alike or [frame])[0]
        folded = [f for f in frames if shows[f.index] == FOLDED and f.has("vertices_coords")]
        listed = [f for f in (*patterns, *folded) if f.has("edges_vertices") or f.has("faces_vertices")]
        return (listed or patterns or folded or frames)[0]

    def faces(self, base: FrameRecord, frames: list[FrameRecord], size: int) -> tuple[Face, ...] | None:
        """The faces of the pattern's frame, or of the first one with the same edges that lists them."""
        for frame in (base, *frames):
            if not frame.has("faces_vertices") or (frame is not base and _edge_set(frame) != _edge_set(base)):
                continue
            faces = self.checked.faces(frame.values, size)
            if faces is not None:
                self.bound(len(faces), self.limits.faces, "faces")
                most = None if self.limits.edges is None else 2 * self.limits.edges
                self.bound(sum(map(len, faces)), most, "sides of faces")
                return faces
        return None

    # states

    def states(
        self, frames: list[FrameRecord], shows: list[str], base: FrameRecord, size: int, edges: Indices, flat: bool
    ) -> list[FoldState]:
        """The states of the pattern; remarks on other frames, and reasons for states that cannot be read, are noted."""
        found = []
        sheets = {f.origin.get("vertices_coords") for f in frames if shows[f.index] == PATTERN}
        for frame in frames:
            show = shows[frame.index]
            if show == OTHER:
                self.remarks.append(f"{frame.name} shows a {' and a '.join(frame.classes)}, which is not looked at")
                continue
            if (flat and frame is base) or show == PASSED:
                continue
            if not (frame.has("vertices_coords") or frame.turns):
                if frame.shows == FOLDED:
                    self.unread.append(f"{frame.name} is a folded form without coordinates and fold angles")
                continue
            moved = self.placed(frame, sheets)
            if show == PATTERN and not (frame.turns and not moved):
                if moved and not self.is_sheet(frame, base):
                    self.remarks.append(f"{frame.name} shows another crease pattern, which is not looked at")
                continue
            order = self.order(frame, base, edges, size)
            if order is None:
                self.unread.append(f"{frame.name} shows another graph than the crease pattern in frame {base.index}")
            elif show == FOLDED and not moved and not frame.turns:
                self.unread.append(f"{frame.name} is a folded form without coordinates and fold angles of its own")
            else:
                found.append(self.state(frame, show, moved, order, size))
        return found

    def placed(self, frame: FrameRecord, sheets: set[int | None]) -> bool:
        """Whether a frame has coordinates that are not those of a crease pattern, which the frames ``sheets`` set."""
        origin = frame.origin.get("vertices_coords")
        if not frame.has("vertices_coords") or origin == frame.index:
            return frame.has("vertices_coords")
        return origin not in sheets and not frame.turns

    def is_sheet(self, frame: FrameRecord, base: FrameRecord) -> bool:
        """Whether a frame shows the same flat sheet as the pattern's."""
        return all(frame.values.get(key) == base.values.get(key) for key in ("vertices_coords", "edges_vertices"))

    def order(self, frame: FrameRecord, base: FrameRecord, edges: Indices, size: int) -> Indices | None:
        """(E,) which of the frame's edges is each of the pattern's; None where they are not the same."""
        if frame.values.get("edges_vertices") == base.values.get("edges_vertices"):
            return np.arange(len(edges))
        count = len(self.checked.coordinates(frame.values, None)) if frame.has("vertices_coords") else size
        if count != size or not (frame.has("edges_vertices") or frame.has("faces_vertices")):
            return None
        listed = self.checked.edges(frame.values, size)
        own = {(min(edge), max(edge)): e for e, edge in enumerate(listed)}
        found = [own.get((min(edge), max(edge)), -1) for edge in edges.tolist()]
        if not len(own) == len(listed) == len(edges) or -1 in found:
            return None
        self.remarks.append(f"{frame.name} lists its edges in another order")
        return np.array(found, dtype=np.int64)

    def state(self, frame: FrameRecord, show: str, moved: bool, order: Indices, size: int) -> FoldState:
        """A state with what it says of itself."""
        coords = None
        if moved:
            coords = self.checked.coordinates(frame.values, size)
            coords = np.column_stack([coords, np.zeros(size)]) if coords.shape[1] == 2 else coords
        named = frame.has("edges_vertices")
        if not named and (frame.turned_in is not None or frame.has("edges_assignment")):
            self.remarks.append(f"{frame.name} has assignments or fold angles but not the edges that they are of")
        own = frame.turns or (moved and frame.turned_in == frame.origin["vertices_coords"])
        degrees = self.checked.angles(frame.values, len(order)) if own and named else None
        letters = (self.checked.letters(frame.values, len(order)) if named else None) or ("U",) * len(order)
        driving = frame.values.get(ANGLE)
        if driving is not None and frame.origin[ANGLE] != (
            frame.origin["vertices_coords"] if moved else frame.turned_in
        ):
            driving = None if not frame.owns(ANGLE) else driving
        return FoldState(
            frame.index,
            None if driving is None else math.radians(self.checked.number(driving, ANGLE, 360.0)),
            coords,
            None if degrees is None else np.radians(degrees)[order],
            tuple(letters[e] for e in order),
        )

    # the flat sheet

    def laid(self, model: FoldModel, coords: Array) -> FoldModel:
        """The model with its pattern in the plane, its faces counter-clockwise and its auxiliary lines known."""
        used = np.unique(model.edges)
        plane = lay_into_plane(coords, used, model.faces, model.precision.flat)
        size = float(np.ptp(coords[used], axis=0).max(initial=0.0))
        if plane.off > max(_LEVEL * size, 3.0 * model.precision.flat):
            fault = (
                f"frame {model.index} is called a crease pattern but does not lie in a plane, it is {plane.off:.2g} off"
            )
            return replace(self.turned(model), fault=fault)
        model = self.without_lines(replace(model, flat=plane.points))
        if not plane.sure and _agreement(model) < 0:
            model = replace(model, flat=plane.turned_over().points)
        if model.faces is not None and model.flat is not None:
            flat = model.flat
            faces = tuple(face[::-1] if area(flat, face) < 0.0 else face for face in model.faces)
            clockwise = sum(face is not known for face, known in zip(faces, model.faces, strict=True))
            if clockwise:
                self.remarks.append(f"{clockwise} of {len(faces)} faces are listed clockwise: turned, letters kept")
            model = replace(model, faces=faces)
        return model

    def turned(self, model: FoldModel) -> FoldModel:
        """A model without a flat sheet, its faces running around alike."""
        if model.faces is None:
            return model
        model = self.without_lines(model)
        faces, any_turned = run_alike(model.faces or ())
        model = replace(model, faces=faces)
        if any_turned:
            self.remarks.append("faces run around in both directions: turned to run alike, letters kept")
            if _agreement(model) < 0:
                model = replace(model, faces=tuple(face[::-1] for face in faces))
        return model

    def without_lines(self, model: FoldModel) -> FoldModel:
        """The model with its auxiliary lines marked and walks along them taken out of its faces."""
        letters = model.letters or ("U",) * len(model.edges)
        angles = [model.angles, *(state.angles for state in model.states)]
        folds = np.zeros(len(model.edges), dtype=np.bool_)
        for some in angles:
            folds |= False if some is None else np.nan_to_num(some) != 0.0
        still = np.array([letter in "FUJ" for letter in letters], dtype=np.bool_) & ~folds
        faces = None if model.faces is None else without_spurs(model.faces, model.edges, still)
        model = replace(model, faces=faces)
        if model.flat is None and faces is None:
            return model
        points = np.zeros((0, 2)) if model.flat is None else model.flat
        border = np.array([letter == "B" for letter in letters], dtype=np.bool_)
        size = float(np.ptp(points, axis=0).max(initial=0.0)) if len(points) else 0.0
        loose = auxiliary_lines(points, model.edges, still, border, faces, SAME_PLACE * size)
        if loose.all():
            return model
        if loose.any():
            count = int(loose.sum())
            first = int(np.argmax(loose))
            words = (
                f"edge {first} is an auxiliary line"
                if count == 1
                else f"{count} edges are auxiliary lines, edge {first} first,"
            )
            self.remarks.append(f"{words} and no part of the sheet")
        return replace(model, loose=loose)


def _edge_set(frame: FrameRecord) -> object:
    """The edges of a frame, whatever their order; its faces' sides where it lists none."""
    listed = frame.values.get("edges_vertices")
    if not isinstance(listed, list):
        listed = frame.values.get("faces_vertices")
    if not isinstance(listed, list):
        return None
    return frozenset(
        frozenset(x for x in edge if isinstance(x, int)) if isinstance(edge, list) else None for edge in listed
    )


def _agreement(model: FoldModel) -> int:
    """How many creases fold the way that letters or angles say in the states of the file, minus those that do not.

    Where there are no panels or no folded vertices nothing is known: 0.
    """
    faces = panels_of(model)
    total = 0.0
    for state in model.states:
        if state.coords is not None:
            said = np.array([{"V": 1.0, "M": -1.0}.get(letter, 0.0) for letter in state.letters])
            stated = said if state.angles is None else np.sign(np.nan_to_num(state.angles))
            folds = measured_angles(model.edges, faces, state.coords, ("U",) * len(model.edges))
            total += float(np.sum(np.where(said != 0.0, said, stated) * np.sign(folds)))
    return int(total)
