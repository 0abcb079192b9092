"""Pictures from z-buffers: what each pixel shows, layer over layer, in one pass.

Buffers have twice the rows and columns of the picture: each pixel is the mean of four.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origami_lab.jit import kernel

Pixels = NDArray[np.float32]

OVERSAMPLE = 2
"""Rows and columns of the buffers for one of the picture."""

MEET, END = 1, 2
"""Marks of a pixel at a border: two panels meet there, or one ends before another or the page."""


@dataclass(frozen=True, eq=False)
class Veils:
    """Translucent surfaces of a target, pixel by pixel, from the nearest to the farthest.

    Attributes
    ----------
    near
        (L, H, W) nearness.
    owner
        (L, H, W) the triangle that is seen.
    shades
        (T, 3) the colour of each triangle.
    rim
        (H, W) where the target's outline is.
    """

    near: Pixels
    owner: NDArray[np.int32]
    shades: Pixels
    rim: NDArray[np.bool_]


def no_veils(shape: tuple[int, int]) -> Veils:
    """Those of a picture without a target."""
    none = (0, *shape)
    return Veils(
        np.zeros(none, np.float32), np.zeros(none, np.int32), np.zeros((0, 3), np.float32), np.zeros(shape, bool)
    )


@dataclass(frozen=True)
class Inks:
    """Colours, opacities and depths, in pixels of the buffers, of what lies over the panels.

    Attributes
    ----------
    crease, rim
        (3,) the colour of the lines.
    meet, end
        Opacity of a line where two panels meet, and where one ends.
    veil, veil_depth
        Opacity of a target before the paper, and how far before it that begins.
    seen, hidden, rim_depth
        Opacity of a target's rim, that behind the paper, and how far behind it that begins.
    """

    crease: tuple[float, float, float]
    rim: tuple[float, float, float]
    meet: float
    end: float
    veil: float
    veil_depth: float
    seen: float
    hidden: float
    rim_depth: float


@dataclass(frozen=True, eq=False)
class Surroundings:
    """How near what is about each place is, so that hollows can be darkened: cheap ambient occlusion.

    Attributes
    ----------
    near
        (H/4, W/4) mean nearness about every fourth pixel.
    lowest
        The nearness that counts beside the paper.
    scale, darkest
        A place that lies this far behind its surroundings loses 1 − 1/e of this part of its light.
    """

    near: Pixels
    lowest: float
    scale: float
    darkest: float


@kernel
def mark_borders(owner: NDArray[np.int32], near: Pixels, jump: float, width: int, marks: NDArray[np.uint8]) -> None:
    """Mark (H, W) the pixels beside each border between two owners.

    Where the depth steps by more than ``jump`` the panel ends and ``width`` pixels on both sides are marked END;
    elsewhere the two panels meet and one pixel on each side is marked MEET. END wins.
    """
    rows, columns = owner.shape
    for row in range(rows):
        for column in range(columns):
            for axis in range(2):
                below, right = row + (axis == 0), column + (axis == 1)
                if below == rows or right == columns or owner[below, right] == owner[row, column]:
                    continue
                ends = abs(near[below, right] - near[row, column]) > jump  # infinite beside the page
                reach = width if ends else 1
                for shift in range(1 - reach, reach + 1):
                    r = min(max(row + shift, 0), rows - 1) if axis == 0 else row
                    c = min(max(column + shift, 0), columns - 1) if axis == 1 else column
                    marks[r, c] = max(marks[r, c], END if ends else MEET)


def paint(
    backdrop: Pixels,
    near: Pixels,
    owner: NDArray[np.int32],
    colours: Pixels,
    surroundings: Surroundings,
    marks: NDArray[np.uint8],
    veils: Veils,
    inks: Inks,
    blank: NDArray[np.uint8] | None = None,
) -> NDArray[np.uint8]:
    """The picture (H/2, W/2, 3) of panels over a backdrop, in a target.

    Parameters
    ----------
    backdrop
        (H, W, 3) what is seen where no panel is, 0 to 255.
    near, owner
        (H, W) the z-buffer of the panels (:func:`~origami_lab.drawing.z_buffer.fill_z_buffer`).
    colours
        (N, 3) the colour of each panel.
    surroundings
        What darkens the hollows.
    marks
        (H, W) as of :func:`mark_borders`.
    blank
        (H/2, W/2, 3) the picture of no panels in the same target: pixels that show none are taken from it.
    """
    rows, columns = owner.shape
    if blank is None:
        picture = np.empty((rows // OVERSAMPLE, columns // OVERSAMPLE, 3), dtype=np.uint8)
    else:
        picture = blank.copy()
    hollows = (surroundings.lowest, surroundings.scale, surroundings.darkest)
    numbers = (*hollows, inks.meet, inks.end, inks.veil, inks.veil_depth, inks.seen, inks.hidden, inks.rim_depth)
    _paint(
        *(picture, backdrop, near, owner, colours, surroundings.near, marks),
        *(veils.near, veils.owner, veils.shades, veils.rim, blank is None),
        *(np.array([inks.crease, inks.rim], dtype=np.float32), np.array(numbers, dtype=np.float32)),
    )
    return picture


@kernel
def _paint(
    picture: NDArray[np.uint8],
    backdrop: Pixels,
    near: Pixels,
    owner: NDArray[np.int32],
    colours: Pixels,
    around: Pixels,
    marks: NDArray[np.uint8],
    veil_near: Pixels,
    veil_owner: NDArray[np.int32],
    shades: Pixels,
    rim: NDArray[np.bool_],
    whole: bool,
    lines: Pixels,
    numbers: Pixels,
) -> None:
    """Pixel by pixel of the picture, and of the buffers within; not ``whole``: those that show a panel or a mark."""
    lowest, scale, darkest, meet, end, veil, veil_depth, seen, hidden, rim_depth = numbers
    colour, total = np.empty(3, dtype=np.float32), np.empty(3, dtype=np.float32)
    full = np.float32(1.0)
    for y in range(picture.shape[0]):
        for x in range(picture.shape[1]):
            here = lowest  # beside the paper nearness is −inf
            shows = whole
            for row in range(OVERSAMPLE * y, OVERSAMPLE * y + OVERSAMPLE):
                for column in range(OVERSAMPLE * x, OVERSAMPLE * x + OVERSAMPLE):
                    here = max(here, near[row, column])
                    shows |= owner[row, column] >= 0 or marks[row, column] > 0
            if not shows:
                continue
            behind = around[y // 2, x // 2] - here
            light = full - darkest * (full - np.exp(-behind / scale)) if behind > np.float32(0.0) else full
            total[:] = 0.0
            for row in range(OVERSAMPLE * y, OVERSAMPLE * y + OVERSAMPLE):
                for column in range(OVERSAMPLE * x, OVERSAMPLE * x + OVERSAMPLE):
                    depth = near[row, column]
                    panel = owner[row, column]
                    for i in range(3):
                        if panel < 0:
                            colour[i] = backdrop[row, column, i]
                        else:
                            colour[i] = colours[panel, i] * light
                    if marks[row, column] > 0:
                        opacity = end if marks[row, column] == END else meet
                        for i in range(3):
                            colour[i] += opacity * (lines[0, i] - colour[i])
                    if panel >= 0:
                        for layer in range(veil_near.shape[0] - 1, -1, -1):
                            if veil_near[layer, row, column] > depth + veil_depth:
                                triangle = veil_owner[layer, row, column]
                                for i in range(3):
                                    colour[i] += veil * (shades[triangle, i] - colour[i])
                    if rim[row, column]:
                        opacity = hidden if depth > veil_near[0, row, column] + rim_depth else seen
                        for i in range(3):
                            colour[i] += opacity * (lines[1, i] - colour[i])
                    for i in range(3):
                        total[i] += min(max(colour[i], np.float32(0.0)), np.float32(255.0))
            for i in range(3):
                picture[y, x, i] = np.uint8(total[i] / np.float32(OVERSAMPLE * OVERSAMPLE) + np.float32(0.5))
