"""Pictures from buffers, against the same thing said layer by layer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from origami_lab.drawing.painting import END, MEET, Inks, Surroundings, Veils, blur, mark_borders, no_veils, paint

ROWS, COLUMNS = 8, 12
LINES = {"meet": 0.5, "end": 0.9, "seen": 0.75, "hidden": 0.4}
INKS = Inks((10, 20, 30), (90, 60, 40), (250, 240, 230), bare=0.3, veil=0.2, veil_depth=0.3, rim_depth=0.5, **LINES)
FLAT = Surroundings(np.full((ROWS // 4, COLUMNS // 4), -100.0, dtype=np.float32), -100.0, 5.0, 0.36)
"""Nothing lies behind it, so nothing is darkened."""


def lay(image: NDArray[np.float64], where: NDArray[np.bool_], opacity: float, colours: NDArray[np.float64]) -> None:
    image[where] += opacity * (colours[where] if colours.ndim == 3 else colours) - opacity * image[where]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.booleans())
def test_layers(seed: int, in_target: bool) -> None:
    rng = np.random.default_rng(seed)
    owner = rng.integers(-1, 4, (ROWS, COLUMNS)).astype(np.int32)
    owner[:, : COLUMNS // 2] = -1
    near = np.where(owner >= 0, rng.uniform(-2, 2, owner.shape), -np.inf).astype(np.float32)
    colours = rng.uniform(0, 255, (4, 3)).astype(np.float32)
    marks = rng.integers(0, 3, owner.shape).astype(np.uint8)
    marks[: ROWS // 2] = 0
    veils = no_veils(owner.shape)
    if in_target:
        layers = rng.integers(-1, 3, (2, *owner.shape)).astype(np.int32)
        depths = np.where(layers >= 0, rng.uniform(-2, 2, layers.shape), -np.inf).astype(np.float32)
        shades = rng.uniform(0, 255, (3, 3)).astype(np.float32)
        veils = Veils(depths, layers, shades, rng.random(owner.shape) < 0.3)
    found = paint(near, owner, colours, FLAT, marks, veils, INKS)
    nothing = np.full_like(near, -np.inf), np.full_like(owner, -1), colours, FLAT, np.zeros_like(marks)
    blank = paint(*nothing, veils, INKS)
    assert (found == paint(near, owner, colours, FLAT, marks, veils, INKS, blank)).all()

    image = np.full((*owner.shape, 3), INKS.page, dtype=float)
    for k in reversed(range(len(veils.near))):
        lay(image, veils.owner[k] >= 0, INKS.bare, veils.shades[veils.owner[k]].astype(float))
    image[owner >= 0] = colours[owner[owner >= 0]]
    lay(image, marks == MEET, INKS.meet, np.array(INKS.crease, dtype=float))
    lay(image, marks == END, INKS.end, np.array(INKS.crease, dtype=float))
    for k in reversed(range(len(veils.near))):
        before = (owner >= 0) & (veils.near[k] > near + INKS.veil_depth)
        lay(image, before, INKS.veil, veils.shades[veils.owner[k]].astype(float))
    if in_target:
        behind = near > veils.near[0] + INKS.rim_depth
        lay(image, veils.rim & behind, INKS.hidden, np.array(INKS.rim, dtype=float))
        lay(image, veils.rim & ~behind, INKS.seen, np.array(INKS.rim, dtype=float))
    mean = image.reshape(ROWS // 2, 2, COLUMNS // 2, 2, 3).mean(axis=(1, 3))
    assert found.shape == mean.shape
    assert np.abs(found - mean).max() <= 0.5 + 1e-3


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_borders(seed: int, width: int) -> None:
    rng = np.random.default_rng(seed)
    owner = rng.integers(-1, 2, (ROWS, COLUMNS)).astype(np.int32)
    near = np.where(owner >= 0, rng.integers(0, 3, owner.shape), -np.inf).astype(np.float32)
    marks = np.zeros(owner.shape, dtype=np.uint8)
    mark_borders(owner, near, 1.5, width, marks)
    truth = np.zeros(owner.shape, dtype=np.uint8)
    for row, column in np.ndindex(ROWS, COLUMNS):
        for down, right in ((1, 0), (0, 1)):
            r, c = row + down, column + right
            if r == ROWS or c == COLUMNS or owner[r, c] == owner[row, column]:
                continue
            ends = abs(near[r, c] - near[row, column]) > 1.5
            for k in range(width if ends else 1):
                for y, x in ((row - k * down, column - k * right), (r + k * down, c + k * right)):
                    y, x = min(max(y, 0), ROWS - 1), min(max(x, 0), COLUMNS - 1)
                    truth[y, x] = max(truth[y, x], END if ends else MEET)
    assert np.array_equal(marks, truth)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 4), st.integers(1, 9), st.integers(1, 14))
def test_blur_is_three_boxes_each_way(seed: int, half: int, rows: int, columns: int) -> None:
    field = np.random.default_rng(seed).uniform(-50, 50, (rows, columns)).astype(np.float32)
    expected = field
    for axis in (0, 0, 0, 1, 1, 1):
        expected = uniform_filter1d(expected, 2 * half + 1, axis=axis, mode="reflect")
    blur(field, 2 * half + 1)
    assert np.abs(field - expected).max() < 1e-4


@pytest.mark.parametrize("depth", [0.0, 5.0, 50.0])
def test_hollows_are_darkened(depth: float) -> None:
    """Paper that lies ``depth`` behind its surroundings loses light as the docstring says."""
    near, owner = np.full((4, 4), -depth, dtype=np.float32), np.zeros((4, 4), dtype=np.int32)
    colours = np.full((1, 3), 200.0, dtype=np.float32)
    about = Surroundings(np.zeros((1, 1), dtype=np.float32), -100.0, 5.0, 0.36)
    marks = np.zeros((4, 4), dtype=np.uint8)
    found = paint(near, owner, colours, about, marks, no_veils((4, 4)), INKS)
    assert np.abs(found - 200.0 * (1 - 0.36 * (1 - np.exp(-depth / 5.0)))).max() <= 0.51
