"""The folded sheet, lit from the upper left, in its translucent target."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from origami_lab.drawing.camera import Camera, frame_points
from origami_lab.drawing.painting import (
    OVERSAMPLE,
    Inks,
    Pixels,
    Surroundings,
    Veils,
    blur,
    mark_borders,
    no_veils,
    paint,
)
from origami_lab.drawing.scene import BACK, FRONT, INK, PAGE, PALE_TARGET, TARGET, TargetSurface
from origami_lab.drawing.z_buffer import NOTHING, fill_z_buffer
from origami_lab.files import replacing
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.panel_triangles import triangulate

Places = tuple[NDArray[np.intp], NDArray[np.intp]]

_LIGHT = np.array([-0.45, 0.62, 0.64])  # right, up, towards the viewer
_HOLLOW, _DARKEST = 0.05, 0.36  # how far hollows darken, as a share of the picture, and how much at most
_VEIL, _BARE = 0.20, 0.34  # opacity of the target in front of the paper, and elsewhere
_COMPRESSED = 4  # PNG's level: its 6 takes half as long again for a twentieth of the bytes
_STEP = 0.012  # of the picture: a step in depth that shows one panel before another


@dataclass(frozen=True, eq=False)
class DrawnSheet:
    """The panels of a file as triangles."""

    triangles: NDArray[np.int64]
    """(T, 3)"""
    panels: NDArray[np.int64]
    """(T,) the panel of each triangle."""


def sheet_of(fold: FoldFile) -> DrawnSheet:
    """Cut the panels of a file into triangles."""
    return DrawnSheet(*triangulate(fold.vertices, fold.panels))


class Studio:
    """A fixed camera, light and target, in which any number of folded forms are pictured."""

    def __init__(
        self,
        points: NDArray[np.float64],
        target: TargetSurface | None,
        size: int,
        *,
        trim: bool = False,
        upright: NDArray[np.float64] | None = None,
    ) -> None:
        """Point the camera at (N, 3) ``points`` and the target, turned by ``upright`` (3, 3) as the sheet is used.

        The pictures are ``size`` pixels square (``trim``: as high as they need to be), with room for the
        caption at the bottom.
        """
        self.fine = size * OVERSAMPLE
        everything = points if target is None else np.vstack([points, target.vertices])
        margin, caption = 0.05 * self.fine, 0.075 * self.fine
        side = self.fine - margin
        self.camera: Camera = frame_points(everything, (margin, margin, side, side - caption), upright=upright)
        rows = self.fine
        if trim:
            seen = self.camera.project(everything)[:, 1]
            rows = min(rows, 2 * int((np.ptp(seen) + 2 * margin + caption) / 2))
            self.camera = frame_points(everything, (margin, margin, side, rows - margin - caption), upright=upright)
        self.shape = (rows, self.fine)
        self.veils = no_veils(self.shape) if target is None else self._veils_of(target)
        dark = (0.55 * TARGET[0], 0.55 * TARGET[1], 0.55 * TARGET[2])
        depths = {"veil_depth": 0.002 * self.fine, "rim_depth": 0.004 * self.fine}
        lines = {"meet": 0.55, "end": 0.9, "seen": 0.75, "hidden": 0.4}
        self.inks = Inks(INK, dark, PAGE, bare=_BARE, veil=_VEIL, **lines, **depths)
        self._blank: NDArray[np.uint8] | None = None
        # kept: the system takes longer to make room for new ones than the panels take to be filled in
        self._buffers = np.empty(self.shape, np.float32), np.empty(self.shape, np.int32)
        self._marks = np.empty(self.shape, np.uint8)

    def expect_many(self) -> None:
        """Paint what is seen without a sheet once, for all pictures to come; they are the same with and without it."""
        empty = fill_z_buffer(np.zeros((0, 3, 3)), np.zeros(0, np.int32), self.shape, self._buffers)
        self._blank = self._painted(*empty, np.zeros((0, 3), np.float32))

    def picture(self, sheet: DrawnSheet, coords: NDArray[np.float64]) -> Image.Image:
        """The panels at (V, 3) folded ``coords``."""
        corners = self.camera.project(coords[sheet.triangles])
        near, owner = fill_z_buffer(corners, sheet.panels.astype(np.int32), self.shape, self._buffers)
        colours = self._panel_colours(sheet, coords[sheet.triangles], corners)
        return Image.fromarray(self._painted(near, owner, colours))

    def _painted(self, near: Pixels, owner: NDArray[np.int32], colours: Pixels) -> NDArray[np.uint8]:
        """The picture of the panels in a z-buffer, which have these colours."""
        self._marks[...] = 0
        mark_borders(owner, near, _STEP * self.fine, max(1, round(self.fine / 1000)), self._marks)
        layers = (near, owner, colours, _surroundings(near, owner), self._marks)
        return paint(*layers, self.veils, self.inks, self._blank)

    def _panel_colours(
        self, sheet: DrawnSheet, spatial: NDArray[np.float64], corners: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """(F, 3) the colour of each panel: which side is seen, and how the light falls on it."""
        count = int(sheet.panels.max()) + 1 if len(sheet.panels) else 0
        normals = np.zeros((count, 3))
        np.add.at(normals, sheet.panels, np.cross(spatial[:, 1] - spatial[:, 0], spatial[:, 2] - spatial[:, 0]))
        facing = self.camera.facing(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))
        front = facing[:, 2] >= 0.0
        base = np.where(front[:, None], np.array(FRONT), np.array(BACK))
        return _lit(base, np.where(front[:, None], facing, -facing))

    def _veils_of(self, target: TargetSurface) -> Veils:
        """The nearest and the farthest surface of the target at each pixel, with their colours."""
        spatial = target.vertices[target.faces]
        corners = self.camera.project(spatial)
        normals = np.cross(spatial[:, 1] - spatial[:, 0], spatial[:, 2] - spatial[:, 0])
        facing = self.camera.facing(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))
        facing = np.where(facing[:, 2:] >= 0.0, facing, -facing)
        shades = _lit(np.array(TARGET)[None, :], facing)
        index = np.arange(len(corners), dtype=np.int32)
        veils = np.empty((2, *self.shape), np.float32), np.empty((2, *self.shape), np.int32)
        (near, far), (seen, last) = veils
        fill_z_buffer(corners, index, self.shape, (near, seen))
        fill_z_buffer(corners * np.array([1.0, 1.0, -1.0]), index, self.shape, (far, last))
        np.negative(far, out=far, where=last != NOTHING)
        return Veils(*veils, shades, _outline(near, seen, facing, 0.02 * self.fine))


def _surroundings(near: Pixels, owner: NDArray[np.int32]) -> Surroundings:
    """What is about each place of the paper; on every fourth pixel, as it is smooth."""
    every = 2 * OVERSAMPLE
    around, seen = near[::every, ::every], owner[::every, ::every] != NOTHING
    lowest = float(around[seen].min()) if seen.any() else 0.0
    around = np.where(seen, around, np.float32(lowest))
    reach = max(3, int(_HOLLOW * around.shape[1] / 2) | 1)
    blur(around, reach)
    return Surroundings(around, lowest, scale=1.6 * 2 * reach, darkest=_DARKEST)


def _lit(base: NDArray[np.float64], facing: NDArray[np.float64]) -> NDArray[np.float32]:
    """Colours (N, 3) of surfaces with unit normals (N, 3) towards the viewer."""
    light = _LIGHT / np.linalg.norm(_LIGHT)
    strength = 0.69 + 0.37 * np.clip(facing @ light, 0.0, 1.0) + 0.05 * facing[:, 1]
    colours: NDArray[np.float32] = np.clip(base * strength[:, None], 0, 255).astype(np.float32)
    return colours


def _borders(owner: NDArray[np.int32], near: Pixels, axis: int) -> tuple[Places, Pixels]:
    """The pixels whose next one along ``axis`` shows something else, and the step in depth to it."""
    here, there = (owner[:-1], owner[1:]) if axis == 0 else (owner[:, :-1], owner[:, 1:])
    rows, columns = np.nonzero(here != there)
    step: Pixels = np.abs(near[rows + (axis == 0), columns + (axis == 1)] - near[rows, columns])
    return (rows, columns), step  # infinite beside the page


def _mark(mask: NDArray[np.bool_], at: Places, axis: int, width: int) -> None:
    """Mark ``width`` pixels on both sides of each border; ``at`` are the pixels before them."""
    for shift in range(1 - width, width + 1):
        places = [at[0], at[1]]
        places[axis] = np.clip(places[axis] + shift, 0, mask.shape[axis] - 1)
        mask[places[0], places[1]] = True


def _outline(near: Pixels, owner: NDArray[np.int32], facing: NDArray[np.float64], jump: float) -> NDArray[np.bool_]:
    """Where the nearest surface of the target ends, jumps in depth or turns sharply."""
    mask = np.zeros(owner.shape, bool)
    for axis in (0, 1):
        at, step = _borders(owner, near, axis)
        after = (at[0] + (axis == 0), at[1] + (axis == 1))
        turn = np.einsum("ij,ij->i", facing[owner[at]], facing[owner[after]])  # beside the page the step decides
        sharp = (step > jump) | (turn < 0.8)
        _mark(mask, (at[0][sharp], at[1][sharp]), axis, 1)
    return mask


@lru_cache(maxsize=8)
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """matplotlib's bundled DejaVu Sans."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def caption_lines(fold: FoldFile, frame: FoldFrame) -> tuple[str, str]:
    """A heading and the facts of one folded form."""
    known = fold.metadata
    facts = []
    value = known.get("return")
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9:
        facts.append(f"return {value:z.4f}".replace("-", "−"))
    if frame.driving_angle is not None:
        facts.append(f"driving angle {np.degrees(frame.driving_angle):.1f}°")
    facts.append(f"{len(fold.panels)} panels")
    return fold.title or "rigid origami", "   ".join(facts)


def write_caption(image: Image.Image, heading: str, facts: str, target: bool) -> None:
    """Heading and facts at the bottom left, the key to the colours at the bottom right."""
    draw = ImageDraw.Draw(image)
    size = image.width
    large, small = font(round(size / 38), True), font(round(size / 52))
    left, base = round(size * 0.03), image.height - round(size * 0.03)
    draw.text((left, base - round(size / 34)), heading, INK, large, anchor="ls")
    draw.text((left, base), facts, (90, 94, 108), small, anchor="ls")
    right = size - left
    swatch = round(size / 70)
    entries = [("back", BACK), ("front", FRONT)]
    if target:
        entries.insert(0, ("target", PALE_TARGET))
    for label, colour in entries:
        draw.text((right, base), label, (90, 94, 108), small, anchor="rs")
        right -= round(draw.textlength(label, small)) + swatch + round(size / 140)
        draw.rectangle((right, base - swatch + 1, right + swatch - 1, base), colour, (120, 124, 136))
        right -= round(size / 45)


def draw_folded(
    fold: FoldFile, path: str | os.PathLike[str], target: TargetSurface | None = None, *, size: int = 900
) -> None:
    """A PNG, ``size`` pixels square, of the panels at the best driving angle over the translucent target."""
    frame = fold.best
    studio = Studio(frame.coords, target, size, upright=fold.upright)
    image = studio.picture(sheet_of(fold), frame.coords)
    write_caption(image, *caption_lines(fold, frame), target is not None)
    with replacing(path) as part:
        image.save(part, format="PNG", compress_level=_COMPRESSED)
