"""Target surfaces given by a height above the board, to compare searchers on: tuned on some, reported on others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from origami_lab.targets.target import Target

Array = NDArray[np.float64]
Height = Callable[[Array, Array], Array]
Inside = Callable[[Array, Array], NDArray[np.bool_]]


def height_field(
    name: str, height: Height, half_x: float, half_y: float, step: float = 0.25, inside: Inside | None = None
) -> Target:
    """The surface z = height(x, y) over a rectangle, or the part of it where ``inside`` says so of a triangle's centre.

    Its triangles are as symmetric as the rectangle.
    """
    nx, ny = round(2 * half_x / step), round(2 * half_y / step)
    xs, ys = np.linspace(-half_x, half_x, nx + 1), np.linspace(-half_y, half_y, ny + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(xs, ys, indexing="ij"))
    faces = []
    for i in range(nx):
        for j in range(ny):
            a, b, c, d = i * (ny + 1) + j, (i + 1) * (ny + 1) + j, (i + 1) * (ny + 1) + j + 1, i * (ny + 1) + j + 1
            if (xs[i] + xs[i + 1]) * (ys[j] + ys[j + 1]) >= 0:
                faces += [(a, b, c), (a, c, d)]
            else:
                faces += [(a, b, d), (b, c, d)]
    chosen = np.array(faces)
    if inside is not None:
        chosen = chosen[inside(x[chosen].mean(axis=1), y[chosen].mean(axis=1))]
    used, chosen = np.unique(chosen, return_inverse=True)
    return Target(name, np.stack([x, y, height(x, y)], axis=1)[used], chosen.reshape(-1, 3), closed=False)


def saddle() -> Target:
    """Symmetric in x and y."""
    return height_field("saddle", lambda x, y: 0.09 * (x * x - y * y), 5, 5)


def vault() -> Target:
    """Half a cylinder on its side, sloping; symmetric in x."""
    return height_field("vault", lambda x, y: np.sqrt(np.maximum(25.0 - x * x, 0)) - 5.0 + 0.06 * y, 4.5, 5)


def dome() -> Target:
    """An ellipse of a dome, steeper on one side; symmetric in x."""
    return height_field(
        "dome",
        lambda x, y: -3.5 * (x * x / 25 + (y + 1) ** 2 / 36) - 0.075 * np.maximum(y, 0) ** 1.5 + 3.5 / 36,
        5,
        6,
        inside=lambda x, y: x * x / 25 + y * y / 36 < 1,
    )


# --- tuned on --------------------------------------------------------------------------------------------------------


def wave() -> Target:
    """A corrugation that fades out; symmetric in x."""
    return height_field("wave", lambda x, y: 1.1 * np.cos(0.9 * x) * np.exp(-0.04 * y * y) - 1.1 + 0.05 * y, 5, 4)


def funnel() -> Target:
    """Steep in the middle, flat at the rim; symmetric in x, y and the diagonals."""
    return height_field(
        "funnel",
        lambda x, y: -3.0 * np.exp(-0.16 * (x * x + y * y)) + 3.0,
        5,
        5,
        inside=lambda x, y: x * x + y * y < 25,
    )


def leaf() -> Target:
    """A long blade, bent along and across; symmetric in x."""
    return height_field(
        "leaf",
        lambda x, y: 0.16 * x * x - 0.05 * y * y + 0.12 * y,
        3.5,
        7,
        inside=lambda x, y: x * x / 12 + y * y / 49 < 1,
    )


# --- on which nothing was tuned --------------------------------------------------------------------------------------


def ripple() -> Target:
    """Rings around the middle; symmetric in x, y and the diagonals."""
    return height_field(
        "ripple",
        lambda x, y: 0.9 * np.cos(1.1 * np.sqrt(x * x + y * y)) - 0.9,
        5,
        5,
        inside=lambda x, y: x * x + y * y < 25,
    )


def scarf() -> Target:
    """A strip that is bent up at its ends and down at its sides; symmetric in x and y."""
    return height_field("scarf", lambda x, y: 0.006 * (x * x - 4) * (16 - y * y), 6, 4)


def canopy() -> Target:
    """Three bulges in a row, of different height; symmetric in x."""
    return height_field(
        "canopy",
        lambda x, y: (
            1.6 * np.exp(-0.3 * (x * x + (y - 4) ** 2))
            + 2.2 * np.exp(-0.25 * (x * x + y * y))
            + 1.2 * np.exp(-0.3 * (x * x + (y + 4) ** 2))
            - 2.2
        ),
        4,
        6.5,
    )
