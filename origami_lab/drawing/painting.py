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
    page, bare
        (3,) the colour of the page, and the opacity of each surface of a target where no paper is.
    veil, veil_depth
        Opacity of a target before the paper, and how far before it that begins.
    seen, hidden, rim_depth
        Opacity of a target's rim, that behind the paper, and how far behind it that begins.
    """

    crease: tuple[float, float, float]
    rim: tuple[float, float, float]
    page: tuple[float, float, float]
    bare: float
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
            here = owner[row, column]
            if row + 1 < rows and owner[row + 1, column] != here:
                ends = abs(near[row + 1, column] - near[row, column]) > jump  # infinite beside the page
                reach = width if ends else 1
                for shift in range(1 - reach, reach + 1):
                    r = min(max(row + shift, 0), rows - 1)
                    marks[r, column] = max(marks[r, column], END if ends else MEET)
            if column + 1 < columns and owner[row, column + 1] != here:
                ends = abs(near[row, column + 1] - near[row, column]) > jump
                reach = width if ends else 1
                for shift in range(1 - reach, reach + 1):
                    c = min(max(column + shift, 0), columns - 1)
                    marks[row, c] = max(marks[row, c], END if ends else MEET)


@kernel
def blur(field: Pixels, reach: int) -> None:
    """Blur (H, W), in place: three times the mean of ``reach`` (odd) about each place, along rows and columns.

    That is nearly a Gaussian. Beyond its ends the field is mirrored.
    """
    half = reach // 2
    for axis in range(2):
        lines = field if axis == 0 else field.T
        count = lines.shape[1]
        wide = np.empty(count + reach, dtype=np.float64)  # from half + 1 places before the line to half after it
        for line in range(lines.shape[0]):
            for _ in range(3):
                for at in range(count + reach):
                    place = (at - half - 1) % (2 * count)
                    wide[at] = lines[line, min(place, 2 * count - 1 - place)]
                total = wide[:reach].sum()
                for at in range(count):
                    total += wide[at + reach] - wide[at]
                    lines[line, at] = total / reach


def paint(
    near: Pixels,
    owner: NDArray[np.int32],
    colours: Pixels,
    surroundings: Surroundings,
    marks: NDArray[np.uint8],
    veils: Veils,
    inks: Inks,
    blank: NDArray[np.uint8] | None = None,
) -> NDArray[np.uint8]:
    """The picture (H/2, W/2, 3) of panels in a target, on a page.

    Parameters
    ----------
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
    depths = (inks.veil, inks.veil_depth, inks.seen, inks.hidden, inks.rim_depth)
    numbers = (*hollows, inks.bare, inks.meet, inks.end, *depths)
    _paint(
        *(picture, near, owner, colours, surroundings.near, marks),
        *(veils.near, veils.owner, veils.shades, veils.rim, blank is None),
        *(np.array([inks.crease, inks.rim, inks.page], dtype=np.float32), np.array(numbers, dtype=np.float32)),
    )
    return picture


@kernel
def _paint(
    picture: NDArray[np.uint8],
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
    inks: Pixels,
    numbers: Pixels,
) -> None:
    """Pixel by pixel of the picture, and of the buffers within; not ``whole``: those that show a panel or a mark.

    Colours are three numbers each, not arrays: so they stay in registers.
    """
    lowest, scale, darkest, bare, meet, end, veil, veil_depth, seen, hidden, rim_depth = numbers
    (crease_r, crease_g, crease_b), (rim_r, rim_g, rim_b), (page_r, page_g, page_b) = inks
    none, full, most = np.float32(0.0), np.float32(1.0), np.float32(255.0)
    layers = veil_near.shape[0]
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
            light = full - darkest * (full - np.exp(-behind / scale)) if behind > none else full
            total_r, total_g, total_b = none, none, none
            for row in range(OVERSAMPLE * y, OVERSAMPLE * y + OVERSAMPLE):
                for column in range(OVERSAMPLE * x, OVERSAMPLE * x + OVERSAMPLE):
                    depth = near[row, column]
                    panel = owner[row, column]
                    r, g, b = page_r, page_g, page_b
                    if panel >= 0:
                        r, g, b = colours[panel, 0] * light, colours[panel, 1] * light, colours[panel, 2] * light
                    else:
                        for layer in range(layers - 1, -1, -1):
                            triangle = veil_owner[layer, row, column]
                            if triangle >= 0:
                                r += bare * (shades[triangle, 0] - r)
                                g += bare * (shades[triangle, 1] - g)
                                b += bare * (shades[triangle, 2] - b)
                    if marks[row, column] > 0:
                        opacity = end if marks[row, column] == END else meet
                        r += opacity * (crease_r - r)
                        g += opacity * (crease_g - g)
                        b += opacity * (crease_b - b)
                    if panel >= 0:
                        for layer in range(layers - 1, -1, -1):
                            if veil_near[layer, row, column] > depth + veil_depth:
                                triangle = veil_owner[layer, row, column]
                                r += veil * (shades[triangle, 0] - r)
                                g += veil * (shades[triangle, 1] - g)
                                b += veil * (shades[triangle, 2] - b)
                    if rim[row, column]:
                        opacity = hidden if depth > veil_near[0, row, column] + rim_depth else seen
                        r += opacity * (rim_r - r)
                        g += opacity * (rim_g - g)
                        b += opacity * (rim_b - b)
                    total_r += min(max(r, none), most)
                    total_g += min(max(g, none), most)
                    total_b += min(max(b, none), most)
            share, half = full / np.float32(OVERSAMPLE * OVERSAMPLE), np.float32(0.5)
            picture[y, x, 0] = np.uint8(total_r * share + half)
            picture[y, x, 1] = np.uint8(total_g * share + half)
            picture[y, x, 2] = np.uint8(total_b * share + half)
