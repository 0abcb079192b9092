"""The folding motion as a GIF: flat, up to the best driving angle, and back."""

from __future__ import annotations

import os

import numpy as np
from PIL import Image

from origami_lab.drawing.folded_picture import Studio, caption_lines, sheet_of, write_caption
from origami_lab.drawing.scene import BACK, FRONT, INK, PAGE, PALE_TARGET, TargetSurface
from origami_lab.files import replacing
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame

STEP_SHOWN, FLAT_SHOWN, BEST_SHOWN = 60, 700, 1600
"""Milliseconds that a step, the flat sheet and the best state are shown; GIF counts in tens."""


def steps(fold: FoldFile) -> tuple[FoldFrame, ...]:
    """The flat sheet and the stored folded forms up to the best one.

    Only true folded forms: interpolated coordinates would stretch the panels.
    """
    best = fold.best
    before = [frame for frame in fold.motion if frame is not best and _folded(frame) < _folded(best)]
    return (fold.flat, *before, *([best] if fold.frames else []))


def motion_pictures(fold: FoldFile, target: TargetSurface | None, size: int) -> list[Image.Image]:
    """The frames of :func:`steps` as pictures, ``size`` pixels wide; camera and scale are the same in all."""
    frames = steps(fold)
    studio = Studio(np.vstack([frame.coords for frame in frames]), target, size, trim=True, upright=fold.upright)
    studio.expect_many()
    sheet = sheet_of(fold)
    pictures = []
    for frame in frames:
        image = studio.picture(sheet, frame.coords)
        write_caption(image, *caption_lines(fold, frame), target is not None)
        pictures.append(image)
    return pictures


def draw_motion(
    fold: FoldFile, path: str | os.PathLike[str], target: TargetSurface | None = None, *, size: int = 560
) -> None:
    """An endless GIF, ``size`` pixels wide, from flat to the best driving angle and back.

    Camera, scale and palette are the same in all frames.
    """
    pictures = motion_pictures(fold, target, size)
    palette = _palette(pictures)
    indexed = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    there_and_back = indexed + indexed[-2:0:-1]
    durations = [STEP_SHOWN] * len(there_and_back)
    durations[0], durations[len(indexed) - 1] = FLAT_SHOWN, BEST_SHOWN
    with replacing(path) as part:
        there_and_back[0].save(
            part,
            format="GIF",
            save_all=True,
            append_images=there_and_back[1:],
            duration=durations,
            loop=0,
            optimize=False,
            disposal=1,
        )


def _folded(frame: FoldFrame) -> float:
    """How far the motion has gone."""
    return 0.0 if frame.driving_angle is None else abs(frame.driving_angle)


def _palette(pictures: list[Image.Image]) -> Image.Image:
    """One palette for all pictures, with the colours of the key exactly as they are; every other pixel is asked."""
    chosen = [
        picture.resize((picture.width // 2, picture.height // 2), Image.Resampling.NEAREST)
        for picture in (pictures[0], pictures[len(pictures) // 2], pictures[-1])
    ]
    strip = Image.new("RGB", (chosen[0].width * 3, chosen[0].height))
    for index, picture in enumerate(chosen):
        strip.paste(picture, (index * picture.width, 0))
    exact = [PAGE, INK, FRONT, BACK, PALE_TARGET]
    flat = strip.quantize(128, method=Image.Quantize.MEDIANCUT).getpalette() or []
    found = [tuple(flat[i : i + 3]) for i in range(0, len(flat), 3)]
    # Pillow looks colours up with an error of a few levels: near-copies would stand in for the exact ones.
    others = [c for c in found if all(max(abs(x - y) for x, y in zip(c, e, strict=True)) > 9 for e in exact)]
    palette = Image.new("P", (1, 1))
    palette.putpalette([channel for colour in (*exact, *others) for channel in colour])
    return palette
